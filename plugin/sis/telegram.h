/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A telegram: its header, and what is found while its packet is dissected. */

#ifndef SIS_TELEGRAM_H
#define SIS_TELEGRAM_H

#include "sis/frame.h"
#include "sis/times.h"

/* Passing on the right to send commands (chapter 2.4); its contents are not specified. */
#define SIS_TOKEN_PASSING 0x0F

#define SIS_CANCEL 0x01 /* cancel data transmission (chapter 4) */
#define SIS_LIST   0x04 /* a list of services (chapter 7) */

struct sis_record;

extern int sis_tap; /* receives every sis_telegram_t */

/* The timing of a telegram; times in ns. */
typedef struct {
    bool has_silence;      /* before the telegram */
    bool is_silence_known; /* false: it was longer */
    int64_t silence;
    sis_longest_t longest; /* of its intervals; at is 0 if they are unknown or not needed */
    int64_t tza;           /* limits; 0: unknown, so there is no verdict */
    int64_t trs;
    bool has_reaction_time;
    sis_verdict_t trs_verdict;
    int64_t wait; /* TwM; negative: none */
    int64_t tmas; /* limit of its master control word; 0: no verdict */
    sis_verdict_t tmas_verdict;
} sis_timing_t;

/* An error code of an element of service 0x04. */
typedef struct sis_error {
    uint32_t code;
    const char *text;
    const struct sis_error *next;
} sis_error_t;

/* One telegram; the tap "sis" receives it. */
typedef struct {
    tvbuff_t *tvb;     /* begins with it; what is no part of it may follow */
    unsigned length;   /* of its bytes in the packet, without those that follow it */
    unsigned declared; /* declared bytes; 0: unknown */
    bool is_before;    /* from before this file: learned from, not counted, not judged */
    bool is_good;      /* start character, equal lengths, complete, checksum */
    uint8_t control;
    uint8_t service;
    uint8_t sender;
    uint8_t receiver;
    uint8_t subaddress_count;
    uint8_t last_address; /* receiver or last subaddress: the final receiver */
    uint8_t number;       /* of the telegram; 0: none */
    bool is_reaction;
    uint8_t talker; /* the real sender: a reaction keeps the command's addresses */
    uint8_t listener;
    unsigned body_offset; /* of the useful data */
    sis_times_t times;
    const struct sis_record *record;
    sis_timing_t timing;
    const char *status_text; /* of a reaction; NULL: it has none */
    const char *error_text;  /* NULL: there is no error code */
    uint32_t error;
    const sis_error_t *errors; /* of its elements, the last first */
} sis_telegram_t;

/* Several telegrams may be in one packet; kept while it is dissected. */
typedef struct {
    struct sis_record *found;   /* of the telegram whose exchange was searched for last; NULL: none */
    const sis_telegram_t *last; /* the last dissected telegram; NULL: none */
    unsigned telegrams;         /* dissected so far, and what stands in the place of one */
    struct sis_part *parts; /* what they tell programs (told.c): the first, and the present one; NULL: none */
    struct sis_part *part;
} sis_packet_t;

sis_packet_t *sis_packet(packet_info *pinfo);

/* Reads the header of a telegram with all its 8 bytes. */
sis_telegram_t *sis_telegram_read(tvbuff_t *tvb, packet_info *pinfo);

/* Which fields are whose, where TCP has put several telegrams into a packet: `tshark -T fields` prints all
 * values of a field together. So each telegram but the first says which fields it has, and how many values of
 * each: the rest is of the first. Call it last. */
void sis_tell_packed(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree);

#endif
