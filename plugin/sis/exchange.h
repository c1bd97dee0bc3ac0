/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Relations between telegrams: command and reaction, repeats, routed telegrams. */

#ifndef SIS_EXCHANGE_H
#define SIS_EXCHANGE_H

#include "parameters/parameters.h"
#include "sis/routes.h"
#include "sis/telegram.h"

/* What a command asks for. Its reaction repeats only part of it, so the exchange keeps it. */
typedef struct sis_request {
    uint8_t service;
    uint8_t subservice;
    uint8_t element;
    uint8_t device;
    uint8_t phase;
    bool has_device : 1;
    bool has_subservice : 1; /* of 0x01: the service to cancel */
    bool is_ambiguous : 1;   /* of 0x01: whether subservice is that, or the device */
    bool has_ident : 1;
    bool has_address : 1;
    bool has_setting : 1;       /* of 0x03: complete data of the subservice */
    bool is_last : 1;           /* of a parameter: no more pieces follow */
    bool is_to_be_repeated : 1; /* its reaction refuses it, and the same will come again */
    uint16_t test_ms;
    sis_ident_t ident;
    uint32_t address; /* of the memory */
    uint32_t setting; /* of 0x03: ms or Bd; of Read flash: bytes */
    uint32_t segment; /* of a list: requested offset and length; 0: all of it */
    /* Known about the parameter when the command was sent; NULL: nothing. */
    const sis_known_t *known;
    const struct sis_twin *twin; /* the same of a device of its type; NULL: nothing */
    const uint8_t *written;      /* all data of a parameter, in file scope; NULL: not written, or unknown */
    unsigned written_length;
    uint32_t transfer;        /* of sequential telegrams, this is a step of it; 0: none */
    struct sis_request *next; /* of the following element of service 0x04 */
    struct sis_request *list; /* of the first element of service 0x04, or the next subservice of 0x03 */
} sis_request_t;

/* A phase switch under way (chapter 8.5). */
typedef struct {
    uint32_t command_in; /* 0: none */
    int64_t begin;       /* ns since 1970 */
    uint8_t to;
} sis_switch_t;

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
    struct sis_learned *learned; /* learned.c */
    struct sis_told *told;       /* bus.c */
    struct sis_cycles *cycles;   /* timing.c */
    wmem_list_t *open;           /* sequence.c */
} sis_bus_t;

/* Data of commands through routers only. */
typedef struct {
    sis_waiting_t waiting;          /* for the next router's version */
    struct sis_exchange *above;     /* the same exchange one level above; NULL: none */
    struct sis_exchange *forwarded; /* and one level below */
} sis_routing_t;

/* A command and its reaction, as far as the capture has them. Lives as long as the file. A capture has
 * millions, so the fields leave no gaps. */
typedef struct sis_exchange {
    struct sis_stream *stream;
    struct sis_exchange *first; /* the first of the same commands, which this repeats; NULL: none */
    struct sis_exchange *again; /* the next repeat; NULL: none */
    sis_routing_t *routing;     /* NULL: no router */
    sis_request_t *request;
    int64_t command_end;   /* when its last character came, ns since 1970 */
    int64_t reaction_time; /* ns, valid if has_time */
    int64_t wait;          /* TwM, ns: of a repeat, or after a broadcast; negative: none, or not measured */
    uint32_t command_in;
    uint32_t reaction_in;      /* 0: none */
    uint32_t next_command_in;  /* the master continued without a reaction; 0: no */
    uint32_t gave_up;          /* the master's command before, unanswered until now; 0: none */
    uint32_t command_duration; /* ns */
    uint32_t command_spread;   /* ns: so much earlier its last character can have come; UINT32_MAX: unknown */
    uint8_t path[8];           /* from the receiver through subaddresses to the addressed station */
    uint8_t path_length;
    uint8_t station;         /* the final receiver */
    uint8_t gave_up_station; /* the receiver of `gave_up` */
    uint8_t direction;       /* in its stream */
    bool has_time;
    bool is_measured;         /* reaction_time: command and reaction came in different reads */
    bool is_reaction_damaged; /* uncertain: a damaged telegram came before the next command */
    bool needs_reaction;      /* no group or broadcast, and no token, which is not specified */
    bool is_reaction_kept; /* its telegram number is that of the command before: the slave sends what it sent
                              then */
    bool is_kept_reaction_seen;
} sis_exchange_t;

/* A transfer of sequential telegrams that ended before its last piece. */
typedef struct sis_ended {
    const struct sis_ended *next; /* that ended at the same step */
    uint32_t begun_in;
    const char *reason;
} sis_ended_t;

