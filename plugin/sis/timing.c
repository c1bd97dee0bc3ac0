/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Verdicts on the timing of telegrams: TzA, TrS, TwM and Tmas (chapter 10), and how busy the bus is.
 *
 * A limit comes from a preference, else from the bus (bus.c), else from the user who captured. Without a
 * limit there is no verdict, nor if only packets have times. times.c computes the verdicts. */
#include "sis/timing.h"

#include <math.h>

#include <epan/tap.h>

#include "items.h"
#include "sertap/line.h"
#include "sis/address.h"
#include "sis/bus.h"
#include "sis/names.h"
#include "sis/told.h"

#define MS INT64_C(1000000) /* in ns */

/* An operator terminal considers its link lost after this silence (chapter 10.1). */
#define OPERATOR_TERMINAL_SILENCE (200 * MS)

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

static const judgement_t tza = {"TzA",
                                &hf_sis_tza_limit,
                                &hf_sis_tza_set_in,
                                &hf_sis_tza_verdict,
                                &ei_sis_tza_exceeded,
                                &ei_sis_tza_unresolved};
static const judgement_t trs = {"TrS",
                                &hf_sis_trs_limit,
                                &hf_sis_trs_set_in,
                                &hf_sis_trs_verdict,
                                &ei_sis_trs_exceeded,
                                &ei_sis_trs_unresolved};
static const judgement_t tmas = {"Tmas",
                                 &hf_sis_tmas_limit,
                                 &hf_sis_tmas_set_in,
                                 &hf_sis_tmas_verdict,
                                 &ei_sis_tmas_exceeded,
                                 &ei_sis_tmas_unresolved};

/* More digits if three would look like a whole number of ms, as limits are. */
static const char *
ms_text(const timing_t *t, int64_t ns)
{
    bool is_close = ns % MS != 0 && (ns + 500) % MS < 1000;

    return is_close ? sertap_decimal_text(t->pinfo->pool, ns, 1, 6, " ms")
                    : sertap_ms_text(t->pinfo->pool, ns);
}

static const char *
span_text(const timing_t *t, const sis_span_t *span)
{
    if (span->least == SIS_SET_BACK)
        return "the clock was set back";
    if (span->most == SIS_ANY_TIME)
        return span->least > 0 ? wmem_strconcat(t->pinfo->pool, "at least ", ms_text(t, span->least), NULL)
                               : "not known";
    return wmem_strconcat(t->pinfo->pool, "between ", ms_text(t, MAX(span->least, 0)), " and ",
                          ms_text(t, span->most), NULL);
}

