/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A parameter in the tree: its ident bit by bit (fig. 8-3), and what is known of it. */
#include "parameters/ident.h"

#include "protocol/fields.h"

/* Where something is from, in words. */
static const char *
source_text(wmem_allocator_t *scope, const sis_known_t *known, sis_source_t from)
{
    static const char *const sources[] = {
        [SIS_FROM_NOWHERE] = "",
        [SIS_FROM_BUS] = "learned from the bus",
        [SIS_FROM_TABLE] = "from the table SIS parameters",
        [SIS_BUILT_IN] = "built in",
        [SIS_FROM_STANDARD] = "from Wireshark's SERCOS III table",
    };

    if (from != SIS_FROM_TWIN)
        return sources[from];
    return wmem_strdup_printf(scope, "learned from station %s, device %u, which has the same type",
                              sis_place_text(scope, known->twin), known->twin->device);
}

/* What is known of a parameter, and the source. */
static void
add_known(proto_tree *tree, wmem_allocator_t *scope, tvbuff_t *tvb, const sis_known_t *known)
{
    const struct {
        int hf;
        const char *text;
        sis_source_t from;
    } parts[] = {
        {hf_sis_parameter_name, known->name, known->name_from},
        {hf_sis_parameter_unit, known->unit, known->unit_from},
        {hf_sis_parameter_minimum, known->minimum, known->minimum_from},
        {hf_sis_parameter_maximum, known->maximum, known->maximum_from},
    };

    for (unsigned i = 0; i < array_length(parts); i++) {
        proto_item *item;

        if (parts[i].text == NULL)
            continue;
        item = proto_tree_add_string(tree, parts[i].hf, tvb, 0, 0, parts[i].text);
        proto_item_set_generated(item);
        proto_item_append_text(item, " (%s)", source_text(scope, known, parts[i].from));
    }
}

/* Bit 15 tells S from P; a control parameter has neither. */
static void
add_parts(proto_tree *tree, tvbuff_t *tvb, const sis_ident_place_t *place, sis_ident_t ident)
{
    static int *const bits_drive[] = {&hf_sis_parameter_product_specific, &hf_sis_parameter_set,
                                      &hf_sis_parameter_number, NULL};
    static int *const bits_control[] = {&hf_sis_parameter_set, &hf_sis_parameter_number, NULL};

    if (place->type_at != SIS_NO_TYPE_BYTE)
        proto_tree_add_item(tree, hf_sis_parameter_type, tvb, place->type_at, 1, ENC_NA);
    proto_tree_add_bitmask_list(tree, tvb, place->number_at, 2, ident.type == 0 ? bits_drive : bits_control,
                                place->encoding);
}

proto_item *
sis_add_ident(proto_tree *tree, wmem_allocator_t *scope, tvbuff_t *tvb, const sis_ident_place_t *place,
              sis_ident_t ident, const sis_known_t *known)
{
    proto_item *item = proto_tree_add_string(tree, hf_sis_parameter, tvb, place->offset, place->length,
                                             sis_ident_text(scope, ident));
    proto_tree *subtree = proto_item_add_subtree(item, ett_sis_ident);

    if (known->name != NULL)
        proto_item_append_text(item, " (%s)", known->name);
    if (place->length > 0)
        add_parts(subtree, tvb, place, ident);
    else
        proto_item_set_generated(item);
    add_known(subtree, scope, tvb, known);
    return item;
}
