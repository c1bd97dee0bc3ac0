/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reassembles data that come in pieces. The callers decide where a transfer begins and ends. */

#ifndef SIS_PIECES_H
#define SIS_PIECES_H

#include "compat.h"

/* In the first pass: a number that no other transfer of the file has. */
uint32_t sis_next_transfer(void);

/* Whose fields show the pieces. */
typedef enum { SIS_PIECES_OF_SIS, SIS_PIECES_OF_SYNAX, SIS_PIECES_KINDS } sis_pieces_t;

/* Adds a piece, all of `piece`, to a transfer. Its number from 0 counts only in the first pass. Returns the
 * whole with its last piece. */
tvbuff_t *sis_put_together(sis_pieces_t kind, proto_tree *tree, packet_info *pinfo, tvbuff_t *piece,
                           uint32_t transfer, unsigned number, bool is_last);

/* The same for SYNAX: the pieces are numbered here, and after too many of them none are joined. */
tvbuff_t *
sis_put_next(proto_tree *tree, packet_info *pinfo, tvbuff_t *piece, uint32_t transfer, bool is_last);

#endif
