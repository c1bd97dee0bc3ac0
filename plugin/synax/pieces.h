/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Data that do not fit into one packet, put together. Who begins and ends a transfer is decided elsewhere. */

#ifndef SYNAX_PIECES_H
#define SYNAX_PIECES_H

#include "compat.h"

/* For the first piece, in the first pass: a number that no other transfer of the file has. */
uint32_t synax_next_transfer(void);

/* Adds a piece, all of `piece`, of a transfer. Gives the whole where this is its last piece. */
tvbuff_t *
synax_put_together(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last);

void synax_pieces_register(void);

#endif
