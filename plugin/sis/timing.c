/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Verdicts on the timing of telegrams: TzA, TrS, TwM and Tmas (chapter 10), and how busy the bus is.
 *
 * A limit comes from a preference, else from the bus (bus.c), else from the user who captured. Without a
 * limit there is no verdict, nor if only packets have times. times.c computes the verdicts. */

#include "sis/timing.h"

#include <math.h>

#include <epan/tap.h>

#include "sertap/line.h"
#include "sis/address.h"
#include "sis/bus.h"
#include "sis/layouts.h"

#define MS INT64_C(1000000) /* in ns */

/* An operator terminal considers its link lost after this silence (chapter 10.1). */
#define OPERATOR_TERMINAL_SILENCE (200 * MS)

static int hf_silence_before = -1;
static int hf_silence_before_ms = -1;
static int hf_tza_interval_max = -1;
static int hf_tza_interval_max_ms = -1;
static int hf_tza_position = -1;
static int hf_tza_limit = -1;
static int hf_tza_set_in = -1;
static int hf_tza_verdict = -1;
static int hf_trs_limit = -1;
static int hf_trs_set_in = -1;
static int hf_trs_verdict = -1;
static int hf_twm_wait = -1;
static int hf_tmas_cycle = -1;
static int hf_tmas_limit = -1;
static int hf_tmas_set_in = -1;
static int hf_tmas_verdict = -1;
static int hf_bus_baud = -1;
static int hf_bus_baud_set_in = -1;
static int hf_bus_load = -1;

static int ett_timing = -1;

static expert_field ei_tza_exceeded = EI_INIT;
static expert_field ei_tza_unresolved = EI_INIT;
static expert_field ei_trs_exceeded = EI_INIT;
static expert_field ei_trs_unresolved = EI_INIT;
static expert_field ei_twm_early = EI_INIT;
static expert_field ei_tmas_exceeded = EI_INIT;
static expert_field ei_tmas_unresolved = EI_INIT;
static expert_field ei_baud_differs = EI_INIT;

/* Preferences; 0: use what the bus has set. */
static unsigned tza_ms;
static unsigned trs_ms;

static const value_string verdicts[] = {
    {SIS_TIME_OK, "ok"},
    {SIS_TIME_EXCEEDED, "exceeded"},
    {SIS_TIME_UNRESOLVED, "unresolved: the times are not exact enough"},
    {0, NULL},
};

static const unit_name_string units_baud = {" Bd", NULL};

/* A telegram whose timing is examined. */
typedef struct {
    sis_telegram_t *telegram;
    sis_timing_t *timing; /* of the telegram */
    const sis_record_t *record;
    const sis_body_t *body;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root; /* of `tree` */
} timing_t;

/* One of the three limits, and its display. */
typedef struct {
    const char *name;
    int *hf_limit, *hf_set_in, *hf_verdict;
    expert_field *exceeded, *unresolved;
} judgement_t;

static const judgement_t tza = {"TzA",           &hf_tza_limit,    &hf_tza_set_in,
                                &hf_tza_verdict, &ei_tza_exceeded, &ei_tza_unresolved};
static const judgement_t trs = {"TrS",           &hf_trs_limit,    &hf_trs_set_in,
                                &hf_trs_verdict, &ei_trs_exceeded, &ei_trs_unresolved};
static const judgement_t tmas = {"Tmas",           &hf_tmas_limit,    &hf_tmas_set_in,
                                 &hf_tmas_verdict, &ei_tmas_exceeded, &ei_tmas_unresolved};

/* More digits if three would look like a whole number of ms, as limits are. */
static const char *
ms_text(const timing_t *t, int64_t ns)
{
    bool is_close = ns % MS != 0 && (ns + 500) % MS < 1000;

    return is_close ? sertap_exact_ms_text(t->pinfo->pool, ns) : sertap_ms_text(t->pinfo->pool, ns);
}

static const char *
span_text(const timing_t *t, const sis_span_t *span)
{
    if (span->most == SIS_ANY_TIME)
        return span->least > 0 ? wmem_strdup_printf(t->pinfo->pool, "at least %s", ms_text(t, span->least))
                               : "not known";
    return wmem_strdup_printf(t->pinfo->pool, "between %s and %s", ms_text(t, MAX(span->least, 0)),
                              ms_text(t, span->most));
}

