/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A way: from one station to another, on a line of the capture. */

#ifndef SYNAX_WAYS_H
#define SYNAX_WAYS_H

#include "compat.h"

/* The key of what is kept of a way, and its first member. */
typedef struct {
    uint64_t line;
    address from, to;
    unsigned kind; /* of what is sent, if a dissector tells several */
} synax_way_t;

/* What is kept, by way; empty for every file. */
wmem_map_t *synax_new_ways(void);

/* What is kept of a way: `size` bytes, all 0 the first time but for the key. */
void *synax_find_way(wmem_map_t *ways, const packet_info *pinfo, const address *from, const address *to,
                     unsigned kind, size_t size);

#endif
