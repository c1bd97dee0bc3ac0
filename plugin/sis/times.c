/* SPDX-License-Identifier: GPL-2.0-or-later */
/* When characters came, and how exactly that is known.
 *
 * The time of a character is that of the read that delivered it. The character came no later, and earlier by
 * at most the uncertainty of the record. Characters of one read follow one another by at least a character
 * time. So the i-th of k came at least (k - i) character times before the read. If a read is longer than its
 * uncertainty, the uncertainty was too small. */

#include "sis/times.h"

#include "sis/frame.h"

/* Character times are taken slightly short: a transmitter may be that much faster than its nominal rate. */
#define SHORTEST_CHARACTER(ns) ((ns)*98 / 100)

static uint8_t
flags_of(const sertap_record_t *record, unsigned character)
{
    return compat_get_uint8(record->tvb, record->flags_offset + character);
}

static int64_t
interval_of(const sertap_record_t *record, unsigned character)
{
    return tvb_get_ntohl(record->tvb, record->times_offset + 4 * character);
}

/* The number of characters of the telegram from the read that begins with `character`. */
static unsigned
read_size(const sis_times_t *times, unsigned character)
{
    unsigned end = times->first + times->count, next = character + 1;

    if (!(times->record->flags & SERTAP_SAME_READ))
        return 1;
    while (next < end && flags_of(times->record, next) & SERTAP_SAME_READ)
        next++;
    return next - character;
}

/* A read of some of the telegram's characters: how long before it the first may have come, and how much of
 * that time the others need. */
typedef struct {
    unsigned size;
    int64_t uncertainty; /* ns, of the first character */
    int64_t others;      /* ns, from the first character to the last, at least */
} read_t;

static read_t
read_at(const sis_times_t *times, unsigned character)
{
    int64_t uncertainty = times->record->uncertainty;
    read_t read = {.size = read_size(times, character)};

    read.others = (read.size - 1) * SHORTEST_CHARACTER(sertap_character_ns(times->record));
    read.uncertainty = MAX(uncertainty, read.others);
    return read;
}

static void
bound_begin(sis_times_t *times)
{
    read_t read = read_at(times, times->first);

    times->begin_earliest = times->begin - read.uncertainty;
    times->begin_latest = times->begin - read.others;
}

static void
bound_end(sis_times_t *times)
{
    unsigned last = times->first + times->count - 1;
    read_t read;

    while (last > times->first && flags_of(times->record, last) & SERTAP_SAME_READ)
        last--;
    read = read_at(times, last);
    times->end_earliest = times->end - read.uncertainty + read.others;
}

sis_times_t
sis_times(tvbuff_t *tvb, packet_info *pinfo, unsigned length)
{
    const sertap_record_t *record = sertap_record(pinfo);
    sis_times_t times = {.begin = sertap_ns(&pinfo->abs_ts)};
    unsigned first = record != NULL ? sertap_index(record, tvb) : 0;

    times.end = times.begin;
    if (record == NULL || length == 0 || first + length > record->timed || first + length < first)
        return times;
    times.record = record;
    times.first = first;
    times.count = length;
    for (unsigned i = 1; i <= first; i++)
        times.begin += interval_of(record, i);
    times.end = times.begin + (int64_t)record->duration;
    if (length < record->timed) {
        times.end = times.begin;
        for (unsigned i = first + 1; i < first + length; i++)
            times.end += interval_of(record, i);
    }
    times.is_bounded = record->uncertainty != SERTAP_UNCERTAINTY_UNKNOWN;
    if (times.is_bounded) {
        bound_begin(&times);
        bound_end(&times);
    }
    return times;
}

/* Between the last character of one read and the first of the next. */
static sis_span_t
span_before(const sis_times_t *times, const read_t *before, const read_t *read, unsigned character)
{
    uint8_t flags = flags_of(times->record, character);
    int64_t interval = interval_of(times->record, character);
    sis_span_t span = {interval - read->uncertainty,
                       interval - read->others + before->uncertainty - before->others};

    if (flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_LOST_BEFORE) || span.least < 0)
        span.least = 0;
    if (flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_INTERVAL_SATURATED) || !times->is_bounded)
        span.most = SIS_ANY_TIME;
    if (!times->is_bounded)
        span.least = 0;
    return span;
}

