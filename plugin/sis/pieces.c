/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reassembles data that come in pieces, with Wireshark's reassembly. */
#include "sis/pieces.h"

#include <epan/reassemble.h>

#include "items.h"
#include "kept.h"
#include "parts.h"
#include "protocol/fields.h"
#include "protocol/limits.h"

#define FIELDS(pieces)                                                                                       \
    &hf_##pieces, &hf_##pieces##_piece, &hf_##pieces##_overlap, &hf_##pieces##_overlap_conflict,             \
        &hf_##pieces##_multiple_tails, &hf_##pieces##_too_long, &hf_##pieces##_error, &hf_##pieces##_count,  \
        &hf_##pieces##_whole_in, &hf_##pieces##_length, NULL

static const fragment_items items[SIS_PIECES_KINDS] = {
    [SIS_PIECES_OF_SIS] = {&ett_sis_piece, &ett_sis_sequence, FIELDS(sis_sequence), "pieces"},
    [SIS_PIECES_OF_SYNAX] = {&ett_synax_piece, &ett_synax_pieces, FIELDS(synax_pieces), "pieces"},
};

/* How far a transfer of SYNAX is. */
typedef struct {
    uint64_t transfer;
    unsigned count;   /* of its pieces */
    uint32_t full_in; /* the first piece too many; 0: none */
} state_t;

static reassembly_table table;
static wmem_map_t *states;   /* by transfer */
static wmem_map_t *counters; /* of the file: a single one, how many transfers there are */

/* The number alone identifies a transfer: the stations were compared before. */
static void *
transfer_key(const packet_info *pinfo _U_, const uint32_t id, const void *data _U_)
{
    return GUINT_TO_POINTER(id);
}

static void
free_nothing(void *key _U_)
{
}

uint32_t
sis_next_transfer(void)
{
    uint32_t number = GPOINTER_TO_UINT(wmem_map_lookup(counters, NULL)) + 1;

    wmem_map_insert(counters, NULL, GUINT_TO_POINTER(number));
    return number;
}

tvbuff_t *
sis_put_together(sis_pieces_t kind, proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer,
                 unsigned number, bool is_last)
{
    fragment_head *head = fragment_add_seq_check(&table, piece, 0, pinfo, transfer, NULL, number,
                                                 tvb_captured_length(piece), !is_last);

    if (is_last)
        return process_reassembled_data(piece, 0, pinfo, "Data of all pieces", head, &items[kind], NULL,
                                        tree);
    /* Not by process_reassembled_data(): the last piece may be in this packet, too. */
    if (head != NULL)
        add_generated(tree, *items[kind].hf_reassembled_in, piece, head->reassembled_in);
    return NULL;
}

tvbuff_t *
sis_put_next(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last)
{
    uint64_t key = transfer;
    state_t *state = kept_value(states, &key, sizeof key, sizeof *state);
    unsigned number = pinfo->fd->visited ? 0 : state->count++;

    if (!pinfo->fd->visited && number == SIS_MOST_PIECES)
        state->full_in = pinfo->num;
    if (state->full_in != 0 && pinfo->num >= state->full_in) { /* this one, or one after it */
        expert_add_info(pinfo, proto_tree_get_parent(tree), &ei_synax_pieces_too_many);
        return NULL;
    }
    return sis_put_together(SIS_PIECES_OF_SYNAX, tree, pinfo, piece, transfer, number, is_last);
}

void
sis_pieces_register(void)
{
    static const reassembly_table_functions functions = {g_direct_hash, g_direct_equal, transfer_key,
                                                         transfer_key,  free_nothing,   free_nothing};

    reassembly_table_register(&table, &functions);
    counters = kept_map(g_direct_hash, g_direct_equal);
    states = kept_map_of_numbers();
}