static proto_item *
add_time(const timing_t *t, int hf, int64_t ns, const char *text)
{
    nstime_t value = sertap_time(ns);
    proto_item *item = proto_tree_add_time_format_value(t->tree, hf, t->body->tvb, 0, 0, &value, "%s", text);

    proto_item_set_generated(item);
    return item;
}

static proto_item *
add_uint(const timing_t *t, int hf, uint32_t value)
{
    proto_item *item = proto_tree_add_uint(t->tree, hf, t->body->tvb, 0, 0, value);

    proto_item_set_generated(item);
    return item;
}

static const sis_setting_t *
setting(const timing_t *t, sis_setting_kind_t kind)
{
    return t->record->settings != NULL ? &t->record->settings->of[kind] : NULL;
}

/* In ns; 0: there is none. */
static int64_t
limit(const timing_t *t, sis_setting_kind_t kind, unsigned preference_ms)
{
    const sis_setting_t *told = setting(t, kind);

    if (preference_ms != 0)
        return preference_ms * MS;
    return told != NULL ? told->value * MS : 0;
}

/* Limit and verdict, with the words for an expert item. */
static void
show_verdict(const timing_t *t, const judgement_t *judgement, const sis_setting_t *told, int64_t limit_ns,
             sis_verdict_t verdict, const char *words)
{
    wmem_allocator_t *pool = t->pinfo->pool;
    const char *limit_text = wmem_strdup_printf(pool, "%u ms", (unsigned)(limit_ns / MS));
    proto_item *item;

    item = add_time(t, *judgement->hf_limit, limit_ns, limit_text);
    if (told != NULL && told->is_by_user)
        proto_item_append_text(item, ", told by the user");
    if (told != NULL && told->set_in != 0)
        add_uint(t, *judgement->hf_set_in, told->set_in);
    item = add_uint(t, *judgement->hf_verdict, verdict);
    if (verdict == SIS_TIME_OK)
        return;
    expert_add_info_format(t->pinfo, item,
                           verdict == SIS_TIME_EXCEEDED ? judgement->exceeded : judgement->unresolved,
                           "%s = %s %s: %s", judgement->name, limit_text,
                           verdict == SIS_TIME_EXCEEDED ? "exceeded" : "perhaps exceeded", words);
    if (verdict == SIS_TIME_EXCEEDED)
        wmem_strbuf_append_printf(t->body->marks, "  [%s exceeded]", judgement->name);
}

/* The field of the n-th character of a telegram, from 1. */
static const char *
position_text(const timing_t *t, unsigned n)
{
    static const char *const header[] = {
        "Start",   "Checksum",       "Data length",     "Data length repetition", "Telegram control",
        "Service", "Sender address", "Receiver address"};
    const sis_telegram_t *telegram = t->telegram;
    unsigned subaddress = n - SIS_STATIC_LENGTH;
    wmem_allocator_t *pool = t->pinfo->pool;

    if (n <= SIS_STATIC_LENGTH)
        return header[n - 1];
    if (subaddress <= telegram->subaddress_count)
        return wmem_strdup_printf(pool, "Subaddress %u", subaddress);
    if (n <= telegram->body_offset)
        return "Telegram number";
    return wmem_strdup_printf(pool, "Useful data, byte %u", n - telegram->body_offset);
}

/* Why a verdict is unresolved apart from the longest interval, or what a receiver does after so long a
 * pause (chapter 10.5). */
static const char *
verdict_words(const timing_t *t)
{
    const sis_longest_t *longest = &t->timing->longest;

    if (longest->verdict == SIS_TIME_UNRESOLVED && longest->unknown_at != 0)
        return wmem_strdup_printf(t->pinfo->pool, "; how long it was before character %u is not known",
                                  longest->unknown_at);
    if (longest->verdict != SIS_TIME_EXCEEDED)
        return "";
    if (longest->restart_at != 0)
        return wmem_strdup_printf(t->pinfo->pool,
                                  "; character %u looks like the start of a telegram: a receiver begins anew "
                                  "there",
                                  longest->restart_at);
    return "; a receiver goes on";
}

