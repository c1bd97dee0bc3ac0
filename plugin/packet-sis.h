/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SIS telegram: what its header says, as the other files of the dissector use it. */

#ifndef PACKET_SIS_H
#define PACKET_SIS_H

#include "sis-times.h"

#include <epan/prefs.h>

#define SIS_START         0x02
#define SIS_STATIC_LENGTH 8u /* of the header; DatLW counts what comes after it */

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
} sis_telegram_t;

/* Several telegrams may be in one packet; kept while it is dissected. */
typedef struct {
    unsigned count;             /* of those whose exchange was looked for */
    const sis_telegram_t *last; /* that has been dissected; NULL: none */
} sis_packet_t;

sis_packet_t *sis_packet(packet_info *pinfo);

extern int proto_sis;
extern dissector_handle_t sis_handle; /* telegrams, one after the other, as much as there is */
extern int sis_tap;

/* How long the telegram at offset says it is; 0: not told (too short, or its two lengths differ). */
unsigned sis_declared_length(tvbuff_t *tvb, unsigned offset);

/* Sum of bytes modulo 256; 0 for a telegram with a good checksum. */
uint8_t sis_sum(tvbuff_t *tvb, unsigned offset, unsigned length);

/* A whole telegram with start character, equal lengths and a zero sum. */
bool sis_is_good(tvbuff_t *tvb, unsigned offset);

/* One telegram; `tvb` begins with it and holds nothing of the next. Adds to the info column. */
void sis_dissect_telegram(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree);

void sis_register(void);
void sis_transports_register_preferences(module_t *module);
void sis_transports_handoff(void);
void sis_statistics_register(void);
void sis_tables_register(void);
void sis_follow_register(void);

#endif
