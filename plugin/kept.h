/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is kept while a capture file is open: values by key, and what was found out about a packet. */

#ifndef SIS_KEPT_H
#define SIS_KEPT_H

#include "compat.h"

/* Defines hash_TYPE() and are_equal_TYPE() for keys that are compared byte by byte: so they have no gaps, and
 * `size` is the sum of their members. */
#define KEPT_KEY(type, size)                                                                                 \
    _Static_assert(sizeof(type) == (size), "the key is hashed byte by byte, so it has no gaps");             \
    static unsigned hash_##type(const void *key)                                                             \
    {                                                                                                        \
        return wmem_strong_hash(key, sizeof(type));                                                          \
    }                                                                                                        \
    static gboolean are_equal_##type(const void *a, const void *b)                                           \
    {                                                                                                        \
        return memcmp(a, b, sizeof(type)) == 0;                                                              \
    }

/* A map that is empty for every file; with 64-bit numbers as keys. */
wmem_map_t *kept_map(GHashFunc hash, GEqualFunc are_equal);
wmem_map_t *kept_map_of_numbers(void);

/* The value of a key in such a map: `size` bytes that begin with the key. The first time, all others are 0.
 */
void *kept_value(wmem_map_t *map, const void *key, size_t key_size, size_t size);

/* What a protocol keeps of a packet under a number: `size` bytes. The first time, all are 0. */
void *kept_of_packet(packet_info *pinfo, int proto, uint32_t number, size_t size);

#endif
