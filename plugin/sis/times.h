/* SPDX-License-Identifier: GPL-2.0-or-later */
/* When a telegram came, and how exactly that is known. */

#ifndef SIS_TIMES_H
#define SIS_TIMES_H

#include "sertap/record.h"

/* How long something took at least and at most, in ns. */
typedef struct {
    int64_t least, most;
} sis_span_t;

#define SIS_ANY_TIME INT64_MAX /* most, where there is no bound */

typedef enum { SIS_TIME_OK, SIS_TIME_EXCEEDED, SIS_TIME_UNRESOLVED } sis_verdict_t;

/* A telegram's characters. Times are ns since 1970. */
typedef struct {
    const sertap_record_t *record; /* NULL: only the time of its packet is known */
    unsigned first;                /* of the record's characters */
    unsigned count;
    int64_t begin; /* of its first character, as recorded */
    int64_t begin_earliest;
    int64_t begin_latest;
    int64_t end; /* of its last character, as recorded: the latest it can have come */
    int64_t end_earliest;
    bool is_bounded; /* else the earliest and latest times are not known */
} sis_times_t;

/* The interval before one character of a telegram. */
typedef struct {
    unsigned at;      /* number of the character in the telegram, from 1 */
    int64_t recorded; /* ns */
    sis_span_t span;
    int64_t weight;    /* ns; the interval with the largest is the longest */
    bool is_exact;     /* both its characters came alone, each in a read of its own */
    bool is_saturated; /* it was longer than `recorded` */
} sis_interval_t;

/* The times of the telegram that `tvb` begins with. */
sis_times_t sis_times(tvbuff_t *tvb, packet_info *pinfo, unsigned length);

/* The interval that is, or may be, the longest of a telegram: one that exceeds the limit where there is one.
 * With the verdict over all of them. at is 0 where there is none. Only where times->record is not NULL. */
typedef struct {
    sis_interval_t interval;
    sis_verdict_t verdict;
    unsigned restart_at; /* where after too long a pause a telegram seems to begin; 0: nowhere */
    unsigned unknown_at; /* before which character nobody knows how long it was, and it matters; 0: none */
} sis_longest_t;

sis_longest_t sis_longest(const sis_times_t *times, int64_t limit);

/* From the end of one telegram to the beginning of another. */
sis_span_t sis_span_between(int64_t end_earliest, int64_t end, const sis_times_t *after);

/* exceeded, ok or unresolved (see README.md); the limit in ns. */
sis_verdict_t sis_judge(sis_span_t span, int64_t limit);

#endif
