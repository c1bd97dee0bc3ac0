/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a line, record after record, in the first pass: what may hide a frame, and how busy it is.
 */

#include "sertap/line.h"

#include <math.h>

#define WINDOW_NS INT64_C(1000000000) /* the load is averaged over this time */

/* The time in which a record kept the line busy; ns since 1970. */
typedef struct {
    int64_t begin, end, busy;
} spell_t;

/* The spells of the last window, oldest first. Never empty after the first spell. */
typedef struct {
    spell_t *spells;
    unsigned head, end, size;
    uint64_t busy; /* the sum of all; in a damaged capture it may exceed a signed number */
    int64_t begin; /* of the first character on the line */
} window_t;

typedef struct sertap_line {
    uint64_t key;
    unsigned number;
    sertap_disturbance_t disturbance;
    sertap_limits_t limits;
    window_t window;
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

static line_t *
find_line(const packet_info *pinfo)
{
    uint64_t key = sertap_line_key(pinfo);
    line_t *line = wmem_map_lookup(lines, &key);

    if (line == NULL) {
        line = wmem_new0(wmem_file_scope(), line_t);
        line->key = key;
        line->number = wmem_map_size(lines);
        wmem_map_insert(lines, &line->key, line);
    }
    return line;
}

unsigned
sertap_line_number(const packet_info *pinfo)
{
    return find_line(pinfo)->number;
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

    if (is_gap || record->flags & SERTAP_LOST_BEFORE)
        line->disturbance.lost_in = pinfo->num;
    if (record->type == SERTAP_OTHER && record->count >= SHORTEST_FRAME)
        line->disturbance.unframed_in = pinfo->num;
}

const sertap_limits_t *
sertap_limits(const sertap_record_t *record)
{
    return &record->known->limits;
}

static void
note_limits(line_t *line, const packet_info *pinfo, const sertap_record_t *record)
{
    uint8_t *text =
        tvb_get_string_enc(wmem_file_scope(), record->tvb, record->data_offset, record->values, ENC_UTF_8);

    line->limits = (sertap_limits_t){pinfo->num, (const char *)text};
}

/* Makes room for one more spell: drops those outside the window, else enlarges the window. */
static void
make_room(window_t *window)
{
    if (window->end < window->size)
        return;
    if (window->head * 2 > window->size) {
        memmove(window->spells, window->spells + window->head,
                (window->end - window->head) * sizeof *window->spells);
        window->end -= window->head;
        window->head = 0;
        return;
    }
    window->size = MAX(64, window->size * 2);
    window->spells = wmem_realloc(wmem_file_scope(), window->spells, window->size * sizeof *window->spells);
}

static void
note_spell(window_t *window, packet_info *pinfo, const sertap_record_t *record)
{
    int64_t character = sertap_character_ns(record), busy = character * record->count;
    int64_t end = sertap_ns(&pinfo->abs_ts) + (int64_t)record->duration;
    int64_t begin = end - MAX(busy, (int64_t)record->duration + character);

    if (busy == 0)
        return;
    if (window->size == 0)
        window->begin = begin;
    make_room(window);
    window->spells[window->end++] = (spell_t){begin, end, busy};
    window->busy += (uint64_t)busy;
    while (window->head + 1 < window->end && window->spells[window->head].end <= end - WINDOW_NS)
        window->busy -= (uint64_t)window->spells[window->head++].busy;
}

void
sertap_line_note(packet_info *pinfo, sertap_record_t *record)
{
    line_t *line = record->known = find_line(pinfo);

    note_disturbance(line, pinfo, record);
    if (record->type == SERTAP_EVENT && record->event == SERTAP_LIMITS_TOLD &&
        record->values == record->declared) /* the beginning of a number is another number */
        note_limits(line, pinfo, record);
    if (record->type != SERTAP_EVENT)
        note_spell(&line->window, pinfo, record);
}

/* The window may cut the oldest spell. After the clock went back, its length is unknown. */
float
sertap_load(const sertap_record_t *record)
{
    const window_t *window = &record->known->window;
    const spell_t *first;
    double busy = (double)window->busy;
    int64_t end, begin, span;

    if (window->head == window->end) /* perhaps there are no spells at all */
        return -1;
    first = window->spells + window->head;
    end = window->spells[window->end - 1].end;
    begin = MAX(end - WINDOW_NS, window->begin);
    span = sertap_elapsed(begin, end);
    if (span <= 0)
        return -1;
    if (first->begin < begin)
        busy -= floor((double)first->busy * sertap_elapsed(first->begin, begin) /
                      sertap_elapsed(first->begin, first->end));
    return CLAMP((float)busy / (float)span, 0, 1) * 100;
}

void
sertap_line_register(void)
{
    lines = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), wmem_int64_hash, g_int64_equal);
}
