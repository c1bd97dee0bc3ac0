/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The tree of telegrams: by service, station, status and error (`tshark -z sis,tree`). */
#include "parts.h"

#include <epan/stats_tree.h>

#include "sertap/line.h"
#include "sis/exchange.h"
#include "sis/names.h"

#define NS_PER_US INT64_C(1000)

/* Chapter 10.1: an operator terminal's cycle, and the silence after which its link is lost. */
#define CYCLE_NS   INT64_C(100000000)
#define SILENCE_NS INT64_C(200000000)

/* The branches, all below "Telegrams". */
static const char *const telegrams_name = "Telegrams", *const stations_name = "By station";
static int telegrams_node, services_node, stations_node, states_node, errors_node;

static void
init(stats_tree *tree)
{
    telegrams_node = stats_tree_create_node(tree, telegrams_name, 0, STAT_DT_INT, TRUE);
    services_node = stats_tree_create_node(tree, "By service", telegrams_node, STAT_DT_INT, TRUE);
    stations_node = stats_tree_create_node(tree, stations_name, telegrams_node, STAT_DT_INT, TRUE);
    states_node = stats_tree_create_pivot(tree, "Reactions by status", telegrams_node);
    errors_node = stats_tree_create_pivot(tree, "Errors", telegrams_node);
}

static void
count_service(stats_tree *tree, packet_info *pinfo, const sis_telegram_t *telegram)
{
    const char *name = sis_service_name(pinfo->pool, telegram->service);
    int node;

    tick_stat_node(tree, "By service", telegrams_node, TRUE);
    node = tick_stat_node(tree, name, services_node, TRUE);
    tick_stat_node(tree, telegram->is_reaction ? "Reaction" : "Command", node, FALSE);
}

/* Its node; counts its telegrams. */
static int
count_station(stats_tree *tree, packet_info *pinfo, unsigned station, int telegrams)
{
    const char *name = wmem_strdup_printf(pinfo->pool, "Station %u", station);

    return increase_stat_node(tree, name, stations_node, TRUE, telegrams);
}

/* From the first character of a command to the last of its reaction. */
static int64_t
cycle(const sis_telegram_t *telegram)
{
    const sis_exchange_t *exchange = telegram->record->exchange;

    return sertap_elapsed(exchange->command_end, telegram->times.end) + exchange->command_duration;
}

static unsigned
line_errors(const sis_times_t *times)
{
    const uint8_t errors =
        SERTAP_ERROR_CHARACTER | SERTAP_ERROR_BREAK | SERTAP_ERROR_LOST | SERTAP_ERROR_UNLOCATED;
    const sertap_record_t *record = times->record;
    unsigned found = 0;

    for (unsigned i = 0; record != NULL && record->flags & errors && i < times->count; i++)
        found += (sertap_flags(record, times->first + i) & errors) != 0;
    return found;
}

/* What a station said, and which limits it did not keep. */
static void
count_talker(stats_tree *tree, packet_info *pinfo, const sis_telegram_t *telegram)
{
    const sis_timing_t *timing = &telegram->timing;
    const sis_interval_t *longest = &timing->longest.interval;
    sis_verdict_t tza = timing->tza > 0 ? timing->longest.verdict : SIS_TIME_OK;
    const struct {
        const char *name;
        unsigned count;
    } counts[] = {
        {"TzA exceeded", tza == SIS_TIME_EXCEEDED},
        {"TzA unresolved", tza == SIS_TIME_UNRESOLVED},
        {"TrS exceeded", timing->trs > 0 && timing->trs_verdict == SIS_TIME_EXCEEDED},
        {"Cycles above 100 ms", timing->has_reaction_time && cycle(telegram) > CYCLE_NS},
        {"Silences above 200 ms", timing->has_silence && timing->silence > SILENCE_NS},
        {"Characters with line errors", line_errors(&telegram->times)},
    };
    int station = count_station(tree, pinfo, telegram->talker, 1);

    tick_stat_node(tree, stations_name, telegrams_node, TRUE);
    for (unsigned i = 0; i < array_length(counts); i++) {
        if (counts[i].count > 0)
            increase_stat_node(tree, counts[i].name, station, FALSE, (int)counts[i].count);
    }
    if (longest->at > 0 && longest->is_exact)
        avg_stat_node_add_value_int(tree, "Longest interval (us)", station, FALSE,
                                    (int)((longest->recorded + NS_PER_US / 2) / NS_PER_US));
}

/* The station that the master had to ask again, or in vain. */
static void
count_asked(stats_tree *tree, packet_info *pinfo, const sis_exchange_t *exchange)
{
    if (exchange->first != NULL)
        tick_stat_node(tree, "Repeats", count_station(tree, pinfo, exchange->path[0], 0), FALSE);
    if (exchange->gave_up != 0)
        tick_stat_node(tree, "Unanswered", count_station(tree, pinfo, exchange->gave_up_station, 0), FALSE);
}

static void
count_error(stats_tree *tree, wmem_allocator_t *pool, uint32_t code, const char *text)
{
    stats_tree_tick_pivot(tree, errors_node, wmem_strdup_printf(pool, "0x%04x %s", code, text));
}

static tap_packet_status
packet(stats_tree *tree, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data, tap_flags_t flags _U_)
{
    const sis_telegram_t *telegram = data;
    const sis_exchange_t *exchange = telegram->record->exchange;

    if (!sertap_can_be_counted(pinfo))
        return TAP_PACKET_DONT_REDRAW;
    tick_stat_node(tree, telegrams_name, 0, TRUE);
    if (!telegram->is_good) {
        tick_stat_node(tree, "Damaged", telegrams_node, FALSE);
        return TAP_PACKET_REDRAW;
    }
    count_service(tree, pinfo, telegram);
    count_talker(tree, pinfo, telegram);
    if (exchange != NULL && !telegram->is_reaction)
        count_asked(tree, pinfo, exchange);
    if (telegram->status_text != NULL)
        stats_tree_tick_pivot(tree, states_node, telegram->status_text);
    if (telegram->error_text != NULL)
        count_error(tree, pinfo->pool, telegram->error, telegram->error_text);
    for (const sis_error_t *error = telegram->errors; error != NULL; error = error->next)
        count_error(tree, pinfo->pool, error->code, error->text);
    return TAP_PACKET_REDRAW;
}

void
windows_telegrams_register(void)
{
    stats_tree_register_plugin("sis", "sis", COMPAT_IN_SUBMENU("SIS telegrams"), 0, packet, init, NULL);
}
