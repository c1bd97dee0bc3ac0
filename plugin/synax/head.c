/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The Indramat head: info access (2 bytes), axis, type of parameter, parameter (2 bytes). Page 8-15, and 7-14
 * for ARCNET. */

#include "synax/head.h"

#include "parameters/fields.h"
#include "parameters/ident.h"
#include "parameters/values.h"
#include "synax/fields.h"

#define INFO_WRITE 0x0001
#define INFO_LAST  0x0002
#define INFO_OPEN  0xFFFC

#define SHOWN_BYTES 8 /* in the packet list */

static int hf_info = -1;
static int hf_info_open = -1;
static int hf_info_last = -1;
static int hf_info_write = -1;
static int hf_axis = -1;

static int ett_info = -1;

const char *
synax_block_text(unsigned number)
{
    static const value_string blocks[] = {{98, "cancel a transmission with follow-ups"},
                                          {99, "inputs and outputs of the PPC"},
                                          {100, "mode of the PPC"},
                                          {0, NULL}};

    if (number >= 101 && number <= 116)
        return "freely configured";
    return try_val_to_str(number, blocks);
}

/* Elements and other services use undocumented bits. */
void
synax_add_info(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               uint16_t known)
{
    uint16_t info = compat_get_uint16(tvb, offset, encoding), open = info & INFO_OPEN & ~known;
    static int *const bits[] = {&hf_info_open, &hf_info_last, &hf_info_write, NULL};
    proto_item *item = proto_tree_add_bitmask_with_flags(tree, tvb, offset, hf_info, ett_info, bits, encoding,
                                                         BMT_NO_APPEND);

    proto_item_append_text(item, " (%s, %s)", info & INFO_WRITE ? "write" : "read",
                           info & INFO_LAST ? "last transmission" : "more follows");
    if (open != 0)
        expert_add_info_format(pinfo, item, &ei_synax_note,
                               "Bits 2 to 15 of the info access are not defined: 0x%04x", open);
}

synax_head_t
synax_head_of(uint16_t info, uint8_t axis, sis_ident_t ident)
{
    return (synax_head_t){info & INFO_WRITE, info & INFO_LAST, axis, ident, sis_known_from_tables(ident)};
}

static void
say_parameter(packet_info *pinfo, const synax_head_t *head, wmem_strbuf_t *words)
{
    wmem_strbuf_append(words, sis_ident_text(pinfo->pool, head->ident));
    if (head->known.name != NULL)
        wmem_strbuf_append_printf(words, " (%s)", head->known.name);
    wmem_strbuf_append_printf(words, ", axis %u", head->axis);
}

void
synax_recall_head(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, const synax_head_t *head,
                  wmem_strbuf_t *words)
{
    static const sis_ident_place_t nowhere = {0};

    sis_add_ident(tree, pinfo->pool, tvb, &nowhere, head->ident, &head->known);
    say_parameter(pinfo, head, words);
}

synax_head_t
synax_add_head(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               wmem_strbuf_t *words)
{
    uint16_t info = compat_get_uint16(tvb, offset, encoding);
    sis_ident_t ident = {compat_get_uint8(tvb, offset + 3), compat_get_uint16(tvb, offset + 4, encoding)};
    synax_head_t head = synax_head_of(info, compat_get_uint8(tvb, offset + 2), ident);
    sis_ident_place_t place = {offset + 3, 3, offset + 3, offset + 4, encoding};

    synax_add_info(tree, pinfo, tvb, offset, encoding, 0);
    proto_tree_add_item(tree, hf_axis, tvb, offset + 2, 1, ENC_NA);
    sis_add_ident(tree, pinfo->pool, tvb, &place, ident, &head.known);
    wmem_strbuf_append(words, head.is_write ? "Write " : "Read ");
    say_parameter(pinfo, &head, words);
    return head;
}

void
synax_add_data(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               const synax_head_t *head, wmem_strbuf_t *words)
{
    sis_element_data_t data = {tvb_new_subset_remaining(tvb, offset), encoding, true};
    unsigned length = tvb_captured_length(data.tvb);
    const char *text = sis_add_element(tree, pinfo, &data, SIS_ELEMENT_DATA, &head->ident, &head->known);
    const char *misfit = sis_element_misfit(pinfo->pool, &data, SIS_ELEMENT_DATA, &head->known);

    if (text != NULL)
        wmem_strbuf_append_printf(words, " = %s", text);
    else if (length > 0)
        wmem_strbuf_append_printf(
            words, ", %u byte%s%s%s", length, plurality(length, "", "s"), length > SHOWN_BYTES ? "" : ": ",
            length > SHOWN_BYTES ? "" : tvb_bytes_to_str_punct(pinfo->pool, data.tvb, 0, (int)length, ' '));
    if (misfit != NULL)
        expert_add_info_format(pinfo, proto_tree_get_parent(tree), &ei_synax_note, "%s", misfit);
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_info, {"Info access", "synax.info", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_info_open, {"Not defined", "synax.info.open", FT_UINT16, BASE_HEX, NULL, INFO_OPEN, NULL, HFILL}},
    {&hf_info_last, {"Last transmission", "synax.info.last", FT_BOOLEAN, 16, NULL, INFO_LAST, NULL, HFILL}},
    {&hf_info_write, {"Write", "synax.info.write", FT_BOOLEAN, 16, NULL, INFO_WRITE, NULL, HFILL}},
    {&hf_axis, {"Axis", "synax.axis", FT_UINT8, BASE_DEC, NULL, 0, "Drive, 0: none; with a data block its number", HFILL}},
};
/* clang-format on */

void
synax_head_register(void)
{
    static int *trees[] = {&ett_info};

    proto_register_field_array(proto_synax, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
}