/* The results of the first pass that few services have: that of a telegram, or of an element of a list. */
typedef struct sis_step {
    struct sis_step *next;            /* of the same telegram */
    const sis_ended_t *ended;         /* the transfers that this ended, unfinished; NULL: none */
    const sis_switch_t *phase_switch; /* the switch that this polls; NULL: none */
    unsigned element;                 /* its number in the list; 0: the service of the telegram */
    uint32_t transfer;                /* number of the transfer that this is a piece of; 0: none */
    bool is_piece_repeated;
    bool is_piece_missing;
    bool is_doubtful;   /* whether the transfer went on */
    bool is_begun_anew; /* the transfer of this last piece, after a refused one */
    bool is_switch_end; /* it ended here, successfully or not */
} sis_step_t;

/* What is known of a reaction that belongs to no exchange. */
typedef enum {
    SIS_UNASKED,
    SIS_TO_DAMAGED, /* a damaged command, as a point-to-point station answers it */
    SIS_OWN_NUMBER, /* a command to the point-to-point address, answered with another one */
} sis_origin_t;

/* The results of the first pass that few telegrams have. */
typedef struct {
    sis_step_t *steps;
    struct sis_cycle *cycle; /* of the master control word; NULL: none */
    uint32_t routed_from;    /* of a reaction: the one from one level below */
    uint32_t damaged_in;     /* of a reaction: the damaged command that it answers; 0: not known */
    sis_origin_t origin;
} sis_rare_t;

/* The results of the first pass for one telegram. A capture has millions, so what few have is elsewhere. */
typedef struct sis_record {
    struct sis_record *next;             /* of the next telegram in the same packet; NULL: none */
    sis_exchange_t *exchange;            /* NULL: a damaged telegram, or a reaction without a command */
    const struct sis_settings *settings; /* valid for this telegram; NULL: none */
    sis_rare_t *rare;                    /* NULL: none of them; see sis_rare() */
    uint32_t reaction_before;            /* the command had been answered already, in this packet */
    float load;                          /* percent; negative: not known */
    uint8_t service;                     /* identifies the telegram in later passes */
    bool is_reaction;
} sis_record_t;

_Static_assert(sizeof(sis_record_t) <= 48, "one byte more costs 16 bytes a telegram");

/* Two stations, including the route between them: a drive behind a router is not the router. */
typedef struct {
    uint64_t bus;
    uint8_t low, high;
    uint8_t subaddress_count;
    uint8_t subaddresses[7];
    uint8_t zero[6];
} sis_stream_key_t;

/* Two stations in contact, by the direction of the commands. */
typedef struct sis_stream {
    sis_stream_key_t key;
    uint32_t number;
    uint32_t idle_in; /* the last switch to a phase in which nothing moves; 0: none */
    sis_bus_t *bus;
    struct {
        sis_exchange_t *last; /* command; NULL: none yet */
        uint8_t *bytes;       /* of that command */
        unsigned length;
        /* of the command before that, if it had the same bytes; else NULL */
        const sis_request_t *same;
        sis_switch_t phase_switch;
        struct sis_transfer *transfers; /* of sequential telegrams, under way */
    } from[2];
} sis_stream_t;

/* Finds the relations of a telegram: in the first pass from what is known so far, later as found then. For
 * a damaged telegram: it may have been the reaction that a command waits for. Never NULL. */
sis_record_t *sis_exchange_find(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* The rare results of a telegram: to read, and to write. Never NULL. */
const sis_rare_t *sis_rare(const sis_record_t *record);
sis_rare_t *sis_make_rare(sis_record_t *record);

/* The rare results of one service of the telegram, by its element; 0: of the telegram itself. */
const sis_step_t *sis_step(const sis_record_t *record, unsigned element);
sis_step_t *sis_make_step(sis_record_t *record, unsigned element);

/* The same exchange one level above and one level below, if there are routers; NULL: none is known. */
sis_exchange_t *sis_exchange_above(const sis_exchange_t *exchange);
sis_exchange_t *sis_exchange_below(const sis_exchange_t *exchange);

/* Whether a reaction has its command's addresses swapped: then its sender really sent it. */
bool sis_exchange_is_swapped(const sis_record_t *record, const sis_telegram_t *telegram);

/* What the command before this one asked for, if it had the same bytes: while this one is dissected for the
 * first time. NULL: it had not. */
const sis_request_t *sis_exchange_same(const sis_exchange_t *exchange);

/* Keeps what a command asks for, once. */
void sis_exchange_keep(sis_exchange_t *exchange, const sis_request_t *request);

/* First pass: the line or connection of a packet. */
sis_bus_t *sis_exchange_bus(packet_info *pinfo);

/* Adds the known relations to the tree, and notes. */
void sis_exchange_show(const sis_record_t *record, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree,
                       proto_item *root, const sis_telegram_t *telegram, wmem_strbuf_t *marks);

#endif
