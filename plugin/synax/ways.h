/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Remembers something for each way: from one station to another, on a line of the capture. */

#ifndef SYNAX_WAYS_H
#define SYNAX_WAYS_H

#include "compat.h"

/* The first member of what a dissector remembers, and its key. */
typedef struct {
    uint64_t line;
    address from, to;
    unsigned kind; /* of what is sent, if a dissector tells several */
} synax_way_t;

/* A new memory, by way; empty for every file. */
wmem_map_t *synax_new_ways(void);

/* What is remembered for a way: `size` bytes. The first time, all of them are 0 but the key. */
void *synax_find_way(wmem_map_t *ways, const packet_info *pinfo, const address *from, const address *to,
                     unsigned kind, size_t size);

#endif
