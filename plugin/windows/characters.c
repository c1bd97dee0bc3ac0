/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Statistics of the line itself: `tshark -z sertap,tree`, *Serial tap: characters and intervals*. */
#include "parts.h"

#include <epan/stats_tree.h>

#include "sertap/record.h"

static const char *const intervals_name = "Interval inside a frame (us)";
static int records_node, characters_node, intervals_node;

static void
init(stats_tree *tree)
{
    records_node = stats_tree_create_node(tree, "Records", 0, STAT_DT_INT, TRUE);
    characters_node = stats_tree_create_node(tree, "Characters", 0, STAT_DT_INT, TRUE);
    intervals_node = stats_tree_create_range_node(tree, intervals_name, 0, "0-49", "50-99", "100-199",
                                                  "200-499", "500-999", "1000-1999", "2000-4999", "5000-9999",
                                                  "10000-19999", "20000-99999", "100000-", NULL);
}

/* Counted one by one only in records with errors. */
static void
count_characters(stats_tree *tree, const sertap_record_t *record)
{
    static const struct {
        uint8_t flags;
        const char *name;
    } kinds[] = {
        {SERTAP_ERROR_CHARACTER, "With a parity or framing error"},
        {SERTAP_ERROR_BREAK, "Break"},
        {SERTAP_ERROR_LOST, "After lost characters"},
        {SERTAP_ERROR_UNLOCATED, "In a read with an error"},
        {SERTAP_SAME_READ, "In the same read as the one before"},
    };

    increase_stat_node(tree, "Characters", 0, TRUE, record->count);
    for (unsigned kind = 0; kind < array_length(kinds); kind++) {
        int count = 0;

        if (!(record->flags & kinds[kind].flags))
            continue;
        for (unsigned i = 0; i < record->timed; i++)
            count += !!(compat_get_uint8(record->tvb, record->flags_offset + i) & kinds[kind].flags);
        increase_stat_node(tree, kinds[kind].name, characters_node, FALSE, count);
    }
}

static bool
has_flag(const sertap_record_t *record, unsigned at, uint8_t flags)
{
    return at < record->timed && compat_get_uint8(record->tvb, record->flags_offset + at) & flags;
}

/* One inside a read of several, or beside it, has no exact length. */
static void
count_intervals(stats_tree *tree, const sertap_record_t *record)
{
    for (unsigned i = 1; i < record->timed; i++) {
        int us;

        if (has_flag(record, i, SERTAP_ERROR_LOST) || has_flag(record, i - 1, SERTAP_SAME_READ) ||
            has_flag(record, i, SERTAP_SAME_READ) || has_flag(record, i + 1, SERTAP_SAME_READ))
            continue;
        us = (int)(tvb_get_ntohl(record->tvb, record->times_offset + 4 * i) / 1000);
        tick_stat_node(tree, intervals_name, 0, TRUE); /* the next line adds up here, but does not count */
        stats_tree_tick_range(tree, intervals_name, 0, us);
    }
}

static tap_packet_status
packet(stats_tree *tree, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data, tap_flags_t flags _U_)
{
    static const char *const types[] = {"Frames", "Other characters", "Events"};
    const sertap_record_t *record = data;

    if (!sertap_can_be_counted(pinfo))
        return TAP_PACKET_DONT_REDRAW;
    tick_stat_node(tree, "Records", 0, TRUE);
    if (record->type < array_length(types))
        tick_stat_node(tree, types[record->type], records_node, FALSE);
    if (record->type == SERTAP_EVENT)
        return TAP_PACKET_REDRAW;
    count_characters(tree, record);
    if (record->type == SERTAP_FRAME)
        count_intervals(tree, record);
    return TAP_PACKET_REDRAW;
}

void
windows_characters_register(void)
{
    stats_tree_register_plugin("sertap", "sertap", COMPAT_IN_SUBMENU("Serial tap: characters and intervals"),
                               0, packet, init, NULL);
}
