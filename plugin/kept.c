/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is kept while a capture file is open. */
#include "kept.h"

#include <epan/proto_data.h>

wmem_map_t *
kept_map(GHashFunc hash, GEqualFunc are_equal)
{
    return wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), hash, are_equal);
}

wmem_map_t *
kept_map_of_numbers(void)
{
    return kept_map(wmem_int64_hash, g_int64_equal);
}

void *
kept_value(wmem_map_t *map, const void *key, size_t key_size, size_t size)
{
    void *value = wmem_map_lookup(map, key);

    if (value == NULL) {
        value = wmem_alloc0(wmem_file_scope(), size);
        memcpy(value, key, key_size);
        wmem_map_insert(map, value, value);
    }
    return value;
}

void *
kept_of_packet(packet_info *pinfo, int proto, uint32_t number, size_t size)
{
    void *kept = p_get_proto_data(wmem_file_scope(), pinfo, proto, number);

    if (kept == NULL) {
        kept = wmem_alloc0(wmem_file_scope(), size);
        p_add_proto_data(wmem_file_scope(), pinfo, proto, number, kept);
    }
    return kept;
}
