/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The Indramat head: info access (2 bytes), axis, type of parameter, parameter (2 bytes). Page 8-15, and 7-14
 * for ARCNET. */
#include "rk512/head.h"

#include "parameters/ident.h"
#include "parameters/values.h"
#include "protocol/fields.h"

#define SHOWN_BYTES 8 /* in the packet list */

#define FIRST_BY_LIST 101
#define LAST_BY_LIST  108
#define CONFIGURATION 58 /* C-0-0058 configures data block 101 (pages 7-16 and 8-11) */

const char *
synax_block_text(unsigned number)
{
    return try_rval_to_str(number, sis_synax_blocks);
}

proto_item *
synax_add_block(proto_tree *tree, int hf, tvbuff_t *tvb, unsigned offset)
{
    unsigned number = compat_get_uint8(tvb, offset);
    proto_item *item = proto_tree_add_item(tree, hf, tvb, offset, 1, ENC_NA);

    if (synax_block_text(number) != NULL)
        proto_item_append_text(item, " (%s)", synax_block_text(number));
    if (number >= FIRST_BY_LIST && number <= LAST_BY_LIST)
        proto_item_append_text(item, ", by C-0-%04d", number - FIRST_BY_LIST + CONFIGURATION);
    return item;
}

void
synax_add_block_words(proto_tree *tree, packet_info *pinfo, int hf, tvbuff_t *tvb, unsigned block,
                      unsigned encoding)
{
    if (block != SYNAX_BLOCK_IO && block != SYNAX_BLOCK_MODE)
        return;
    for (unsigned at = 0; at + 2 <= tvb_captured_length(tvb); at += 2)
        proto_tree_add_item(tree, hf, tvb, at, 2, encoding);
    if (block == SYNAX_BLOCK_MODE)
        expert_add_info_format(pinfo, proto_tree_get_parent(tree), &ei_synax_note,
                               "No document says which value is which mode");
}

bool
synax_is_parameter(uint16_t info)
{
    return (info & SYNAX_INFO_OPEN) == 0;
}

/* Elements and other services (pages 8-18 to 8-23) use undocumented bits. */
void
synax_add_info(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               uint16_t known)
{
    uint16_t info = compat_get_uint16(tvb, offset, encoding), open = info & SYNAX_INFO_OPEN & ~known;
    static int *const bits[] = {&hf_synax_info_open, &hf_synax_info_last, &hf_synax_info_write, NULL};
    proto_item *item = proto_tree_add_bitmask_with_flags(tree, tvb, offset, hf_synax_info, ett_synax_info,
                                                         bits, encoding, BMT_NO_APPEND);

    proto_item_append_text(item, " (%s, %s)", info & SYNAX_INFO_WRITE ? "write" : "read",
                           info & SYNAX_INFO_LAST ? "last transmission" : "more follows");
    if (open != 0)
        expert_add_info_format(pinfo, item, &ei_synax_note,
                               "Bits 2 to 15 of the info access are not defined. They may choose an element, "
                               "the mode, inputs and outputs, or axes");
}

synax_head_t
synax_head_of(uint16_t info, uint8_t axis, sis_ident_t ident)
{
    return (synax_head_t){info,  synax_is_parameter(info),          info & SYNAX_INFO_LAST, axis,
                          ident, sis_known_from_tables(NULL, ident)};
}

static void
say_parameter(packet_info *pinfo, const synax_head_t *head, wmem_strbuf_t *words)
{
    if (!head->is_parameter) {
        wmem_strbuf_append_printf(words, "Info access 0x%04x", head->info);
        return;
    }
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

    if (head->is_parameter)
        sis_add_ident(tree, pinfo->pool, tvb, &nowhere, head->ident, &head->known);
    say_parameter(pinfo, head, words);
}

synax_head_t
synax_add_head(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               wmem_strbuf_t *words)
{
    uint16_t info = compat_get_uint16(tvb, offset, encoding);
    sis_ident_t ident = {.type = compat_get_uint8(tvb, offset + 3),
                         .number = compat_get_uint16(tvb, offset + 4, encoding)};
    synax_head_t head = synax_head_of(info, compat_get_uint8(tvb, offset + 2), ident);
    sis_ident_place_t place = {offset + 3, 3, offset + 3, offset + 4, encoding};

    synax_add_info(tree, pinfo, tvb, offset, encoding, 0);
    if (head.is_parameter) {
        proto_tree_add_item(tree, hf_synax_axis, tvb, offset + 2, 1, ENC_NA);
        sis_add_ident(tree, pinfo->pool, tvb, &place, ident, &head.known);
        wmem_strbuf_append(words, info & SYNAX_INFO_WRITE ? "Write " : "Read ");
    } else {
        proto_tree_add_item(tree, hf_sis_raw, tvb, offset + 2, SYNAX_HEAD_SIZE - 2, ENC_NA);
    }
    say_parameter(pinfo, &head, words);
    return head;
}

void
synax_add_data(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
               const synax_head_t *head, wmem_strbuf_t *words)
{
    sis_element_data_t data = {tvb_new_subset_remaining(tvb, offset), encoding, true, NULL};
    unsigned length = tvb_captured_length(data.tvb);
    const char *text = NULL, *misfit = NULL;

    if (head->is_parameter) {
        text = sis_add_element(tree, pinfo, &data, SIS_ELEMENT_DATA, &head->ident, &head->known);
        misfit = sis_element_misfit(&data, SIS_ELEMENT_DATA, &head->known);
    } else if (length > 0) {
        proto_tree_add_item(tree, hf_sis_raw, data.tvb, 0, -1, ENC_NA);
    }
    if (text != NULL)
        wmem_strbuf_append_printf(words, " = %s", text);
    else if (length > 0)
        wmem_strbuf_append_printf(
            words, ", %u byte%s%s%s", length, plurality(length, "", "s"), length > SHOWN_BYTES ? "" : ": ",
            length > SHOWN_BYTES ? "" : tvb_bytes_to_str_punct(pinfo->pool, data.tvb, 0, (int)length, ' '));
    if (misfit != NULL)
        expert_add_info_format(pinfo, proto_tree_get_parent(tree), &ei_synax_note, "%s", misfit);
}
