/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Which fields are whose, where TCP has put several telegrams into a packet. `tshark -T fields` prints all
 * values of a field together. So each telegram but the first says which fields it has, and how many values of
 * each: the rest is of the first. */
#include "sis/packed.h"

#include "protocol/fields.h"
#include "sis/telegram.h"

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
