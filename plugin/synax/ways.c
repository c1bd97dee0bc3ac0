/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Remembers something for each way: from one station to another, on a line of the capture. */
#include "synax/ways.h"

#include "kept.h"
#include "sertap/line.h"

static unsigned
hash_way(const void *key)
{
    const synax_way_t *way = key;
    unsigned hash = wmem_strong_hash((const uint8_t *)&way->line, sizeof way->line);

    return add_address_to_hash(add_address_to_hash(hash, &way->from), &way->to) + way->kind;
}

static gboolean
are_ways_equal(const void *a, const void *b)
{
    const synax_way_t *one = a, *other = b;

    return one->line == other->line && one->kind == other->kind &&
           addresses_equal(&one->from, &other->from) && addresses_equal(&one->to, &other->to);
}

wmem_map_t *
synax_new_ways(void)
{
    return kept_map(hash_way, are_ways_equal);
}

void *
synax_find_way(wmem_map_t *ways, const packet_info *pinfo, const address *from, const address *to,
               unsigned kind, size_t size)
{
    synax_way_t key = {.line = sertap_line_key(pinfo), .from = *from, .to = *to, .kind = kind};
    synax_way_t *way = wmem_map_lookup(ways, &key);

    if (way == NULL) {
        way = wmem_alloc0(wmem_file_scope(), size);
        *way = key;
        copy_address_wmem(wmem_file_scope(), &way->from, from);
        copy_address_wmem(wmem_file_scope(), &way->to, to);
        wmem_map_insert(ways, way, way);
    }
    return way;
}