static const char *
interval_text(const timing_t *t, const sis_interval_t *interval)
{
    int64_t idle = interval->recorded - sertap_character_ns(t->telegram->times.record);
    uint32_t uncertainty = t->telegram->times.record->uncertainty;

    if (interval->is_saturated)
        return wmem_strdup_printf(t->pinfo->pool, "at least %s", ms_text(t, interval->recorded));
    if (!interval->is_exact)
        return span_text(t, &interval->span);
    return wmem_strdup_printf(
        t->pinfo->pool, "%s (idle %s%s)", ms_text(t, interval->recorded), ms_text(t, MAX(idle, 0)),
        uncertainty == SERTAP_UNCERTAINTY_UNKNOWN
            ? ", uncertainty unknown"
            : wmem_strdup_printf(t->pinfo->pool, ", uncertain by %s", ms_text(t, uncertainty)));
}

/* The longest interval, its place, and the verdict on TzA. */
static void
show_tza(const timing_t *t)
{
    const sis_longest_t *longest = &t->timing->longest;
    const sis_interval_t *interval = &longest->interval;
    const char *text, *position;
    bool is_recorded = interval->is_exact || interval->is_saturated;

    if (interval->at == 0)
        return;
    text = interval_text(t, interval);
    position = position_text(t, interval->at);
    if (is_recorded || interval->span.most != SIS_ANY_TIME) {
        int64_t most = is_recorded ? interval->recorded : interval->span.most;

        add_time(t, hf_tza_interval_max, most, text);
        sertap_add_column_ms(t->tree, hf_tza_interval_max_ms, t->body->tvb, most);
    }
    proto_item_append_text(add_uint(t, hf_tza_position, interval->at), " (%s)", position);
    if (t->timing->tza == 0)
        return;
    show_verdict(t, &tza, tza_ms == 0 ? setting(t, SIS_TZA) : NULL, t->timing->tza, longest->verdict,
                 wmem_strdup_printf(t->pinfo->pool, "%s before character %u (%s)%s", text, interval->at,
                                    position, verdict_words(t)));
}

/* The reaction time of a slave on this line; behind a router it includes times of other lines. */
static void
show_trs(const timing_t *t)
{
    const sis_exchange_t *exchange = t->record->exchange;
    bool is_resolvable = t->telegram->times.is_bounded && exchange->command_spread != UINT32_MAX;
    sis_span_t span = {0, SIS_ANY_TIME};

    if (is_resolvable)
        span = sis_span_between(exchange->command_end - exchange->command_spread, exchange->command_end,
                                &t->telegram->times);
    t->timing->trs_verdict = sis_judge(span, t->timing->trs);
    show_verdict(t, &trs, trs_ms == 0 ? setting(t, SIS_TRS) : NULL, t->timing->trs, t->timing->trs_verdict,
                 is_resolvable ? span_text(t, &span) : "how exact the times are is not known");
}

/* The master's wait before a repetition, or after a broadcast. TwM is never sent, but a slave may take TrS
 * to answer. */
static void
show_twm(const timing_t *t)
{
    int64_t wait = t->timing->wait, slave = limit(t, SIS_TRS, trs_ms);
    proto_item *item = add_time(t, hf_twm_wait, wait, ms_text(t, wait));

    if (t->record->exchange->first != NULL && slave > 0 && wait < slave)
        expert_add_info_format(t->pinfo, item, &ei_twm_early,
                               "Repeated after %s, while the slave may take %u ms (TrS)", ms_text(t, wait),
                               (unsigned)(slave / MS));
}

/* Two master control words to the same drive. */
typedef struct sis_cycle {
    uint32_t frame; /* the one before */
    int64_t ns;     /* from beginning to beginning */
    sis_span_t span;
} sis_cycle_t;

static void
show_tmas(const timing_t *t)
{
    const sis_cycle_t *cycle = t->record->cycle;
    int64_t longest = t->telegram->times.record != NULL ? limit(t, SIS_TMAS, 0) : 0;

    add_time(t, hf_tmas_cycle, cycle->ns, ms_text(t, cycle->ns));
    if (longest > 0)
        show_verdict(t, &tmas, setting(t, SIS_TMAS), longest, sis_judge(cycle->span, longest),
                     wmem_strdup_printf(t->pinfo->pool,
                                        "%s since the master control word before (frame %u); a slave stops a "
                                        "movement",
                                        ms_text(t, cycle->ns), cycle->frame));
}

