/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Wireshark's standard statistics: Conversations and Endpoints by station (`tshark -z conv,sis`, `-z
 * endpoints,sis`), a tree of telegrams (`-z sis,tree`), service response times (`-z sis,srt`). */
#include "parts.h"

#include <epan/conversation_table.h>
#include <epan/srt_table.h>
#include <epan/stats_tree.h>
#include <epan/tap.h>

#include "sis/exchange.h"
#include "sis/names.h"

static const char *
conversation_filter(conv_item_t *item _U_, conv_filter_type_e filter)
{
    switch (filter) {
    case CONV_FT_SRC_ADDRESS:
        return "sis.talker";
    case CONV_FT_DST_ADDRESS:
        return "sis.listener";
    case CONV_FT_ANY_ADDRESS:
        return "sis.station";
    default:
        return CONV_FILTER_INVALID;
    }
}

static ct_dissector_info_t conversation_info = {&conversation_filter};

/* The addresses of both tables are AT_NUMERIC: the windows sort other types as text, 16 before 3. */
static tap_packet_status
conversation_packet(void *table, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data,
                    tap_flags_t flags)
{
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!telegram->is_good)
        return TAP_PACKET_DONT_REDRAW; /* its addresses are uncertain */
    hash->flags = flags;
    set_address(&talker, AT_NUMERIC, 1, &telegram->talker);
    set_address(&listener, AT_NUMERIC, 1, &telegram->listener);
    add_conversation_table_data(hash, &talker, &listener, 0, 0, 1, telegram->length, &pinfo->rel_ts,
                                &pinfo->abs_ts, &conversation_info, CONVERSATION_NONE);
    return TAP_PACKET_REDRAW;
}

static const char *
endpoint_filter(endpoint_item_t *item _U_, conv_filter_type_e filter)
{
    return filter == CONV_FT_ANY_ADDRESS ? "sis.station" : CONV_FILTER_INVALID;
}

static et_dissector_info_t endpoint_info = {&endpoint_filter};

static tap_packet_status
endpoint_packet(void *table, packet_info *pinfo _U_, epan_dissect_t *edt _U_, const void *data,
                tap_flags_t flags)
{
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!telegram->is_good)
        return TAP_PACKET_DONT_REDRAW; /* its addresses are uncertain */
    hash->flags = flags;
    set_address(&talker, AT_NUMERIC, 1, &telegram->talker);
    set_address(&listener, AT_NUMERIC, 1, &telegram->listener);
    add_endpoint_table_data(hash, &talker, 0, TRUE, 1, telegram->length, &endpoint_info, ENDPOINT_NONE);
    add_endpoint_table_data(hash, &listener, 0, FALSE, 1, telegram->length, &endpoint_info, ENDPOINT_NONE);
    return TAP_PACKET_REDRAW;
}

/* The tree's branches, all below "Telegrams". */
static const char *const telegrams_name = "Telegrams";
static int telegrams_node, services_node, talkers_node, states_node, errors_node;

static void
tree_init(stats_tree *tree)
{
    telegrams_node = stats_tree_create_node(tree, telegrams_name, 0, STAT_DT_INT, TRUE);
    services_node = stats_tree_create_node(tree, "By service", telegrams_node, STAT_DT_INT, TRUE);
    talkers_node = stats_tree_create_pivot(tree, "By talker", telegrams_node);
    states_node = stats_tree_create_pivot(tree, "Reactions by status", telegrams_node);
    errors_node = stats_tree_create_pivot(tree, "Errors", telegrams_node);
}

static void
tree_count_service(stats_tree *tree, packet_info *pinfo, const sis_telegram_t *telegram)
{
    const char *name = sis_service_name(pinfo->pool, telegram->service);
    int node;

    tick_stat_node(tree, "By service", telegrams_node, TRUE);
    node = tick_stat_node(tree, name, services_node, TRUE);
    tick_stat_node(tree, telegram->is_reaction ? "Reaction" : "Command", node, FALSE);
}

static void
tree_count_error(stats_tree *tree, wmem_allocator_t *pool, uint32_t code, const char *text)
{
    stats_tree_tick_pivot(tree, errors_node, wmem_strdup_printf(pool, "0x%04x %s", code, text));
}

static tap_packet_status
tree_packet(stats_tree *tree, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data,
            tap_flags_t flags _U_)
{
    const sis_telegram_t *telegram = data;
    wmem_allocator_t *pool = pinfo->pool;

    if (!sertap_can_be_counted(pinfo))
        return TAP_PACKET_DONT_REDRAW;
    tick_stat_node(tree, telegrams_name, 0, TRUE);
    if (!telegram->is_good) {
        tick_stat_node(tree, "Damaged", telegrams_node, FALSE);
        return TAP_PACKET_REDRAW;
    }
    tree_count_service(tree, pinfo, telegram);
    stats_tree_tick_pivot(tree, talkers_node, wmem_strdup_printf(pool, "%u", telegram->talker));
    if (telegram->status_text != NULL)
        stats_tree_tick_pivot(tree, states_node, telegram->status_text);
    if (telegram->error_text != NULL)
        tree_count_error(tree, pool, telegram->error, telegram->error_text);
    for (const sis_error_t *error = telegram->errors; error != NULL; error = error->next)
        tree_count_error(tree, pool, error->code, error->text);
    return TAP_PACKET_REDRAW;
}

#define SERVICES 256

static void
srt_init(struct register_srt *srt _U_, GArray *tables)
{
    srt_stat_table *table =
        init_srt_table("SIS services", NULL, tables, SERVICES, "Service", "sis.service", NULL);
    wmem_allocator_t *pool = wmem_allocator_new(WMEM_ALLOCATOR_SIMPLE);

    for (unsigned service = 0; service < SERVICES; service++)
        init_srt_table_row(table, (int)service, sis_service_name(pool, (uint8_t)service));
    wmem_destroy_allocator(pool);
}

/* The table subtracts it from the packet's time. */
static tap_packet_status
srt_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    srt_stat_table *table = g_array_index(((srt_data_t *)data)->srt_array, srt_stat_table *, 0);
    const sis_telegram_t *telegram = tapped;
    nstime_t command, taken;

    if (!telegram->timing.has_reaction_time)
        return TAP_PACKET_DONT_REDRAW;
    taken = sertap_time(telegram->record->exchange->reaction_time);
    nstime_delta(&command, &pinfo->abs_ts, &taken);
    add_srt_table_data(table, telegram->service, &command, pinfo);
    return TAP_PACKET_REDRAW;
}

void
sis_statistics_register(void)
{
    register_conversation_table(proto_sis, TRUE, conversation_packet, endpoint_packet);
    register_srt_table(proto_sis, "sis", 1, srt_packet, srt_init, NULL);
    stats_tree_register_plugin("sis", "sis", COMPAT_IN_SUBMENU("SIS telegrams"), 0, tree_packet, tree_init,
                               NULL);
}
