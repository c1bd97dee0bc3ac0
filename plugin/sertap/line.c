/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a line, record after record, in the first pass: what may hide a frame, and how busy it is.
 */
#include "sertap/line.h"

#include <math.h>

#include <epan/proto_data.h>

#include "kept.h"
#include "parts.h"

#define WINDOW_NS INT64_C(1000000000) /* the load is averaged over this time */

/* The time in which a record kept the line busy; ns since 1970. */
typedef struct {
    int64_t begin, end, busy;
} busy_t;

/* The busy times of the last window, oldest first. Never empty after the first. */
typedef struct {
    busy_t *times;
    unsigned head, end, size;
    uint64_t busy;      /* the sum of all; in a damaged capture it may exceed a signed number */
    int64_t begin;      /* of the first character on the line, or since the clock went back */
    bool has_restarted; /* the clock went back */
} window_t;

typedef struct sertap_line {
    uint64_t key;
    sertap_disturbance_t disturbance;
    sertap_limits_t limits;
    window_t window;
    int64_t last;       /* when the last character came, ns since 1970 */
    uint8_t last_line;  /* its direction */
    bool is_last_known; /* whether there was one, and when */
} line_t;

static wmem_map_t *lines; /* by key */

uint64_t
sertap_line_key(const packet_info *pinfo)
{
    return (uint64_t)compat_section(pinfo) << 32 | compat_interface(pinfo);
}

uint64_t
sertap_bus_key(packet_info *pinfo)
{
    const sertap_record_t *record = sertap_record(pinfo);
    uint64_t line = sertap_line_key(pinfo);

    return record != NULL && record->line == 2 && compat_interface(pinfo) > 0 ? line - 1 : line;
}

void *
sertap_kept_of_bus(wmem_map_t *buses, packet_info *pinfo, size_t size)
{
    uint64_t key = sertap_bus_key(pinfo);

    return kept_value(buses, &key, sizeof key, size);
}

static line_t *
find_line(const packet_info *pinfo)
{
    uint64_t key = sertap_line_key(pinfo);

    return kept_value(lines, &key, sizeof key, sizeof(line_t));
}

sertap_disturbance_t
sertap_disturbance(const sertap_record_t *record)
{
    return record->known->disturbance;
}

/* Fewer other characters are usual when a line changes direction. */
#define SHORTEST_FRAME 8

static void
note_disturbance(line_t *line, packet_info *pinfo, const sertap_record_t *record)
{
    bool is_gap = record->type == SERTAP_EVENT &&
                  (record->event == SERTAP_CHARACTERS_LOST || record->event == SERTAP_ADAPTER_LOST);

    if (is_gap || record->flags & SERTAP_ERROR_LOST)
        line->disturbance.lost_in = pinfo->num;
    if (record->type == SERTAP_EVENT && record->event == SERTAP_CAPTURE_STARTED)
        line->disturbance.begun_in = pinfo->num;
    if (record->type == SERTAP_OTHER && record->count >= SHORTEST_FRAME)
        line->disturbance.unframed_in = pinfo->num;
}

const sertap_limits_t *
sertap_limits(const sertap_record_t *record)
{
    return &record->known->limits;
}

static void
note_event(line_t *line, const packet_info *pinfo, const sertap_record_t *record)
{
    const uint8_t *text;

    if (record->event != SERTAP_LIMITS_TOLD || record->values != record->declared)
        return; /* the beginning of a number is another number */
    text = tvb_get_string_enc(wmem_file_scope(), record->tvb, record->data_offset, record->values, ENC_UTF_8);
    line->limits = (sertap_limits_t){pinfo->num, (const char *)text};
}

/* Makes room for one more: drops those outside the window, else enlarges the window. */
static void
make_room(window_t *window)
{
    if (window->end < window->size)
        return;
    if (window->head * 2 > window->size) {
        memmove(window->times, window->times + window->head,
                (window->end - window->head) * sizeof *window->times);
        window->end -= window->head;
        window->head = 0;
        return;
    }
    window->size = MAX(64, window->size * 2);
    window->times = wmem_realloc(wmem_file_scope(), window->times, window->size * sizeof *window->times);
}