static bool
is_rate_known(const timing_t *t)
{
    const sis_setting_t *rate = setting(t, SIS_BAUD);

    return rate != NULL && rate->set_in != 0;
}

static void
show_bus(const timing_t *t)
{
    const sis_setting_t *rate = setting(t, SIS_BAUD);
    const sertap_record_t *tap = t->telegram->times.record;
    proto_item *item;

    if (is_rate_known(t)) {
        item = add_uint(t, hf_bus_baud, rate->value);
        if (rate->accepted_in == 0)
            proto_item_append_text(item, " (timed test)");
        add_uint(t, hf_bus_baud_set_in, rate->set_in);
        if (tap != NULL && tap->baud != 0 && tap->baud != rate->value)
            expert_add_info_format(t->pinfo, item, &ei_baud_differs,
                                   "The bus was told %u Bd, the tap listens at %u Bd", rate->value,
                                   tap->baud);
    }
    if (t->record->load >= 0 && proto_field_is_referenced(t->tree, hf_bus_load))
        proto_item_set_generated(proto_tree_add_double_format_value(
            t->tree, hf_bus_load, t->body->tvb, 0, 0, t->record->load, "%s %%",
            sertap_decimal_text(t->pinfo->pool, lround(t->record->load * 10.0), 1, 1)));
}

static void
show_silence(const timing_t *t)
{
    int64_t silence = t->timing->silence, idle = silence - sertap_character_ns(t->telegram->times.record);
    proto_item *item;

    sertap_add_column_ms(t->tree, hf_silence_before_ms, t->body->tvb, silence);
    if (!proto_field_is_referenced(t->tree, hf_silence_before))
        return;
    item = add_time(
        t, hf_silence_before, silence,
        wmem_strdup_printf(t->pinfo->pool, "%s (idle %s)", ms_text(t, silence), ms_text(t, MAX(idle, 0))));
    if (silence > OPERATOR_TERMINAL_SILENCE)
        proto_item_append_text(item, ", more than the 200 ms after which an operator terminal gives up");
}

/* Of the telegram's first character: since the one before it on the line. */
static void
find_silence(sis_timing_t *timing, const sis_times_t *times)
{
    const uint8_t unknown =
        SERTAP_INTERVAL_UNKNOWN | SERTAP_INTERVAL_SATURATED | SERTAP_LOST_BEFORE | SERTAP_SAME_READ;
    const sertap_record_t *record = times->record;

    if (record == NULL || compat_get_uint8(record->tvb, record->flags_offset + times->first) & unknown)
        return;
    timing->has_silence = true;
    timing->silence = tvb_get_ntohl(record->tvb, record->times_offset + 4 * times->first);
}

/* Examining every interval takes time: only if it is displayed or counted, or if there is a limit. */
static bool
is_longest_wanted(const timing_t *t)
{
    return t->telegram->times.record != NULL &&
           (t->timing->tza > 0 || have_tap_listener(sis_tap) ||
            proto_field_is_referenced(t->body->tree, hf_tza_interval_max) ||
            proto_field_is_referenced(t->body->tree, hf_tza_interval_max_ms) ||
            proto_field_is_referenced(t->body->tree, hf_tza_position));
}

static void
find_timing(timing_t *t)
{
    sis_timing_t *timing = t->timing;
    const sis_exchange_t *exchange = t->record->exchange;
    bool is_answer = t->telegram->is_good && t->telegram->is_reaction && exchange != NULL &&
                     exchange->has_time && t->record->reaction_before == 0;

    find_silence(timing, &t->telegram->times);
    timing->tza = limit(t, SIS_TZA, tza_ms);
    if (is_longest_wanted(t))
        timing->longest = sis_longest(&t->telegram->times, timing->tza);
    timing->has_reaction_time = is_answer;
    if (is_answer && t->telegram->subaddress_count == 0 && t->telegram->times.record != NULL)
        timing->trs = limit(t, SIS_TRS, trs_ms);
    timing->wait = exchange != NULL && !t->telegram->is_reaction ? exchange->wait : -1;
}

static bool
is_anything_known(const timing_t *t)
{
    return t->timing->has_silence || t->timing->longest.interval.at > 0 || t->timing->trs > 0 ||
           t->timing->wait >= 0 || t->record->cycle != NULL || is_rate_known(t) || t->record->load >= 0;
}

