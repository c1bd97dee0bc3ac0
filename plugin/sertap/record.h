/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A record of the serial tap: its header, and the times of its characters. */

#ifndef SERTAP_RECORD_H
#define SERTAP_RECORD_H

#include "protocol/fields.h"
#include "sertap/time.h"

/* The state of a line in the first pass: line.c. */
struct sertap_line;

/* One record, decoded. If it is cut off, it has fewer characters than it declares. If the capture cut the
 * packet (its snapshot length), fewer of these have a value here. */
typedef struct {
    tvbuff_t *tvb;
    uint8_t type;
    uint8_t line;
    uint8_t framing;
    uint32_t baud;
    uint8_t data_bits;
    uint8_t parity;
    uint8_t stop_half_bits;
    uint32_t uncertainty; /* ns; SERTAP_UNCERTAINTY_UNKNOWN */
    uint16_t event;
    unsigned declared;     /* number of characters according to the record */
    unsigned count;        /* characters of the record */
    unsigned values;       /* characters whose value is here */
    unsigned timed;        /* characters whose interval and flags are here as well */
    unsigned data_offset;  /* of the values */
    unsigned times_offset; /* of the intervals, 4 bytes each, ns */
    unsigned flags_offset;
    struct sertap_line *known; /* NULL after the first pass */
    uint8_t flags;             /* of all its characters, ORed */
    unsigned first_at[8];      /* for each bit of a flag: the first character that has it */
    uint64_t duration;         /* ns, from the first character to the last */
    bool is_duration_known;    /* false: at least that */
    int64_t silence;           /* ns, before the first character, since the one before it on the line */
    bool is_silence_known;     /* false: at least that */
    uint32_t interval_max;     /* ns, longest between two characters of this record */
    unsigned interval_max_at;  /* before this character; 0: there is none */
} sertap_record_t;

#define SERTAP_UNCERTAINTY_UNKNOWN 0xFFFFFFFF

/* The record of this packet; NULL if it has none. Valid while the packet is dissected. */
const sertap_record_t *sertap_record(packet_info *pinfo);

/* The index of the first character of the record in `part`, a subset of its payload. */
unsigned sertap_index(const sertap_record_t *record, tvbuff_t *part);

/* The interval before a character of the record, from 0, in ns. Before the first one it is the silence of the
 * line. */
int64_t sertap_interval(const sertap_record_t *record, unsigned at);

uint8_t sertap_flags(const sertap_record_t *record, unsigned at);

/* The duration of a character, including start and stop bits; 0 if the rate is unknown. */
int64_t sertap_character_ns(const sertap_record_t *record);

/* "8E1" */
const char *sertap_format_text(wmem_allocator_t *scope, const sertap_record_t *record);

/* Whether it is an event that tells of a loss. */
bool sertap_is_loss(const sertap_record_t *record);

/* Fills in the longest interval, the duration and the errors, from its arrays. */
void sertap_record_survey(sertap_record_t *record);

#endif
