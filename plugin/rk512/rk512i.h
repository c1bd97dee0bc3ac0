/* SPDX-License-Identifier: GPL-2.0-or-later */
/* RK512 with the Indramat extension. */

#ifndef RK512_RK512I_H
#define RK512_RK512I_H

#include "compat.h"

/* The data argument for the dissector of a block. */
typedef struct {
    bool is_repeat; /* the same block again */
} rk512i_block_t;

/* Received by the tap "rk512i": a reaction to a command. */
typedef struct {
    uint8_t command; /* its letter */
    int64_t elapsed; /* ns */
} rk512i_answer_t;

/* Decodes the data of a block; false if they do not look like RK512. `data` is a rk512i_block_t, or NULL. */
bool rk512i_dissect(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data);

#endif
