/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a line of the capture, record by record. */

#ifndef SERTAP_LINE_H
#define SERTAP_LINE_H

#include "sertap/record.h"

/* First pass: the latest packets of this record's interface that may hide a frame; 0: none. */
typedef struct {
    uint32_t lost_in;     /* the last before or in which characters were lost */
    uint32_t unframed_in; /* the last with enough other characters to have been a frame */
    uint32_t begun_in;    /* the last event that says that a capture begins: nothing is known of before */
} sertap_disturbance_t;

sertap_disturbance_t sertap_disturbance(const sertap_record_t *record);

/* First pass: the limits that the user told of this record's interface, as the event says them. */
typedef struct {
    uint32_t told_in; /* the last such event; 0: none */
    const char *text;
} sertap_limits_t;

const sertap_limits_t *sertap_limits(const sertap_record_t *record);

/* First pass: how much of the last second, or of the time since the line's first character, had characters
 * on the line, in percent; negative: unknown. */
float sertap_load(const sertap_record_t *record);

/* A line of the capture as a number: its section, and in the lower half its interface. */
uint64_t sertap_line_key(const packet_info *pinfo);

/* The line, or both directions of a full-duplex tap, which are two successive interfaces. */
uint64_t sertap_bus_key(packet_info *pinfo);

/* What is kept of that in such a map: `size` bytes that begin with its number. */
void *sertap_kept_of_bus(wmem_map_t *buses, packet_info *pinfo, size_t size);

/* First pass: takes a record into account. */
void sertap_line_note(packet_info *pinfo, sertap_record_t *record);

/* After that, in all passes: the silence before a record whose first interval is longer than it can be
 * stored, from the time of the record before it. */
void sertap_line_find_silence(packet_info *pinfo, sertap_record_t *record);

#endif
