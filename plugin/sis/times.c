/* SPDX-License-Identifier: GPL-2.0-or-later */
/* When characters came, and how exactly that is known.
 *
 * The time of a character is that of the read that delivered it. The character came no later, and earlier by
 * at most the uncertainty of the record. Characters of one read follow one another by at least a character
 * time. So the i-th of k came at least (k - i) character times before the read. If a read is longer than its
 * uncertainty, the uncertainty was too small. Neighbouring reads bound each other in the same way. */
#include "sis/times.h"

#include "protocol/limits.h"
#include "sis/frame.h"

/* Character times are taken slightly short: a transmitter may be that much faster than its nominal rate. */
#define SHORTEST_CHARACTER(ns) ((ns)*98 / 100)

/* The number of characters of the telegram from the read that begins with `character`. */
static unsigned
read_size(const sis_times_t *times, unsigned character)
{
    unsigned end = times->first + times->count, next = character + 1;

    if (!(times->record->flags & SERTAP_SAME_READ))
        return 1;
    while (next < end && sertap_flags(times->record, next) & SERTAP_SAME_READ)
        next++;
    return next - character;
}

/* A read of some of the telegram's characters; times in ns. */
typedef struct {
    unsigned first; /* of the record's characters */
    unsigned size;
    int64_t others;   /* from the first character to the last, at least */
    int64_t earliest; /* so long before the read the first may have come */
    int64_t latest;   /* so long before the read the last had come, at least */
    int64_t interval; /* before the first character; only of find_reads(), and so are its flags */
    uint8_t flags;
} read_t;

static read_t
read_at(const sis_times_t *times, unsigned character)
{
    read_t read = {.first = character, .size = read_size(times, character)};

    read.others = (read.size - 1) * times->shortest;
    read.earliest = MAX(times->record->uncertainty, read.others);
    return read;
}

static void
bound(sis_times_t *times)
{
    unsigned last = times->first + times->count - 1;
    read_t read = read_at(times, times->first);

    times->begin_earliest = times->begin - read.earliest;
    times->begin_latest = times->begin - read.others;
    while (last > times->first && sertap_flags(times->record, last) & SERTAP_SAME_READ)
        last--;
    read = read_at(times, last);
    times->end_earliest = times->end - read.earliest + read.others;
}

/* When a character came, counted from the telegram before: a record may hold thousands of telegrams. */
static int64_t
moment_of(const sertap_record_t *record, unsigned character, int64_t begin, const sis_times_t *before)
{
    unsigned at = 0;

    if (before != NULL && before->record == record && before->first + before->count <= character) {
        at = before->first + before->count - 1;
        begin = before->end;
    }
    while (at < character)
        begin += sertap_interval(record, ++at);
    return begin;
}

sis_times_t
sis_times(tvbuff_t *tvb, packet_info *pinfo, unsigned length, const sis_times_t *before)
{
    const sertap_record_t *record = sertap_record(pinfo);
    sis_times_t times = {.begin = sertap_ns(&pinfo->abs_ts)};
    unsigned first = record != NULL ? sertap_index(record, tvb) : 0;

    times.end = times.begin;
    if (record == NULL || length == 0 || first + length > record->timed || first + length < first)
        return times;
    times.record = record;
    times.first = first;
    times.character = sertap_character_ns(record);
    times.shortest = SHORTEST_CHARACTER(times.character);
    times.count = length;
    times.begin = moment_of(record, first, times.begin, before);
    times.end = times.begin + (int64_t)record->duration;
    if (length < record->timed) {
        times.end = times.begin;
        for (unsigned i = first + 1; i < first + length; i++)
            times.end += sertap_interval(record, i);
    }
    times.is_bounded = record->uncertainty != SERTAP_UNCERTAINTY_UNKNOWN;
    if (times.is_bounded)
        bound(&times);
    return times;
}

static bool
is_measured_before(const read_t *read)
{
    return !(read->flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_ERROR_LOST));
}

/* All reads of a telegram. No character came before the one before it: what is known of a read bounds its
 * neighbours, forwards and backwards. */
static unsigned
find_reads(const sis_times_t *times, read_t *reads)
{
    unsigned count = 0;

    for (unsigned i = times->first; i < times->first + times->count; i += reads[count++].size) {
        reads[count] = read_at(times, i);
        reads[count].interval = sertap_interval(times->record, i);
        reads[count].flags = sertap_flags(times->record, i);
    }
    if (!times->is_bounded)
        return count;
    for (unsigned i = 1; i < count; i++) {
        read_t *before = &reads[i - 1], *read = &reads[i];
        int64_t since = read->interval + before->earliest - before->others;

        if (is_measured_before(read))
            read->earliest = CLAMP(since - times->shortest, read->others, read->earliest);
    }
    for (unsigned i = count - 1; i > 0; i--) {
        read_t *before = &reads[i - 1], *read = &reads[i];
        int64_t until = read->interval - read->others - read->latest;

        if (is_measured_before(read))
            before->latest = CLAMP(times->shortest - until, 0, before->earliest - before->others);
    }
    return count;
}

