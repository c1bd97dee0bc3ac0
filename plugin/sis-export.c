/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS. Long parameters are a file each. Memory that Read flash and Program flash
 * carry piece by piece is put together where a piece follows another or lies in it; what lies apart is a file
 * of its own, so that holes are seen. Programmed memory is what was sent, whether the station took it or not.
 */

#include "sis-export.h"

#include <epan/export_object.h>
#include <epan/tap.h>

#include "sis-exchange.h"

typedef struct {
    const char *station; /* "3", "3-2-8" through routers */
    const char *type;    /* "parameter", "read" or "written" memory */
    const char *name;    /* of a parameter's file */
    uint32_t address;
    const uint8_t *data;
    unsigned length;
} object_t;

static int tap = -1;

static const char *
station_text(const sis_body_t *body)
{
    const sis_exchange_t *exchange = body->record->exchange;
    const uint8_t *path = exchange->path;
    uint32_t interface = compat_interface(body->pinfo);
    wmem_strbuf_t *text = wmem_strbuf_new(body->pinfo->pool, "");

    wmem_strbuf_append_printf(text, "%u", path[0]);
    for (unsigned i = 1; i < exchange->path_length; i++)
        wmem_strbuf_append_printf(text, "-%u", path[i]);
    if (interface > 0)
        wmem_strbuf_append_printf(text, " on interface %u", interface);
    return wmem_strbuf_get_str(text);
}

/* NULL where nobody collects objects, or the exchange is not known. */
static object_t *
new_object(const sis_body_t *body, const char *type)
{
    object_t *object;

    if (!have_tap_listener(tap) || body->record == NULL || body->record->exchange == NULL)
        return NULL;
    object = wmem_new0(body->pinfo->pool, object_t);
    object->type = type;
    object->station = station_text(body);
    return object;
}

void
sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data)
{
    wmem_allocator_t *pool = body->pinfo->pool;
    object_t *object = new_object(body, "parameter");

    if (object == NULL)
        return;
    object->name = wmem_strdup_printf(pool, "%s of device %u at station %s, packet %u.bin",
                                      sis_ident_text(pool, ident), device, object->station, body->pinfo->num);
    object->length = tvb_captured_length(data);
    object->data = tvb_memdup(pool, data, 0, object->length);
    tap_queue_packet(tap, body->pinfo, object);
}

void
sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length)
{
    object_t *object = new_object(body, body->is_reaction ? "read" : "written");

    if (object == NULL || length == 0)
        return;
    object->address = address;
    object->length = length;
    object->data = tvb_memdup(body->pinfo->pool, body->tvb, (int)offset, length);
    tap_queue_packet(tap, body->pinfo, object);
}

static void
name_memory(export_object_entry_t *entry, uint64_t begin)
{
    g_free(entry->filename);
    entry->filename = g_strdup_printf("0x%08" PRIx64 " to 0x%08" PRIx64 ", memory %s, station %s.bin", begin,
                                      begin + entry->payload_len - 1, entry->content_type, entry->hostname);
}

static export_object_entry_t *
new_entry(const packet_info *pinfo, const object_t *object)
{
    export_object_entry_t *entry = g_new0(export_object_entry_t, 1);

    entry->pkt_num = pinfo->num;
    entry->hostname = g_strdup(object->station);
    entry->content_type = g_strdup(object->type);
    entry->filename = g_strdup(object->name);
    entry->payload_len = object->length;
    entry->payload_data = g_memdup2(object->data, object->length);
    if (object->name == NULL)
        name_memory(entry, object->address);
    return entry;
}

/* Puts a piece that begins inside an entry, or directly behind it, into it; what is there twice, the later
 * one wins. */
static bool
extend_entry(export_object_entry_t *entry, const object_t *object)
{
    uint64_t begin, at;

    if (strcmp(entry->content_type, object->type) != 0 || strcmp(entry->hostname, object->station) != 0)
        return false;
    begin = g_ascii_strtoull(entry->filename, NULL, 16);
    at = object->address - begin;
    if (object->address < begin || at > entry->payload_len)
        return false;
    if (at + object->length > entry->payload_len) {
        entry->payload_len = (size_t)at + object->length;
        entry->payload_data = g_realloc(entry->payload_data, entry->payload_len);
        name_memory(entry, begin);
    }
    memcpy(entry->payload_data + at, object->data, object->length);
    return true;
}

/* The list itself is all that is remembered: whoever shows it may throw it away at any time. */
static tap_packet_status
export_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    export_object_list_t *list = data;
    const object_t *object = tapped;
    export_object_entry_t *entry;

    for (int row = 0; object->name == NULL && (entry = list->get_entry(list->gui_data, row)) != NULL; row++) {
        if (extend_entry(entry, object))
            return TAP_PACKET_REDRAW;
    }
    list->add_entry(list->gui_data, new_entry(pinfo, object));
    return TAP_PACKET_REDRAW;
}

void
sis_export_register(void)
{
    tap = register_tap("sis_eo");
    register_export_object(proto_sis, export_packet, NULL);
}