/* Drops all: what was busy earlier says nothing. */
static void
restart(window_t *window)
{
    window->head = window->end = 0;
    window->busy = 0;
    window->has_restarted = true;
}

static void
note_busy(window_t *window, packet_info *pinfo, const sertap_record_t *record)
{
    int64_t character = sertap_character_ns(record), busy = character * record->count;
    int64_t end = sertap_ns(&pinfo->abs_ts) + (int64_t)record->duration;
    int64_t begin = end - MAX(busy, (int64_t)record->duration + character);

    if (busy == 0)
        return;
    if (window->head < window->end && end < window->times[window->end - 1].end)
        restart(window);
    if (window->head == window->end)
        window->begin = begin;
    make_room(window);
    window->times[window->end++] = (busy_t){begin, end, busy};
    window->busy += (uint64_t)busy;
    while (window->head + 1 < window->end && window->times[window->head].end <= end - WINDOW_NS)
        window->busy -= (uint64_t)window->times[window->head++].busy;
}

/* A longer time than can be stored, or the clock has changed. */
static void
note_silence(const line_t *line, packet_info *pinfo, const sertap_record_t *record)
{
    int64_t elapsed = sertap_elapsed(line->last, sertap_ns(&pinfo->abs_ts)), *silence;

    if (record->is_silence_known || !line->is_last_known || line->last_line != record->line ||
        elapsed < UINT32_MAX)
        return;
    silence = wmem_new(wmem_file_scope(), int64_t);
    *silence = elapsed;
    p_add_proto_data(wmem_file_scope(), pinfo, proto_sertap, 0, silence);
}

static void
note_last(line_t *line, packet_info *pinfo, const sertap_record_t *record)
{
    line->last = sertap_ns(&pinfo->abs_ts) + (int64_t)record->duration;
    line->last_line = record->line;
    line->is_last_known = record->is_duration_known;
}

void
sertap_line_find_silence(packet_info *pinfo, sertap_record_t *record)
{
    const int64_t *silence = NULL;

    if (!record->is_silence_known)
        silence = p_get_proto_data(wmem_file_scope(), pinfo, proto_sertap, 0);
    if (silence == NULL)
        return;
    record->silence = *silence;
    record->is_silence_known = true;
}

void
sertap_line_note(packet_info *pinfo, sertap_record_t *record)
{
    line_t *line = record->known = find_line(pinfo);

    if (record->type == SERTAP_BEFORE)
        return;
    note_disturbance(line, pinfo, record);
    if (record->type == SERTAP_EVENT) {
        note_event(line, pinfo, record);
        return;
    }
    note_busy(&line->window, pinfo, record);
    if (record->count > 0) {
        note_silence(line, pinfo, record);
        note_last(line, pinfo, record);
    }
}

/* The window may cut the oldest of them. After the clock went back, nobody knows what was in it. */
float
sertap_load(const sertap_record_t *record)
{
    const window_t *window = &record->known->window;
    const busy_t *first;
    double busy = (double)window->busy;
    int64_t end, begin, span;

    if (window->head == window->end) /* perhaps the line was never busy */
        return -1;
    first = window->times + window->head;
    end = window->times[window->end - 1].end;
    begin = MAX(end - WINDOW_NS, window->begin);
    span = sertap_elapsed(begin, end);
    if (span <= 0 || (window->has_restarted && span < WINDOW_NS))
        return -1;
    if (first->begin < begin)
        busy -= floor((double)first->busy * sertap_elapsed(first->begin, begin) /
                      sertap_elapsed(first->begin, first->end));
    return CLAMP((float)busy / (float)span, 0, 1) * 100;
}

void
sertap_line_register(void)
{
    lines = kept_map_of_numbers();
}