/* Then there may be an expert item, which counts even without a tree. */
static bool
is_anything_judged(const timing_t *t)
{
    return t->timing->tza > 0 || t->timing->trs > 0 || t->timing->wait >= 0 || t->record->cycle != NULL ||
           is_rate_known(t);
}

static void
show(timing_t *t)
{
    t->tree = proto_tree_add_subtree(t->body->tree, t->body->tvb, 0, 0, ett_timing, &t->root, "Timing");
    proto_item_set_generated(t->root);
    if (t->timing->has_silence)
        show_silence(t);
    show_tza(t);
    if (t->timing->trs > 0)
        show_trs(t);
    if (t->timing->wait >= 0)
        show_twm(t);
    if (t->record->cycle != NULL)
        show_tmas(t);
    show_bus(t);
}

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

static void
note_cycle(sis_record_t *record, const sis_telegram_t *telegram, const sis_body_t *body)
{
    const sis_exchange_t *exchange = record->exchange;
    const sis_request_t *request = body->request != NULL ? find_control_word(body->request) : NULL;
    sis_bus_t *bus;
    control_word_t *last;
    void *key;

    if (exchange == NULL || request == NULL)
        return;
    bus = exchange->stream->bus;
    if (bus->cycles == NULL)
        bus->cycles = wmem_map_new(wmem_file_scope(), g_direct_hash, g_direct_equal);
    key = GUINT_TO_POINTER(exchange->stream->number << 8 | request->device);
    last = wmem_map_lookup(bus->cycles, key);
    if (last == NULL) {
        last = wmem_new(wmem_file_scope(), control_word_t);
        wmem_map_insert(bus->cycles, key, last);
    } else {
        record->cycle = wmem_new(wmem_file_scope(), sis_cycle_t);
        record->cycle->frame = last->frame;
        record->cycle->ns = sertap_elapsed(last->times.begin, telegram->times.begin);
        record->cycle->span = (sis_span_t){0, SIS_ANY_TIME};
        if (telegram->times.is_bounded && last->times.is_bounded)
            record->cycle->span =
                (sis_span_t){sertap_elapsed(last->times.begin_latest, telegram->times.begin_earliest),
                             sertap_elapsed(last->times.begin_earliest, telegram->times.begin_latest)};
    }
    last->frame = body->pinfo->num;
    last->times = telegram->times;
}

/* The slave of a swapped reaction is in its command. */
void
sis_timing_note(sis_record_t *record, const sis_telegram_t *telegram, packet_info *pinfo)
{
    uint8_t address = record->exchange != NULL ? record->exchange->path[0] : telegram->receiver;
    sis_bus_t *bus = record->exchange != NULL ? record->exchange->stream->bus : sis_exchange_bus(pinfo);

    if (pinfo->fd->visited)
        return;
    if (!telegram->is_good || !sis_is_answered(address))
        address = SIS_ALL_STATIONS;
    if (telegram->times.record != NULL)
        sis_bus_learn_limits(bus, sertap_limits(telegram->times.record));
    record->settings = sis_bus_settings(bus, address, telegram->times.begin);
    record->load = telegram->times.record != NULL ? sertap_load(telegram->times.record) : -1;
}