/* Between any two characters of one read: bounded by the rest of its uncertainty, and by the time since
 * the read before. */
static sis_span_t
span_inside(const sis_times_t *times, const read_t *before, const read_t *read, unsigned character)
{
    int64_t shortest = SHORTEST_CHARACTER(sertap_character_ns(times->record));
    sis_span_t span = {shortest, read->uncertainty - read->others + shortest};

    if (!times->is_bounded)
        span.most = SIS_ANY_TIME;
    else if (before->size > 0)
        span.most = MIN(span.most, span_before(times, before, read, character).most);
    span.most = MAX(span.most, shortest);
    return span;
}

/* A start character and two equal lengths: a receiver restarts there after too long a pause, if the
 * character follows directly (chapter 10.5). */
static bool
looks_like_start(const sis_times_t *times, unsigned at)
{
    tvbuff_t *tvb = times->record->tvb;
    unsigned offset = times->record->data_offset + times->first + at - 1;

    return compat_get_uint8(tvb, offset) == SIS_START && at + 3 <= times->count &&
           sis_declared_length(tvb, offset) > 0;
}

/* The upper bound of an interval, where it counts. */
static int64_t
weight(const sis_interval_t *interval, bool is_exceeded)
{
    if (is_exceeded)
        return interval->span.least;
    return interval->span.most != SIS_ANY_TIME ? interval->span.most : interval->recorded;
}

static void
consider(sis_longest_t *longest, const sis_times_t *times, sis_interval_t interval, int64_t limit)
{
    uint8_t flags = flags_of(times->record, times->first + interval.at - 1);
    sis_verdict_t verdict = sis_judge(interval.span, limit);
    bool is_exceeded = verdict == SIS_TIME_EXCEEDED, was_exceeded = longest->verdict == SIS_TIME_EXCEEDED;

    if (is_exceeded && longest->restart_at == 0 && looks_like_start(times, interval.at))
        longest->restart_at = interval.at;
    if (longest->verdict == SIS_TIME_OK || is_exceeded)
        longest->verdict = verdict;
    if (flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_LOST_BEFORE)) {
        if (verdict == SIS_TIME_UNRESOLVED && longest->unknown_at == 0)
            longest->unknown_at = interval.at;
        return;
    }
    interval.is_saturated = flags & SERTAP_INTERVAL_SATURATED;
    interval.weight = weight(&interval, is_exceeded);
    if (longest->interval.at == 0 || (is_exceeded && !was_exceeded) ||
        (is_exceeded == was_exceeded && interval.weight > longest->interval.weight))
        longest->interval = interval;
}

sis_longest_t
sis_longest(const sis_times_t *times, int64_t limit)
{
    sis_longest_t longest = {0};
    read_t before = {0};

    if (limit == 0)
        limit = SIS_ANY_TIME; /* nothing exceeds it: the most that an interval can have been counts */
    for (unsigned i = times->first, end = times->first + times->count; i < end; i += before.size) {
        read_t read = read_at(times, i);
        sis_interval_t interval = {.at = i - times->first + 1,
                                   .recorded = interval_of(times->record, i),
                                   .is_exact = read.size == 1 && before.size == 1};

        if (before.size > 0) {
            interval.span = span_before(times, &before, &read, i);
            consider(&longest, times, interval, limit);
        }
        if (read.size > 1) {
            interval = (sis_interval_t){.at = i - times->first + 2};
            interval.span = span_inside(times, &before, &read, i);
            consider(&longest, times, interval, limit);
        }
        before = read;
    }
    return longest;
}

sis_span_t
sis_span_between(int64_t end_earliest, int64_t end, const sis_times_t *after)
{
    sis_span_t span = {sertap_elapsed(end, after->begin_earliest),
                       sertap_elapsed(end_earliest, after->begin_latest)};

    return span;
}

sis_verdict_t
sis_judge(sis_span_t span, int64_t limit)
{
    if (span.least > limit)
        return SIS_TIME_EXCEEDED;
    return span.most <= limit ? SIS_TIME_OK : SIS_TIME_UNRESOLVED;
}
