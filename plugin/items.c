/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Items of the packet details. */
#include "items.h"

proto_item *
add_generated(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t value)
{
    proto_item *item = proto_tree_add_uint(tree, hf, tvb, 0, 0, value);

    proto_item_set_generated(item);
    return item;
}

proto_item *
add_link(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t frame)
{
    return frame != 0 ? add_generated(tree, hf, tvb, frame) : NULL;
}

void
add_bytes(proto_tree *tree, int hf, tvbuff_t *tvb, unsigned offset, unsigned end)
{
    if (end > offset)
        proto_tree_add_item(tree, hf, tvb, offset, end - offset, ENC_NA);
}

void
format_ms(char *text, double ms)
{
    g_ascii_formatd(text, ITEM_LABEL_LENGTH, "%.3f", ms); /* unlike printf(), the same in all languages */
}
