/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "taps.h"

#include <string.h>
#include <glib.h>
#include <epan/packet.h>
#include <epan/tap.h>
#include <epan/conversation_table.h>
#include <epan/export_object.h>
#include <epan/srt_table.h>
#include <epan/stat_tap_ui.h>
#include <epan/stats_tree_priv.h>

static const char *const tree_names[] = {"sis", "sertap"};
static const char *const srt_names[] = {"sis", "rk512i", "sisascii"};

static stats_tree *trees[G_N_ELEMENTS(tree_names)];
static srt_data_t srts[G_N_ELEMENTS(srt_names)];
static conv_hash_t conversations, endpoints;
static GSList *objects;

static void
listen(const char *tap, void *data, tap_packet_cb packet)
{
    GString *error = register_tap_listener(tap, data, NULL, TL_REQUIRES_NOTHING, NULL, packet, NULL, NULL);

    if (error)
        g_error("tap %s: %s", tap, error->str);
}

static void
add_object(void *data G_GNUC_UNUSED, export_object_entry_t *entry)
{
    objects = g_slist_prepend(objects, entry);
}

static export_object_entry_t *
get_object(void *data G_GNUC_UNUSED, int row)
{
    return (export_object_entry_t *)g_slist_nth_data(objects, (guint)row);
}

static export_object_list_t object_list = {add_object, get_object, NULL};

static void
open_trees(void)
{
    for (unsigned i = 0; i < G_N_ELEMENTS(tree_names); i++) {
        stats_tree_cfg *kind = stats_tree_get_cfg_by_abbr(tree_names[i]);

        trees[i] = stats_tree_new(kind, NULL, NULL);
        listen(kind->tapname, trees[i], stats_tree_packet);
        kind->init(trees[i]);
    }
}

static void
open_srts(void)
{
    for (unsigned i = 0; i < G_N_ELEMENTS(srt_names); i++) {
        register_srt_t *kind = get_srt_table_by_name(srt_names[i]);

        srts[i].srt_array = g_array_new(FALSE, TRUE, sizeof(srt_stat_table *));
        srt_table_dissector_init(kind, srts[i].srt_array);
        listen(get_srt_tap_listener_name(kind), &srts[i], get_srt_packet_func(kind));
    }
}

/* Without fields: with them, each packet has to have a tree. */
void
taps_begin(void)
{
    if (!process_stat_cmd_arg("sis,rows"))
        g_error("there are no rows");
    start_requested_stats();
}

void
taps_open(void)
{
    register_ct_t *kind = get_conversation_by_proto_id(proto_get_id_by_filter_name("sis"));
    register_eo_t *exporter = get_eo_by_name("sis");

    open_trees();
    open_srts();
    listen("sis", &conversations, get_conversation_packet_func(kind));
    listen("sis", &endpoints, get_endpoint_packet_func(kind));
    listen(get_eo_tap_listener_name(exporter), &object_list, get_eo_packet_func(exporter));
}

static void
close_trees(void)
{
    for (unsigned i = 0; i < G_N_ELEMENTS(tree_names); i++) {
        g_string_free(stats_tree_format_as_str(trees[i], ST_FORMAT_PLAIN, 0, TRUE), TRUE);
        remove_tap_listener(trees[i]);
        stats_tree_free(trees[i]);
    }
}

static void
close_srts(void)
{
    for (unsigned i = 0; i < G_N_ELEMENTS(srt_names); i++) {
        remove_tap_listener(&srts[i]);
        free_srt_table(get_srt_table_by_name(srt_names[i]), srts[i].srt_array);
        g_array_free(srts[i].srt_array, TRUE);
    }
}

/* A name goes to the user's folder as it is. */
static void
close_object(void *data)
{
    export_object_entry_t *entry = (export_object_entry_t *)data;

    if (entry->filename && (strchr(entry->filename, '/') || strstr(entry->filename, "..")))
        g_error("an exported object is named %s", entry->filename);
    eo_free_entry(entry);
}

/* The windows of conversations and endpoints, and their filters. */
static void
use_conversations(void)
{
    for (unsigned i = 0; conversations.conv_array != NULL && i < conversations.conv_array->len; i++) {
        conv_item_t *item = &g_array_index(conversations.conv_array, conv_item_t, i);

        wmem_free(NULL, get_conversation_address(NULL, &item->src_address, TRUE));
        for (unsigned direction = 0; direction < 9; direction++)
            g_free(get_conversation_filter(item, (conv_direction_e)direction));
    }
    for (unsigned i = 0; endpoints.conv_array != NULL && i < endpoints.conv_array->len; i++)
        wmem_free(NULL, get_endpoint_filter(&g_array_index(endpoints.conv_array, endpoint_item_t, i)));
}

void
taps_close(void)
{
    draw_tap_listeners(TRUE);
    close_trees();
    close_srts();
    use_conversations();
    remove_tap_listener(&conversations);
    remove_tap_listener(&endpoints);
    reset_conversation_table_data(&conversations);
    reset_endpoint_table_data(&endpoints);
    remove_tap_listener(&object_list);
    g_slist_free_full(objects, close_object);
    objects = NULL;
    get_eo_reset_func(get_eo_by_name("sis"))();
}
