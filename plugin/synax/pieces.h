/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reassembles data of several packets. The callers decide where a transfer begins and ends. */

#ifndef SYNAX_PIECES_H
#define SYNAX_PIECES_H

#include "compat.h"

/* Adds a piece, all of `piece`, to a transfer. Returns the whole with its last piece. */
tvbuff_t *
synax_put_together(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last);

#endif
