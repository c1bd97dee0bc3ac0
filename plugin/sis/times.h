/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The times of a telegram, and how exact they are. */

#ifndef SIS_TIMES_H
#define SIS_TIMES_H

#include "sertap/record.h"

/* A duration with its lower and upper bound, in ns. */
typedef struct {
    int64_t least, most;
} sis_span_t;

#define SIS_ANY_TIME INT64_MAX /* upper bound, if there is none */
#define SIS_SET_BACK INT64_MIN /* lower bound of a duration during which the clock was set back */

/* A telegram's characters. Times are ns since 1970. */
typedef struct {
    const sertap_record_t *record; /* NULL: only the packet's time is known */
    unsigned first;                /* of the record's characters */
    unsigned count;
    int64_t character; /* ns that a character takes; 0: unknown */
    int64_t shortest;  /* at least */
    int64_t begin;     /* of its first character, as recorded */
    int64_t begin_earliest;
    int64_t begin_latest;
    int64_t end; /* of its last character, as recorded: the upper bound */
    int64_t end_earliest;
    bool is_bounded; /* otherwise the earliest and latest times are unknown */
} sis_times_t;

/* The interval before one character of a telegram. */
typedef struct {
    unsigned at;      /* number of the character in the telegram, from 1 */
    int64_t recorded; /* ns */
    sis_span_t span;
    int64_t weight;    /* ns; the longest interval is the one with the largest value */
    bool is_exact;     /* both characters were read alone */
    bool is_saturated; /* it was longer than `recorded` */
} sis_interval_t;

/* No document says whether the character that ends a duration counts: two verdicts. */
typedef struct {
    sis_verdict_t whole; /* with it */
    sis_verdict_t idle;  /* without it */
} sis_readings_t;

/* Where a duration begins to count: the preference sis.tza_from. */
typedef enum { SIS_FROM_UNKNOWN, SIS_FROM_END, SIS_FROM_START } sis_from_t;

/* The times of the telegram at the beginning of `tvb`. `before`: of the telegram before it in the packet;
 * NULL: none. */
sis_times_t sis_times(tvbuff_t *tvb, packet_info *pinfo, unsigned length, const sis_times_t *before);

/* The interval that is, or may be, the longest of a telegram: one that exceeds the limit where any does.
 * With the verdict over all of them. at is 0 where there is none. */
typedef struct {
    sis_interval_t interval;
    sis_verdict_t verdict;
    sis_readings_t readings;
    unsigned restart_at; /* where a telegram seems to begin after too long a pause; 0: nowhere */
    unsigned unknown_at; /* the character before which the interval is unknown and matters; 0: none */
} sis_longest_t;

/* The limit in ns; 0: none, and nothing exceeds it. Only where times->record is not NULL. */
sis_longest_t sis_longest(wmem_allocator_t *scope, const sis_times_t *times, int64_t limit, sis_from_t from);

/* Whether a duration up to this telegram was measured: in a read of the tap all characters have its time,
 * and a clock that was set back measures nothing. */
bool sis_is_measured(int64_t elapsed, const sis_times_t *times);

/* Of a duration. After a clock was set back it is not known. */
sis_span_t sis_span(int64_t least, int64_t most);

/* From the end of one telegram to the beginning of another. */
sis_span_t sis_span_between(int64_t end_earliest, int64_t end, const sis_times_t *after);

/* exceeded, ok or unresolved (see docs/verdicts.md); the limit in ns. */
sis_verdict_t sis_judge(sis_span_t span, int64_t limit);

/* Of a duration that ends with a character; `character` in ns, 0: unknown. */
sis_readings_t sis_judge_both(sis_span_t whole, int64_t character, int64_t limit);

/* Where nobody knows what counts, what both say. */
sis_verdict_t sis_verdict(sis_readings_t readings, sis_from_t from);

#endif
