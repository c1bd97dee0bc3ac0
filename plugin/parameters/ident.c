/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A parameter in the tree: its ident bit by bit (fig. 8-3), and what is known of it. */

#include "parameters/ident.h"

#include "parameters/fields.h"

int hf_sis_parameter = -1;

static int hf_name = -1;
static int hf_unit = -1;
static int hf_minimum = -1;
static int hf_maximum = -1;
static int hf_type = -1;
static int hf_profile = -1;
static int hf_set = -1;
static int hf_number = -1;
static int ett_ident = -1;

static void
add_generated(proto_tree *tree, tvbuff_t *tvb, int hf, const char *text, const char *source)
{
    proto_item *item;

    if (text == NULL)
        return;
    item = proto_tree_add_string(tree, hf, tvb, 0, 0, text);
    proto_item_set_generated(item);
    proto_item_append_text(item, " (%s)", source);
}

/* What is known of a parameter, and the source. */
static void
add_known(proto_tree *tree, tvbuff_t *tvb, const sis_known_t *known)
{
    static const char *const sources[] = {"", "learned from the bus", "from the table SIS parameters",
                                          "built in"};

    add_generated(tree, tvb, hf_name, known->name, sources[known->name_from]);
    add_generated(tree, tvb, hf_unit, known->unit, sources[known->unit_from]);
    add_generated(tree, tvb, hf_minimum, known->minimum, sources[SIS_FROM_BUS]);
    add_generated(tree, tvb, hf_maximum, known->maximum, sources[SIS_FROM_BUS]);
}

/* Bit 15 tells S from P; a control parameter has neither. */
static void
add_parts(proto_tree *tree, tvbuff_t *tvb, const sis_ident_place_t *place, sis_ident_t ident)
{
    static int *const bits_drive[] = {&hf_profile, &hf_set, &hf_number, NULL};
    static int *const bits_control[] = {&hf_set, &hf_number, NULL};

    if (place->type_at != SIS_NO_TYPE_BYTE)
        proto_tree_add_item(tree, hf_type, tvb, place->type_at, 1, ENC_NA);
    proto_tree_add_bitmask_list(tree, tvb, place->number_at, 2, ident.type == 0 ? bits_drive : bits_control,
                                place->encoding);
}

proto_item *
sis_add_ident(proto_tree *tree, wmem_allocator_t *scope, tvbuff_t *tvb, const sis_ident_place_t *place,
              sis_ident_t ident, const sis_known_t *known)
{
    proto_item *item = proto_tree_add_string(tree, hf_sis_parameter, tvb, place->offset, place->length,
                                             sis_ident_text(scope, ident));
    proto_tree *subtree = proto_item_add_subtree(item, ett_ident);

    if (known->name != NULL)
        proto_item_append_text(item, " (%s)", known->name);
    if (place->length > 0)
        add_parts(subtree, tvb, place, ident);
    else
        proto_item_set_generated(item);
    add_known(subtree, tvb, known);
    return item;
}

/* clang-format off */
static const value_string parameter_types[] = {
    {0, "Parameter of a drive"},
    {1, "Control parameter, first kind (A)"},
    {2, "Control parameter, second kind (C)"},
    {0, NULL},
};

static const true_false_string product_standard = {"P, product-specific", "S, standard"};

static hf_register_info fields[] = {
    {&hf_sis_parameter, {"Parameter", "sis.parameter", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_name, {"Name", "sis.parameter.name", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_unit, {"Unit", "sis.parameter.unit", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_minimum, {"Minimum", "sis.parameter.minimum", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_maximum, {"Maximum", "sis.parameter.maximum", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_type, {"Type", "sis.parameter.type", FT_UINT8, BASE_DEC, VALS(parameter_types), 0, NULL, HFILL}},
    {&hf_profile, {"Kind", "sis.parameter.product_specific", FT_BOOLEAN, 16, TFS(&product_standard), 0x8000, NULL, HFILL}},
    {&hf_set, {"Parameter set", "sis.parameter.set", FT_UINT16, BASE_DEC, NULL, 0x7000, NULL, HFILL}},
    {&hf_number, {"Number", "sis.parameter.number", FT_UINT16, BASE_DEC, NULL, 0x0FFF, NULL, HFILL}},
};
/* clang-format on */

void
sis_ident_register(void)
{
    static int *trees[] = {&ett_ident};

    proto_register_field_array(proto_sis, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
}
