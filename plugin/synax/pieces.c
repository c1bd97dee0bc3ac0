/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Data that do not fit into one packet: the follow-ups of ARCNET 7F, the fragments of the parameter channel.
 */

#include "synax/pieces.h"

#include <epan/reassemble.h>

#include "synax/fields.h"

#define MOST_PIECES 8192u /* 64 KB in pieces of 8 bytes; Wireshark searches all of them for each */

static int hf_pieces = -1;
static int hf_piece = -1;
static int hf_overlap = -1;
static int hf_overlap_conflict = -1;
static int hf_multiple_tails = -1;
static int hf_too_long = -1;
static int hf_error = -1;
static int hf_count = -1;
static int hf_whole_in = -1;
static int hf_length = -1;

static int ett_pieces = -1;
static int ett_piece = -1;

static const fragment_items items = {
    &ett_piece,           &ett_pieces,        &hf_pieces,   &hf_piece, &hf_overlap,
    &hf_overlap_conflict, &hf_multiple_tails, &hf_too_long, &hf_error, &hf_count,
    &hf_whole_in,         &hf_length,         NULL,         "pieces",
};

static reassembly_table table;
static wmem_map_t *counters; /* of the file: a single one, how many transfers there are */
static wmem_map_t *counts;   /* of pieces, by transfer */
static wmem_map_t *full_in;  /* by transfer: the frame of the first piece too many */

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
synax_next_transfer(void)
{
    uint32_t number = GPOINTER_TO_UINT(wmem_map_lookup(counters, NULL)) + 1;

    wmem_map_insert(counters, NULL, GUINT_TO_POINTER(number));
    return number;
}

/* The number of a piece; only in the first pass. */
static unsigned
count_piece(const packet_info *pinfo, uint32_t transfer)
{
    void *key = GUINT_TO_POINTER(transfer);
    unsigned number = GPOINTER_TO_UINT(wmem_map_lookup(counts, key));

    wmem_map_insert(counts, key, GUINT_TO_POINTER(number + 1));
    if (number == MOST_PIECES)
        wmem_map_insert(full_in, key, GUINT_TO_POINTER(pinfo->num));
    return number;
}

/* A piece too many, or one after it: then none are joined. */
static bool
is_too_many(const packet_info *pinfo, uint32_t transfer)
{
    uint32_t first = GPOINTER_TO_UINT(wmem_map_lookup(full_in, GUINT_TO_POINTER(transfer)));

    return first != 0 && pinfo->num >= first;
}

tvbuff_t *
synax_put_together(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last)
{
    unsigned number = pinfo->fd->visited ? 0 : count_piece(pinfo, transfer);
    fragment_head *head;

    if (is_too_many(pinfo, transfer)) {
        expert_add_info(pinfo, proto_tree_get_parent(tree), &ei_synax_too_many);
        return NULL;
    }
    head = fragment_add_seq_check(&table, piece, 0, pinfo, transfer, NULL, number, tvb_captured_length(piece),
                                  !is_last);
    if (is_last)
        return process_reassembled_data(piece, 0, pinfo, "Data of all pieces", head, &items, NULL, tree);
    if (head != NULL)
        proto_item_set_generated(proto_tree_add_uint(tree, hf_whole_in, piece, 0, 0, head->reassembled_in));
    return NULL;
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_pieces, {"Pieces", "synax.pieces", FT_NONE, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_piece, {"Piece", "synax.pieces.piece", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_overlap, {"Overlap", "synax.pieces.overlap", FT_BOOLEAN, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_overlap_conflict, {"Overlap with other data", "synax.pieces.overlap.conflict", FT_BOOLEAN, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_multiple_tails, {"Several last pieces", "synax.pieces.multiple_tails", FT_BOOLEAN, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_too_long, {"Piece too long", "synax.pieces.too_long", FT_BOOLEAN, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_error, {"Error while putting together", "synax.pieces.error", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_count, {"Number of pieces", "synax.pieces.count", FT_UINT32, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_whole_in, {"The whole is in", "synax.pieces.whole_in", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_length, {"Length of the whole", "synax.pieces.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&units_byte_bytes), 0, NULL, HFILL}},
};
/* clang-format on */

void
synax_pieces_register(void)
{
    static const reassembly_table_functions functions = {g_direct_hash, g_direct_equal, transfer_key,
                                                         transfer_key,  free_nothing,   free_nothing};
    static int *trees[] = {&ett_pieces, &ett_piece};

    proto_register_field_array(proto_synax, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    reassembly_table_register(&table, &functions);
    counters = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), g_direct_hash, g_direct_equal);
    counts = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), g_direct_hash, g_direct_equal);
    full_in = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), g_direct_hash, g_direct_equal);
}