static proto_item *
add_time(const timing_t *t, int hf, int64_t ns, const char *text)
{
    return sertap_add_time(t->tree, hf, t->body->tvb, ns, text);
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

static void
show_limit(const timing_t *t, const judgement_t *judgement, const sis_setting_t *told, int64_t limit_ns)
{
    proto_item *item;

    if (!proto_field_is_referenced(t->tree, *judgement->hf_limit))
        return;
    item = add_time(t, *judgement->hf_limit, limit_ns,
                    wmem_strdup_printf(t->pinfo->pool, "%u ms", (unsigned)(limit_ns / MS)));
    if (told != NULL && told->is_by_user)
        proto_item_append_text(item, ", told by the user");
}

/* Limit and verdict. The words for an expert item are the same in each packet: Wireshark groups by them. The
 * numbers follow the verdict. */
static void
show_verdict(const timing_t *t, const judgement_t *judgement, const sis_setting_t *told, int64_t limit_ns,
             sis_verdict_t verdict, const char *words, const char *numbers)
{
    proto_item *item;

    show_limit(t, judgement, told, limit_ns);
    if (told != NULL && told->set_in != 0)
        add_generated(t->tree, *judgement->hf_set_in, t->body->tvb, told->set_in);
    item = add_generated(t->tree, *judgement->hf_verdict, t->body->tvb, verdict);
    if (verdict == SIS_TIME_OK)
        return;
    if (numbers[0] != '\0')
        proto_item_append_text(item, ", %s", numbers);
    expert_add_info_format(
        t->pinfo, item, verdict == SIS_TIME_EXCEEDED ? judgement->exceeded : judgement->unresolved, "%s %s%s",
        judgement->name, verdict == SIS_TIME_EXCEEDED ? "exceeded" : "perhaps exceeded", words);
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

/* An unresolved verdict would be another if somebody knew what counts. */
static bool
is_ambiguous(sis_readings_t readings)
{
    return readings.whole != readings.idle;
}

/* Why a verdict is unresolved apart from the longest interval, or what a receiver does after so long a
 * pause (chapter 10.5); and the character that decides it. */
static const char *
verdict_words(const sis_longest_t *longest)
{
    if (longest->verdict != SIS_TIME_EXCEEDED && longest->unknown_at != 0)
        return ": an interval is not known";
    if (longest->verdict != SIS_TIME_EXCEEDED)
        return pref_sis_tza_from == SIS_FROM_UNKNOWN && is_ambiguous(longest->readings)
                   ? ": depends on where TzA begins to count"
                   : "";
    return longest->restart_at != 0
               ? ": a receiver begins anew at a character that looks like the start of a telegram"
               : ": a receiver goes on";
}

static const char *
verdict_numbers(const timing_t *t)
{
    const sis_longest_t *longest = &t->timing->longest;
    bool is_exceeded = longest->verdict == SIS_TIME_EXCEEDED;
    unsigned at = is_exceeded ? longest->restart_at : longest->unknown_at;

    if (at == 0)
        return "";
    return wmem_strdup_printf(t->pinfo->pool, "%s character %u",
                              is_exceeded ? "begins anew at" : "not known before", at);
}

/* "25.000 ms (idle 23.854 ms": the part without the character itself. */
static const char *
idle_text(const timing_t *t, int64_t ns)
{
    int64_t character = t->telegram->times.character;
    const char *idle = character != 0 ? ms_text(t, MAX(ns - character, 0)) : "time not known";

    return wmem_strconcat(t->pinfo->pool, ms_text(t, ns), " (idle ", idle, NULL);
}

static const char *
interval_text(const timing_t *t, const sis_interval_t *interval)
{
    uint32_t uncertainty = t->telegram->times.record->uncertainty;
    wmem_allocator_t *pool = t->pinfo->pool;

    if (interval->is_saturated)
        return wmem_strconcat(pool, "more than ", ms_text(t, interval->recorded), NULL);
    if (!interval->is_exact)
        return span_text(t, &interval->span);
    if (uncertainty == SERTAP_UNCERTAINTY_UNKNOWN)
        return wmem_strconcat(pool, idle_text(t, interval->recorded), ", uncertainty unknown)", NULL);
    return wmem_strconcat(pool, idle_text(t, interval->recorded), ", uncertain by ", ms_text(t, uncertainty),
                          ")", NULL);
}

/* The longest interval, and its place. */
static void
show_longest(const timing_t *t, const sis_interval_t *interval)
{
    bool is_recorded = interval->is_exact || interval->is_saturated;
    int64_t most = is_recorded ? interval->recorded : interval->span.most;

    if (most != SIS_ANY_TIME) {
        if (proto_field_is_referenced(t->tree, hf_sis_tza_interval_max))
            add_time(t, hf_sis_tza_interval_max, most, interval_text(t, interval));
        sertap_add_column_ms(t->tree, hf_sis_tza_interval_max_ms, t->body->tvb, most);
    }
    if (proto_field_is_referenced(t->tree, hf_sis_tza_position))
        proto_item_append_text(add_generated(t->tree, hf_sis_tza_position, t->body->tvb, interval->at),
                               " (%s)", position_text(t, interval->at));
}

/* The longest interval and the verdict on TzA. */
static void
show_tza(const timing_t *t)
{
    const sis_longest_t *longest = &t->timing->longest;

    if (longest->interval.at == 0)
        return;
    show_longest(t, &longest->interval);
    if (t->timing->tza != 0)
        show_verdict(t, &tza, pref_sis_tza_ms == 0 ? setting(t, SIS_TZA) : NULL, t->timing->tza,
                     longest->verdict, verdict_words(longest), verdict_numbers(t));
}

/* The reaction time of a slave on this line; behind a router it includes times of other lines. */
static void
show_trs(const timing_t *t)
{
    const sis_exchange_t *exchange = t->record->exchange;
    bool is_resolvable = t->telegram->times.is_bounded && exchange->command_spread != UINT32_MAX;
    sis_span_t span = {0, SIS_ANY_TIME};
    sis_readings_t readings;
    const char *words = ": how exact the times are is not known";

    if (is_resolvable)
        span = sis_span_between(exchange->command_end - exchange->command_spread, exchange->command_end,
                                &t->telegram->times);
    readings = sis_judge_both(span, t->telegram->times.character, t->timing->trs);
    t->timing->trs_verdict = sis_verdict(readings, SIS_FROM_UNKNOWN);
    if (is_resolvable)
        words = t->timing->trs_verdict == SIS_TIME_UNRESOLVED && is_ambiguous(readings)
                    ? ": depends on whether the first character counts"
                    : "";
    show_verdict(t, &trs, pref_sis_trs_ms == 0 ? setting(t, SIS_TRS) : NULL, t->timing->trs,
                 t->timing->trs_verdict, words,
                 is_resolvable && t->timing->trs_verdict != SIS_TIME_OK ? span_text(t, &span) : "");
}

/* The master's wait before a repetition, or after a broadcast. TwM is never sent, but a slave may take TrS
 * to answer. */
static void
show_twm(const timing_t *t)
{
    int64_t wait = t->timing->wait, slave = limit(t, SIS_TRS, pref_sis_trs_ms);
    proto_item *item = add_time(t, hf_sis_twm_wait, wait, ms_text(t, wait));

    if (t->record->exchange->first != NULL && slave > 0 && wait < slave) {
        proto_item_append_text(item, ", while the slave may take %u ms (TrS)", (unsigned)(slave / MS));
        expert_add_info(t->pinfo, item, &ei_sis_twm_early);
        sis_tell_expert(t->pinfo, &ei_sis_twm_early);
    }
}

static void
show_tmas(const timing_t *t)
{
    const sis_cycle_t *cycle = sis_rare(t->record, 0)->cycle;
    int64_t longest = t->telegram->times.record != NULL ? limit(t, SIS_TMAS, 0) : 0;
    bool is_measured = sis_is_measured(cycle->ns, &t->telegram->times);

    if (is_measured)
        add_time(t, hf_sis_tmas_cycle, cycle->ns, ms_text(t, cycle->ns));
    add_generated(t->tree, hf_sis_tmas_before_in, t->body->tvb, cycle->frame);
    if (longest <= 0)
        return;
    t->timing->tmas = longest;
    t->timing->tmas_verdict = sis_judge(cycle->span, longest);
    show_verdict(t, &tmas, setting(t, SIS_TMAS), longest, t->timing->tmas_verdict,
                 ": a slave stops a movement", is_measured ? "" : span_text(t, &cycle->span));
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
        item = add_generated(t->tree, hf_sis_bus_baud, t->body->tvb, rate->value);
        if (rate->accepted_in == 0)
            proto_item_append_text(item, " (timed test)");
        add_generated(t->tree, hf_sis_bus_baud_set_in, t->body->tvb, rate->set_in);
        if (tap != NULL && tap->baud != 0 && tap->baud != rate->value)
            expert_add_info_format(t->pinfo, item, &ei_sis_bus_baud_differs,
                                   "The bus was told %u Bd, the tap listens at %u Bd", rate->value,
                                   tap->baud);
    }
    if (t->record->load >= 0 && proto_field_is_referenced(t->tree, hf_sis_bus_load))
        proto_item_set_generated(proto_tree_add_double_format_value(
            t->tree, hf_sis_bus_load, t->body->tvb, 0, 0, t->record->load, "%s",
            sertap_decimal_text(t->pinfo->pool, lround(t->record->load * 10.0), 1, 1, " %")));
}

static void
show_silence(const timing_t *t)
{
    int64_t silence = t->timing->silence;
    proto_item *item;

    sertap_add_column_ms(t->tree, hf_sis_silence_before_ms, t->body->tvb, silence);
    if (!proto_field_is_referenced(t->tree, hf_sis_silence_before))
        return;
    item = add_time(t, hf_sis_silence_before, silence,
                    t->timing->is_silence_known
                        ? wmem_strconcat(t->pinfo->pool, idle_text(t, silence), ")", NULL)
                        : wmem_strconcat(t->pinfo->pool, "more than ", ms_text(t, silence), NULL));
    if (silence > OPERATOR_TERMINAL_SILENCE)
        proto_item_append_text(item, ", more than the 200 ms after which an operator terminal gives up");
}

/* Of the telegram's first character: since the one before it on the line. */
static void
find_silence(sis_timing_t *timing, const sis_times_t *times)
{
    const uint8_t unknown = SERTAP_INTERVAL_UNKNOWN | SERTAP_ERROR_LOST | SERTAP_SAME_READ;
    const sertap_record_t *record = times->record;
    uint8_t flags;

    if (record == NULL)
        return;
    flags = sertap_flags(record, times->first);
    timing->has_silence = !(flags & unknown);
    timing->is_silence_known =
        times->first == 0 ? record->is_silence_known : !(flags & SERTAP_INTERVAL_SATURATED);
    timing->silence = sertap_interval(record, times->first);
}

/* Examining every interval takes time: only if it is displayed or counted, or if there is a limit. */
static bool
is_longest_wanted(const timing_t *t)
{
    return t->telegram->times.record != NULL &&
           (t->timing->tza > 0 || have_tap_listener(sis_tap) ||
            proto_field_is_referenced(t->body->tree, hf_sis_tza_interval_max) ||
            proto_field_is_referenced(t->body->tree, hf_sis_tza_interval_max_ms) ||
            proto_field_is_referenced(t->body->tree, hf_sis_tza_position));
}

static void
find_timing(timing_t *t)
{
    sis_timing_t *timing = t->timing;
    const sis_exchange_t *exchange = t->record->exchange;
    bool is_answer = t->telegram->is_good && t->telegram->is_reaction && exchange != NULL &&
                     exchange->has_time && t->record->reaction_before == 0;

    find_silence(timing, &t->telegram->times);
    timing->tza = limit(t, SIS_TZA, pref_sis_tza_ms);
    if (is_longest_wanted(t))
        timing->longest = sis_longest(t->body->pinfo->pool, &t->telegram->times, timing->tza,
                                      (sis_from_t)pref_sis_tza_from);
    timing->has_reaction_time = is_answer && exchange->is_measured;
    if (is_answer && t->telegram->subaddress_count == 0 && t->telegram->times.record != NULL)
        timing->trs = limit(t, SIS_TRS, pref_sis_trs_ms);
    timing->wait = exchange != NULL && !t->telegram->is_reaction ? exchange->wait : -1;
}

static void
show(timing_t *t)
{
    t->tree = proto_tree_add_subtree(t->body->tree, t->body->tvb, 0, 0, ett_sis_timing, &t->root, "Timing");
    proto_item_set_generated(t->root);
    if (t->timing->has_silence)
        show_silence(t);
    show_tza(t);
    if (t->timing->trs > 0)
        show_trs(t);
    if (t->timing->wait >= 0)
        show_twm(t);
    if (sis_rare(t->record, 0)->cycle != NULL)
        show_tmas(t);
    show_bus(t);
}

void
sis_timing_dissect(sis_telegram_t *telegram, const sis_record_t *record, const sis_body_t *body)
{
    timing_t t = {.telegram = telegram,
                  .timing = &telegram->timing,
                  .record = record,
                  .body = body,
                  .pinfo = body->pinfo};
    const sis_timing_t *timing = &telegram->timing;
    bool has_more, is_known;

    find_timing(&t);
    has_more =
        timing->trs > 0 || timing->wait >= 0 || sis_rare(record, 0)->cycle != NULL || is_rate_known(&t);
    is_known = has_more || timing->has_silence || timing->longest.interval.at > 0 || record->load >= 0;
    /* After a verdict there may be an expert item, which counts even without a tree. */
    if (is_known && (body->tree != NULL || has_more || timing->tza > 0))
        show(&t);
}
