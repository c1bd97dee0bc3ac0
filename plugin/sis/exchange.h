/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Relations between telegrams: command and reaction, repeats, routed telegrams. First pass only. */

#ifndef SIS_EXCHANGE_H
#define SIS_EXCHANGE_H

#include "sis/record.h"

/* What came on a bus since its last good telegram: a station may answer it (chapter 2.4). */
typedef struct {
    bool is_there;
    uint32_t command_in; /* the last is a command with a legible header; 0: it is not */
    uint8_t head_length;
    uint8_t head[16]; /* of that command: its static bytes, subaddresses and number */
} sis_damage_t;

/* One line, or one TCP connection. */
typedef struct sis_bus {
    uint64_t key;
    uint32_t number; /* of all, from 1 */
    bool is_connection;
    uint32_t damaged_in; /* the last damaged telegram, or characters that may have been one; 0: none */
    uint32_t damaged_count;
    uint32_t lost_in; /* the last loss of characters; 0: none */
    sis_damage_t damage;
    wmem_map_t *last;                  /* command of each master */
    const struct sis_exchange *newest; /* command of all masters; NULL: none yet */
    /* Data of other files; each owner makes its own on first use. */
    struct sis_learned *learned; /* station.c */
    struct sis_told *told;       /* bus.c */
    struct sis_cycles *cycles;   /* cycle.c */
    struct sis_transfer *open;   /* sequence.c: those under way, the oldest first */
} sis_bus_t;

/* Two stations, including the route between them: a drive behind a router is not the router. */
typedef struct {
    uint64_t bus;
    uint8_t low, high;
    uint8_t subaddress_count;
    uint8_t subaddresses[7];
    bool is_before; /* this file: no repeat, no time to what is in it */
    uint8_t zero[5];
} sis_stream_key_t;

/* The commands of one direction of a stream. */
typedef struct {
    sis_exchange_t *last; /* NULL: none yet */
    uint8_t *bytes;       /* of that command */
    unsigned length;
    const sis_request_t *same; /* of the command before that, if it had the same bytes; else NULL */
    sis_switch_t phase_switch;
} sis_direction_t;

/* Two stations in contact, by the direction of the commands. */
typedef struct sis_stream {
    sis_stream_key_t key;
    uint32_t number;
    uint32_t idle_in; /* the last switch to a phase in which nothing moves; 0: none */
    sis_bus_t *bus;
    sis_direction_t from[2];
} sis_stream_t;

/* The direction of an exchange. */
sis_direction_t *sis_exchange_direction(const sis_exchange_t *exchange);

/* The line or connection of a packet. */
sis_bus_t *sis_exchange_bus(packet_info *pinfo);

/* Finds the relations of a telegram. A damaged one may have been the reaction that a command waits for. */
void sis_exchange_learn(sis_record_t *record, sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo,
                        const sis_telegram_t *telegram);

#endif
