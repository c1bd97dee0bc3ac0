/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Data that do not fit into one packet: the follow-ups of ARCNET 7F, the fragments of the parameter channel.
 */
#include "synax/pieces.h"

#include "kept.h"
#include "parts.h"
#include "protocol/fields.h"
#include "protocol/limits.h"
#include "sis/pieces.h"

/* How far a transfer is. */
typedef struct {
    uint64_t transfer;
    unsigned count;   /* of its pieces */
    uint32_t full_in; /* the first piece too many; 0: none */
} state_t;

static wmem_map_t *states; /* by transfer */

/* The number of a piece; only in the first pass. */
static unsigned
count_piece(const packet_info *pinfo, state_t *state)
{
    if (state->count == SIS_MOST_PIECES)
        state->full_in = pinfo->num;
    return state->count++;
}

tvbuff_t *
synax_put_together(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last)
{
    uint64_t key = transfer;
    state_t *state = kept_value(states, &key, sizeof key, sizeof *state);
    unsigned number = pinfo->fd->visited ? 0 : count_piece(pinfo, state);

    if (state->full_in != 0 &&
        pinfo->num >= state->full_in) { /* this one, or one after it: then none are joined */
        expert_add_info(pinfo, proto_tree_get_parent(tree), &ei_synax_pieces_too_many);
        return NULL;
    }
    return sis_put_together(SIS_PIECES_OF_SYNAX, tree, pinfo, piece, transfer, number, is_last);
}

void
synax_pieces_register(void)
{
    states = kept_map_of_numbers();
}
