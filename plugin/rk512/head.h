/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The Indramat head of 6 bytes: info access, axis, parameter. ARCNET 7F has it with the low byte first
 * (chapter 7), 3964R with the high byte first (chapter 8). */

#ifndef RK512_HEAD_H
#define RK512_HEAD_H

#include "parameters/parameters.h"

#define SYNAX_HEAD_SIZE 6u

typedef struct {
    uint16_t info;
    bool is_parameter; /* else only the info access is known */
    bool is_last;
    uint8_t axis;
    sis_ident_t ident;
    sis_known_t known; /* data of the tables about it */
} synax_head_t;

/* Whether the head names a parameter: undocumented bits of the info access choose other services. */
bool synax_is_parameter(uint16_t info);

/* The meaning of a data block (chapters 7 and 8): 98 to 116 have one; NULL: none. */
const char *synax_block_text(unsigned number);

/* Adds the number of a data block as field `hf`, with its meaning. */
proto_item *synax_add_block(proto_tree *tree, int hf, tvbuff_t *tvb, unsigned offset);

/* Adds the words of data block 99 or 100 as fields `hf`. Of other blocks nothing is known. */
void synax_add_block_words(proto_tree *tree, packet_info *pinfo, int hf, tvbuff_t *tvb, unsigned block,
                           unsigned encoding);

/* The head of a command, for an answer that does not repeat it. */
synax_head_t synax_head_of(uint16_t info, uint8_t axis, sis_ident_t ident);

/* Adds sis.parameter if a command named it, and its words for the packet list. */
void synax_recall_head(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, const synax_head_t *head,
                       wmem_strbuf_t *words);
/* Adds the info access at `offset`; notes its undocumented bits, except those in `known`. */
void synax_add_info(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
                    uint16_t known);

/* Adds the complete head of 6 bytes at `offset`. Appends words for the packet list: "Read S-0-0237, axis
 * 2". */
synax_head_t synax_add_head(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset,
                            unsigned encoding, wmem_strbuf_t *words);

/* Adds the data of that parameter, from `offset` to the end of `tvb`, and appends its value to the words. */
void synax_add_data(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, unsigned offset, unsigned encoding,
                    const synax_head_t *head, wmem_strbuf_t *words);

#endif