/* Between the last character of one read and the first of the next. */
static sis_span_t
span_before(const sis_times_t *times, const read_t *before, const read_t *read)
{
    sis_span_t span = {read->interval - read->earliest + before->latest,
                       read->interval - read->others - read->latest + before->earliest - before->others};

    if (!is_measured_before(read) || !times->is_bounded || span.least < 0)
        span.least = 0;
    if (read->flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_INTERVAL_SATURATED) || !times->is_bounded)
        span.most = SIS_ANY_TIME;
    return span;
}

/* Between any two characters of one read. */
static sis_span_t
span_inside(const sis_times_t *times, const read_t *read)
{
    int64_t rest = read->earliest - read->latest - read->others;

    return (sis_span_t){times->shortest, times->is_bounded ? times->shortest + rest : SIS_ANY_TIME};
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

/* Of several, one that is exceeded decides, then one that is unresolved. */
static void
worsen(sis_verdict_t *verdict, sis_verdict_t next)
{
    if (*verdict == SIS_TIME_OK || next == SIS_TIME_EXCEEDED)
        *verdict = next;
}

/* A limit, and what of an interval counts. */
typedef struct {
    int64_t limit;
    sis_from_t from;
} measure_t;

static void
consider(sis_longest_t *longest, const sis_times_t *times, sis_interval_t interval, uint8_t flags,
         const measure_t *measure)
{
    sis_readings_t readings = sis_judge_both(interval.span, times->character, measure->limit);
    sis_verdict_t verdict = sis_verdict(readings, measure->from);
    bool is_exceeded = verdict == SIS_TIME_EXCEEDED, was_exceeded = longest->verdict == SIS_TIME_EXCEEDED;

    if (is_exceeded && longest->restart_at == 0 && looks_like_start(times, interval.at))
        longest->restart_at = interval.at;
    worsen(&longest->verdict, verdict);
    worsen(&longest->readings.whole, readings.whole);
    worsen(&longest->readings.idle, readings.idle);
    if (flags & (SERTAP_INTERVAL_UNKNOWN | SERTAP_ERROR_LOST)) {
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
sis_longest(wmem_allocator_t *scope, const sis_times_t *times, int64_t limit, sis_from_t from)
{
    sis_longest_t longest = {0};
    measure_t measure = {limit, from};
    read_t *reads = wmem_alloc_array(scope, read_t, times->count);
    unsigned count = find_reads(times, reads);

    if (limit == 0)
        measure.limit = SIS_ANY_TIME; /* nothing exceeds it: the most that an interval can have been counts */
    for (unsigned i = 0; i < count; i++) {
        const read_t *read = &reads[i];
        sis_interval_t interval = {.at = read->first - times->first + 1, .recorded = read->interval};

        if (i > 0) {
            interval.is_exact = read->size == 1 && reads[i - 1].size == 1;
            interval.span = span_before(times, &reads[i - 1], read);
            consider(&longest, times, interval, read->flags, &measure);
        }
        if (read->size > 1) {
            interval = (sis_interval_t){.at = read->first - times->first + 2};
            interval.span = span_inside(times, read);
            consider(&longest, times, interval, sertap_flags(times->record, read->first + 1), &measure);
        }
    }
    return longest;
}

bool
sis_is_measured(int64_t elapsed, const sis_times_t *times)
{
    return elapsed > 0 || (elapsed == 0 && times->record == NULL);
}

sis_span_t
sis_span(int64_t least, int64_t most)
{
    return most < 0 ? (sis_span_t){SIS_SET_BACK, SIS_ANY_TIME} : (sis_span_t){least, most};
}

sis_span_t
sis_span_between(int64_t end_earliest, int64_t end, const sis_times_t *after)
{
    return sis_span(sertap_elapsed(end, after->begin_earliest),
                    sertap_elapsed(end_earliest, after->begin_latest));
}

sis_verdict_t
sis_judge(sis_span_t span, int64_t limit)
{
    if (span.least > limit)
        return SIS_TIME_EXCEEDED;
    return span.most <= limit ? SIS_TIME_OK : SIS_TIME_UNRESOLVED;
}

sis_readings_t
sis_judge_both(sis_span_t whole, int64_t character, int64_t limit)
{
    int64_t longest = character > 0 ? character : SIS_LONGEST_CHARACTER;
    sis_span_t idle = {MAX(whole.least, longest) - longest, whole.most};

    if (whole.most != SIS_ANY_TIME)
        idle.most = MAX(whole.most - character, 0);
    return (sis_readings_t){sis_judge(whole, limit), sis_judge(idle, limit)};
}

sis_verdict_t
sis_verdict(sis_readings_t readings, sis_from_t from)
{
    if (from != SIS_FROM_UNKNOWN)
        return from == SIS_FROM_END ? readings.idle : readings.whole;
    if (readings.idle == SIS_TIME_EXCEEDED)
        return SIS_TIME_EXCEEDED;
    return readings.whole == SIS_TIME_OK ? SIS_TIME_OK : SIS_TIME_UNRESOLVED;
}
