/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS. Each long parameter is a file. The pieces of memory that Read flash and
 * Program flash carry are joined if one follows or overlaps another. What lies apart is a file of its own, so
 * that gaps stay visible. Programmed memory is what was sent, whether or not the station accepted it. */

#include "sis/export.h"

#include <epan/export_object.h>
#include <epan/tap.h>

#include "sis/memories.h"

typedef struct {
    const char *name; /* of a parameter's file; NULL: a memory */
    sis_piece_t piece;
} object_t;

static int tap = -1;

/* "3", "3-2-8" through routers; with a distinction from the same address on another line. */
static const char *
station_text(const sis_body_t *body)
{
    const sis_exchange_t *exchange = body->record->exchange;
    const uint8_t *path = exchange->path;
    uint32_t interface = compat_interface(body->pinfo), section = compat_section(body->pinfo);
    wmem_strbuf_t *text = wmem_strbuf_new(body->pinfo->pool, "");

    wmem_strbuf_append_printf(text, "%u", path[0]);
    for (unsigned i = 1; i < exchange->path_length; i++)
        wmem_strbuf_append_printf(text, "-%u", path[i]);
    if (interface > 0)
        wmem_strbuf_append_printf(text, " on interface %u", interface);
    if (section > 0)
        wmem_strbuf_append_printf(text, " of section %u", section + 1);
    return wmem_strbuf_get_str(text);
}

/* NULL if nobody collects objects, or the exchange is unknown. */
static object_t *
new_object(const sis_body_t *body, const char *type)
{
    object_t *object;

    if (!have_tap_listener(tap) || body->record == NULL || body->record->exchange == NULL)
        return NULL;
    object = wmem_new0(body->pinfo->pool, object_t);
    object->piece.type = type;
    object->piece.station = station_text(body);
    return object;
}

void
sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data)
{
    wmem_allocator_t *pool = body->pinfo->pool;
    object_t *object = new_object(body, "parameter");

    if (object == NULL)
        return;
    object->name =
        wmem_strdup_printf(pool, "%s of device %u at station %s, packet %u.bin", sis_ident_text(pool, ident),
                           device, object->piece.station, body->pinfo->num);
    object->piece.length = tvb_captured_length(data);
    object->piece.data = tvb_memdup(pool, data, 0, object->piece.length);
    tap_queue_packet(tap, body->pinfo, object);
}

void
sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length)
{
    object_t *object = new_object(body, body->is_reaction ? SIS_MEMORY_READ : SIS_MEMORY_WRITTEN);

    if (object == NULL || length == 0)
        return;
    object->piece.address = address;
    object->piece.length = length;
    object->piece.data = tvb_memdup(body->pinfo->pool, body->tvb, (int)offset, length);
    tap_queue_packet(tap, body->pinfo, object);
}

static export_object_entry_t *
new_entry(const packet_info *pinfo, const object_t *object)
{
    export_object_entry_t *entry = g_new0(export_object_entry_t, 1);

    entry->pkt_num = pinfo->num;
    entry->hostname = g_strdup(object->piece.station);
    entry->content_type = g_strdup(object->piece.type);
    entry->filename = g_strdup(object->name);
    entry->payload_len = object->piece.length;
    entry->payload_data = g_memdup2(object->piece.data, object->piece.length);
    if (object->name == NULL)
        sis_memories_name(entry, object->piece.address);
    return entry;
}

/* Only the list itself is remembered: its user may delete it at any time. */
static tap_packet_status
export_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    export_object_list_t *list = data;
    const object_t *object = tapped;
    export_object_entry_t *entry;

    sis_memories_refresh(list);
    if (object->name == NULL && sis_memories_extend(list, &object->piece))
        return TAP_PACKET_REDRAW;
    entry = new_entry(pinfo, object);
    list->add_entry(list->gui_data, entry);
    if (object->name == NULL)
        sis_memories_add(list, entry);
    return TAP_PACKET_REDRAW;
}

void
sis_export_register(void)
{
    tap = register_tap("sis_eo");
    register_export_object(proto_sis, export_packet, sis_memories_reset);
}
