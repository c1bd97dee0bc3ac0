/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a line, record after record, in the first pass: what may hide a frame, and how busy it is.
 */

#include "packet-sertap.h"

#define WINDOW_NS INT64_C(1000000000) /* over which the load is taken */

/* When a record kept the line busy; ns since 1970. */
typedef struct {
    int64_t begin, end, busy;
} spell_t;

/* The spells of the last window, oldest first. */
typedef struct {
    spell_t *spells;
    unsigned head, end, size;
    int64_t busy;  /* of all of them */
    int64_t begin; /* of the first character on the line */
} window_t;

typedef struct sertap_line {
    sertap_disturbance_t disturbance;
    window_t window;
} line_t;

static wmem_map_t *lines; /* by interface */

static line_t *
find_line(packet_info *pinfo)
{
    void *key = GUINT_TO_POINTER(compat_interface(pinfo));
    line_t *line = wmem_map_lookup(lines, key);

    if (line == NULL) {
        line = wmem_new0(wmem_file_scope(), line_t);
        wmem_map_insert(lines, key, line);
    }
    return line;
}

sertap_disturbance_t
sertap_disturbance(const sertap_record_t *record)
{
    return record->known->disturbance;
}

/* Fewer other characters are what a line says when its direction turns. */
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

/* Room for one more spell: those that have left the window make it, else the window grows. */
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
    window->busy += busy;
    while (window->spells[window->head].end <= end - WINDOW_NS)
        window->busy -= window->spells[window->head++].busy;
}

void
sertap_line_note(packet_info *pinfo, sertap_record_t *record)
{
    line_t *line = record->known = find_line(pinfo);

    note_disturbance(line, pinfo, record);
    if (record->type != SERTAP_EVENT)
        note_spell(&line->window, pinfo, record);
}

/* Of the oldest spell only a part may lie in the window. */
float
sertap_load(const sertap_record_t *record)
{
    const window_t *window = &record->known->window;
    const spell_t *first = window->spells + window->head;
    int64_t end, begin, busy = window->busy;

    if (window->head == window->end)
        return -1;
    end = window->spells[window->end - 1].end;
    begin = MAX(end - WINDOW_NS, window->begin);
    if (first->begin < begin)
        busy -= (int64_t)((double)first->busy * (begin - first->begin) / (first->end - first->begin));
    return CLAMP((float)busy / (float)(end - begin), 0, 1) * 100;
}

void
sertap_line_register(void)
{
    lines = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), g_direct_hash, g_direct_equal);
}
