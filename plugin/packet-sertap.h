/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The serial tap's link layer: what its statistics see of a record. */

#ifndef PACKET_SERTAP_H
#define PACKET_SERTAP_H

#include "sertap-time.h"

typedef enum { SERTAP_FRAME, SERTAP_OTHER, SERTAP_EVENT } sertap_type_t;

/* Events that leave a gap. */
#define SERTAP_CHARACTERS_LOST 3
#define SERTAP_ADAPTER_LOST    4

#define SERTAP_SAME_READ          0x01
#define SERTAP_CHARACTER_ERROR    0x02
#define SERTAP_BREAK              0x04
#define SERTAP_LOST_BEFORE        0x08
#define SERTAP_UNLOCATED_ERROR    0x10
#define SERTAP_INTERVAL_UNKNOWN   0x20
#define SERTAP_INTERVAL_SATURATED 0x40

/* What is known of a line in the first pass: sertap-line.c. */
struct sertap_line;

/* One record, decoded. Where it is cut, fewer characters are there than it declares. */
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
    unsigned declared;     /* characters the record says it has */
    unsigned count;        /* characters whose value is there */
    unsigned timed;        /* characters whose interval and flags are there, too */
    unsigned data_offset;  /* of the values */
    unsigned times_offset; /* of the intervals, 4 bytes each, ns */
    unsigned flags_offset;
    struct sertap_line *known; /* NULL after the first pass */
    uint8_t flags;             /* of all its characters, ORed */
    unsigned first_at[8];      /* by bit of a flag: the first character that has it */
    uint64_t duration;         /* ns, from the first character to the last */
    uint32_t interval_max;     /* ns, longest between two characters of this record */
    unsigned interval_max_at;  /* before this character; 0: there is none */
} sertap_record_t;

#define SERTAP_UNCERTAINTY_UNKNOWN 0xFFFFFFFF

/* The record that this packet is; NULL where it is none. Valid while the packet is dissected. */
const sertap_record_t *sertap_record(packet_info *pinfo);

/* The first of the record's characters that `part`, cut out of its payload, has. */
unsigned sertap_index(const sertap_record_t *record, tvbuff_t *part);

/* How long one character takes, start and stop bits included; 0 where the rate is not known. */
int64_t sertap_character_ns(const sertap_record_t *record);

/* First pass: packets of this record's interface so far that may hide a frame; 0: none. */
typedef struct {
    uint32_t lost_in;     /* the last before or in which characters were lost */
    uint32_t unframed_in; /* the last with so many other characters that they may have been a frame */
} sertap_disturbance_t;

sertap_disturbance_t sertap_disturbance(const sertap_record_t *record);

/* First pass: in which part of the last second, or of the time since the line's first character, there were
 * characters on the line, in percent; negative: not known. */
float sertap_load(const sertap_record_t *record);

/* A line of the capture as a number: its section, and in the lower half its interface. */
uint64_t sertap_line_key(const packet_info *pinfo);

/* The lines of the capture in the order in which they came, from 0. Only of a packet with a record. */
unsigned sertap_line_number(const packet_info *pinfo);

/* First pass: takes a record into account. */
void sertap_line_note(packet_info *pinfo, sertap_record_t *record);

void sertap_register(void);
void sertap_line_register(void);
void sertap_statistics_register(void);

#endif