void
sis_timing_dissect(sis_telegram_t *telegram, sis_record_t *record, const sis_body_t *body)
{
    timing_t t = {.telegram = telegram,
                  .timing = &telegram->timing,
                  .record = record,
                  .body = body,
                  .pinfo = body->pinfo};

    if (!body->pinfo->fd->visited)
        note_cycle(record, telegram, body);
    telegram->record = record;
    find_timing(&t);
    if ((body->tree != NULL || is_anything_judged(&t)) && is_anything_known(&t))
        show(&t);
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_silence_before, {"Silence before", "sis.silence_before", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Since the character before it on this line, arrival to arrival", HFILL}},
    {&hf_silence_before_ms, {"Silence before in ms", "sis.silence_before.ms", FT_DOUBLE, BASE_CUSTOM, CF_FUNC(sertap_format_ms), 0, "For a column of the packet list", HFILL}},
    {&hf_tza_interval_max, {"Longest interval", "sis.tza.interval_max", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two characters of the telegram, arrival to arrival; where they came in one read, the most it can have been", HFILL}},
    {&hf_tza_interval_max_ms, {"Longest interval in ms", "sis.tza.interval_max.ms", FT_DOUBLE, BASE_CUSTOM, CF_FUNC(sertap_format_ms), 0, "For a column of the packet list", HFILL}},
    {&hf_tza_position, {"Longest interval before character", "sis.tza.position", FT_UINT16, BASE_DEC, NULL, 0, "Its number in the telegram, from 1", HFILL}},
    {&hf_tza_limit, {"TzA (longest interval allowed)", "sis.tza.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_tza_set_in, {"TzA set in", "sis.tza.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_tza_verdict, {"Verdict on TzA", "sis.tza.verdict", FT_UINT8, BASE_DEC, VALS(verdicts), 0, NULL, HFILL}},
    {&hf_trs_limit, {"TrS (longest reaction time allowed)", "sis.trs.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_trs_set_in, {"TrS set in", "sis.trs.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_trs_verdict, {"Verdict on TrS", "sis.trs.verdict", FT_UINT8, BASE_DEC, VALS(verdicts), 0, NULL, HFILL}},
    {&hf_twm_wait, {"Wait of the master (TwM)", "sis.twm.wait", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Since the end of its command before: of the one that is repeated, or of a broadcast", HFILL}},
    {&hf_tmas_cycle, {"Master control word cycle", "sis.tmas.cycle", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two writings of S-0-0134 to the same device, begin to begin", HFILL}},
    {&hf_tmas_limit, {"Tmas (longest cycle allowed)", "sis.tmas.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "While the machine moves", HFILL}},
    {&hf_tmas_set_in, {"Tmas set in", "sis.tmas.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_tmas_verdict, {"Verdict on Tmas", "sis.tmas.verdict", FT_UINT8, BASE_DEC, VALS(verdicts), 0, NULL, HFILL}},
    {&hf_bus_baud, {"Baud rate of the bus", "sis.bus.baud", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&units_baud), 0, "As the bus was told", HFILL}},
    {&hf_bus_baud_set_in, {"Baud rate set in", "sis.bus.baud.set_in", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_bus_load, {"Bus load", "sis.bus.load", FT_DOUBLE, BASE_NONE, NULL, 0, "Percent of the last second in which there were characters on the line", HFILL}},
};

static ei_register_info experts[] = {
    {&ei_tza_exceeded, {"sis.tza.exceeded", PI_PROTOCOL, PI_WARN, "TzA exceeded", EXPFILL}},
    {&ei_tza_unresolved, {"sis.tza.unresolved", PI_PROTOCOL, PI_NOTE, "TzA perhaps exceeded", EXPFILL}},
    {&ei_trs_exceeded, {"sis.trs.exceeded", PI_PROTOCOL, PI_WARN, "TrS exceeded", EXPFILL}},
    {&ei_trs_unresolved, {"sis.trs.unresolved", PI_PROTOCOL, PI_NOTE, "TrS perhaps exceeded", EXPFILL}},
    {&ei_twm_early, {"sis.twm.early", PI_SEQUENCE, PI_NOTE, "Repeated before TrS was over", EXPFILL}},
    {&ei_tmas_exceeded, {"sis.tmas.exceeded", PI_PROTOCOL, PI_WARN, "Tmas exceeded", EXPFILL}},
    {&ei_tmas_unresolved, {"sis.tmas.unresolved", PI_PROTOCOL, PI_NOTE, "Tmas perhaps exceeded", EXPFILL}},
    {&ei_baud_differs, {"sis.bus.baud.differs", PI_PROTOCOL, PI_NOTE, "The tap listens at another baud rate than the bus was told", EXPFILL}},
};
/* clang-format on */

void
sis_timing_register(module_t *module)
{
    static int *trees[] = {&ett_timing};

    proto_register_field_array(proto_sis, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    expert_register_field_array(sis_experts, experts, array_length(experts));
    prefs_register_uint_preference(module, "tza_ms", "TzA in ms",
                                   "Longest interval allowed between two characters of a telegram; 0: as the "
                                   "bus was told",
                                   10, &tza_ms);
    prefs_register_uint_preference(module, "trs_ms", "TrS in ms",
                                   "Longest reaction time allowed; 0: as the bus was told", 10, &trs_ms);
}
