/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The cycle in which a master sends its master control word to a drive, which Tmas limits (chapter 10). First
 * pass only. */
#include "sis/cycle.h"

#include "sertap/line.h"
#include "sis/bus.h"
#include "sis/names.h"

#define MS INT64_C(1000000) /* in ns */

/* After a silence that a record cannot hold, the bus is dead. */
#define DEAD_BUS_SILENCE ((int64_t)UINT32_MAX)

/* Whether a command writes the master control word: S-0-0134 of SERCOS. The documents do not name the
 * telegram that carries it. */
static const sis_request_t *
find_control_word(const sis_request_t *request)
{
    const sis_request_t *element;

    if (sis_general_service(request->service) == 0x1F && request->has_ident && request->ident.type == 0 &&
        request->ident.number == 134 && request->element == SIS_ELEMENT_DATA)
        return request;
    for (element = request->list; element != NULL; element = element->next) {
        if (find_control_word(element) != NULL)
            return element;
    }
    return NULL;
}

/* The time of the last master control word to a drive. */
typedef struct {
    uint32_t frame;
    sis_times_t times;
} control_word_t;

/* Of a bus; made when the first master control word comes. */
struct sis_cycles {
    wmem_map_t *words; /* the last to each drive */
    int64_t heard;     /* when the last telegram ended, ns since 1970 */
    uint32_t dead_in;  /* the last telegram after too long a silence; 0: none */
};

static struct sis_cycles *
cycles_of(sis_bus_t *bus)
{
    if (bus->cycles == NULL) {
        bus->cycles = wmem_new0(wmem_file_scope(), struct sis_cycles);
        bus->cycles->words = wmem_map_new(wmem_file_scope(), g_direct_hash, g_direct_equal);
    }
    return bus->cycles;
}

void
sis_cycle_heard(const sis_bus_t *bus, const sis_times_t *times, uint32_t frame)
{
    struct sis_cycles *cycles = bus->cycles;

    if (cycles == NULL)
        return;
    if (sertap_elapsed(cycles->heard, times->begin) > DEAD_BUS_SILENCE)
        cycles->dead_in = frame;
    cycles->heard = times->end;
}

/* Tmas holds while the machine moves. After what ended here, the next word begins anew (docs/verdicts.md). */
static uint32_t
cycle_ended_in(const sis_record_t *record, const sis_times_t *times)
{
    const sis_stream_t *stream = record->exchange->stream;
    const sis_setting_t *limit = record->settings != NULL ? &record->settings->of[SIS_TMAS] : NULL;
    uint32_t ended_in = MAX(stream->idle_in, stream->bus->lost_in);

    if (times->record != NULL)
        ended_in = MAX(ended_in, sertap_disturbance(times->record).begun_in);
    if (limit != NULL)
        ended_in = MAX(ended_in, limit->accepted_in);
    if (limit == NULL || limit->value * MS < DEAD_BUS_SILENCE)
        ended_in = MAX(ended_in, stream->bus->cycles->dead_in);
    return ended_in;
}

static sis_cycle_t *
make_cycle(const control_word_t *last, const sis_times_t *times)
{
    sis_cycle_t *cycle = wmem_new(wmem_file_scope(), sis_cycle_t);

    *cycle = (sis_cycle_t){last->frame, sertap_elapsed(last->times.begin, times->begin), {0, SIS_ANY_TIME}};
    if (times->is_bounded && last->times.is_bounded)
        cycle->span = sis_span(sertap_elapsed(last->times.begin_latest, times->begin_earliest),
                               sertap_elapsed(last->times.begin_earliest, times->begin_latest));
    return cycle;
}

void
sis_cycle_learn(const sis_body_t *body)
{
    const sis_exchange_t *exchange = body->record->exchange;
    const sis_times_t *times = &body->telegram->times;
    const sis_request_t *request = find_control_word(body->request);
    struct sis_cycles *cycles;
    control_word_t *last;
    void *key;

    if (request == NULL)
        return;
    cycles = cycles_of(exchange->stream->bus);
    key = GUINT_TO_POINTER(exchange->stream->number << 8 | request->device);
    last = wmem_map_lookup(cycles->words, key);
    if (last == NULL) {
        last = wmem_new(wmem_file_scope(), control_word_t);
        wmem_map_insert(cycles->words, key, last);
    } else if (cycle_ended_in(body->record, times) <= last->frame) {
        sis_make_rare(body->record, 0)->cycle = make_cycle(last, times);
    }
    cycles->heard = times->end;
    last->frame = body->pinfo->num;
    last->times = *times;
}
