/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A telegram: what its header says, and what is found out about it while its packet is dissected. */

#ifndef SIS_TELEGRAM_H
#define SIS_TELEGRAM_H

#include "sis/frame.h"
#include "sis/times.h"

/* Telegram control (chapter 2.1). */
#define SIS_CONTROL_SUBADDRESSES 0x07
#define SIS_CONTROL_NUMBER       0x08
#define SIS_CONTROL_REACTION     0x10

/* Passing on the right to send commands (chapter 2.4); what is in it is not specified. */
#define SIS_TOKEN_PASSING 0x0F

struct sis_record;

/* What the timing of a telegram says; times in ns. */
typedef struct {
    bool has_silence; /* before the telegram */
    int64_t silence;
    sis_longest_t longest; /* of its intervals; at is 0 where they are not known or nobody asks */
    int64_t tza;           /* limits; 0: not known, so there is no verdict */
    int64_t trs;
    bool has_reaction_time;
    sis_verdict_t trs_verdict;
    int64_t wait; /* TwM; negative: none */
} sis_timing_t;

/* An error code of an element of service 0x04. */
typedef struct sis_error {
    uint32_t code;
    const char *text;
    const struct sis_error *next;
} sis_error_t;

/* One telegram; the tap "sis" gets it. */
typedef struct sis_telegram {
    const struct sis_telegram *before; /* in the same packet; NULL: none */
    tvbuff_t *tvb;                     /* begins with it */
    unsigned length;                   /* bytes that are there */
    unsigned declared;                 /* bytes it says it has; 0: it does not say */
    bool is_good;                      /* start character, equal lengths, all of it, checksum */
    uint8_t control;
    uint8_t service;
    uint8_t sender;
    uint8_t receiver;
    uint8_t subaddress_count;
    uint8_t last_address; /* receiver or last subaddress: who is meant in the end */
    uint8_t number;       /* of the telegram; 0: none */
    bool is_reaction;
    uint8_t talker; /* who really sends: a reaction keeps the command's addresses */
    uint8_t listener;
    unsigned body_offset; /* of the useful data */
    sis_times_t times;
    const struct sis_record *record;
    sis_timing_t timing;
    const char *status_text; /* of a reaction; NULL: it has none */
    const char *error_text;  /* NULL: there is no error code */
    uint32_t error;
    const sis_error_t *errors; /* of its elements, the last first */
    wmem_list_t *accesses;     /* to parameters, sis_access_t; NULL: nobody has asked */
} sis_telegram_t;

/* Several telegrams may be in one packet; kept while it is dissected. */
typedef struct {
    unsigned count;             /* of those whose exchange was looked for */
    const sis_telegram_t *last; /* that has been dissected; NULL: none */
} sis_packet_t;

sis_packet_t *sis_packet(packet_info *pinfo);

/* Reads the header of a telegram that has all 8 bytes of it. */
sis_telegram_t *sis_telegram_read(tvbuff_t *tvb, packet_info *pinfo);

#endif
