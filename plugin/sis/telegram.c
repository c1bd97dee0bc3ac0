/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The header of a telegram (chapter 2.1), and the data of its packet. */
#include "sis/telegram.h"

#include <epan/proto_data.h>

#include "protocol/fields.h"

int sis_tap = -1;

sis_packet_t *
sis_packet(packet_info *pinfo)
{
    sis_packet_t *packet = p_get_proto_data(pinfo->pool, pinfo, proto_sis, 0);

    if (packet == NULL) {
        packet = wmem_new0(pinfo->pool, sis_packet_t);
        p_add_proto_data(pinfo->pool, pinfo, proto_sis, 0, packet);
    }
    return packet;
}

sis_telegram_t *
sis_telegram_read(tvbuff_t *tvb, packet_info *pinfo)
{
    sis_telegram_t *telegram = wmem_new0(pinfo->pool, sis_telegram_t);
    const uint8_t *header = tvb_get_ptr(tvb, 0, SIS_STATIC_LENGTH);
    unsigned there = tvb_reported_length(tvb);
    const sis_telegram_t *before = sis_packet(pinfo)->last;
    const sertap_record_t *tap = sertap_record(pinfo);

    telegram->tvb = tvb;
    telegram->is_before = tap != NULL && tap->type == SERTAP_BEFORE;
    telegram->control = header[4];
    telegram->service = header[5];
    telegram->sender = header[6];
    telegram->receiver = header[7];
    telegram->subaddress_count = telegram->control & SIS_CONTROL_SUBADDRESSES;
    telegram->is_reaction = telegram->control & SIS_CONTROL_REACTION;
    telegram->talker = telegram->is_reaction ? telegram->receiver : telegram->sender;
    telegram->listener = telegram->is_reaction ? telegram->sender : telegram->receiver;
    telegram->body_offset =
        SIS_STATIC_LENGTH + telegram->subaddress_count + ((telegram->control & SIS_CONTROL_NUMBER) ? 1 : 0);
    telegram->declared = sis_declared_length(tvb, 0);
    telegram->length = telegram->declared != 0 ? MIN(there, telegram->declared) : there;
    telegram->times = sis_times(tvb, pinfo, telegram->length, before != NULL ? &before->times : NULL);
    telegram->is_good = telegram->body_offset <= telegram->declared && sis_is_good(tvb, 0);
    telegram->last_address = telegram->receiver;
    if (telegram->is_good && telegram->subaddress_count > 0)
        telegram->last_address = compat_get_uint8(tvb, SIS_STATIC_LENGTH + telegram->subaddress_count - 1);
    if (telegram->is_good && (telegram->control & SIS_CONTROL_NUMBER))
        telegram->number = compat_get_uint8(tvb, telegram->body_offset - 1);
    return telegram;
}

static void
count_field(proto_node *node, void *counts)
{
    const field_info *field = PNODE_FINFO(node);

    if (field != NULL && g_str_has_prefix(field->hfinfo->abbrev, "sis.")) {
        void *name = (void *)field->hfinfo->abbrev;
        unsigned before = GPOINTER_TO_UINT(g_hash_table_lookup(counts, name));

        g_hash_table_insert(counts, name, GUINT_TO_POINTER(before + 1));
    }
    proto_tree_children_foreach(node, count_field, counts);
}

/* "sis.service=1 sis.start=1", in the order of the names. */
static const char *
fields_text(wmem_allocator_t *scope, proto_tree *tree)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");
    GHashTable *counts = g_hash_table_new(g_str_hash, g_str_equal);
    GList *names;

    proto_tree_children_foreach(tree, count_field, counts);
    names = g_list_sort(g_hash_table_get_keys(counts), (GCompareFunc)strcmp);
    for (const GList *name = names; name != NULL; name = name->next)
        wmem_strbuf_append_printf(text, "%s%s=%u", name == names ? "" : " ", (const char *)name->data,
                                  GPOINTER_TO_UINT(g_hash_table_lookup(counts, name->data)));
    g_list_free(names);
    g_hash_table_destroy(counts);
    return wmem_strbuf_get_str(text);
}

void
sis_tell_packed(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    bool is_first = sis_packet(pinfo)->telegrams++ == 0;

    if (is_first || tree == NULL || !proto_field_is_referenced(tree, hf_sis_packed))
        return;
    proto_item_set_hidden(
        proto_tree_add_string(tree, hf_sis_packed, tvb, 0, 0, fields_text(pinfo->pool, tree)));
}
