/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Objects to save: long parameters, and pieces of memory. windows/export.c collects them. */
#include "sis/export.h"

#include <epan/tap.h>

#include "parts.h"

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
static sis_object_t *
new_object(const sis_body_t *body, const char *type)
{
    sis_object_t *object;

    if (!have_tap_listener(tap) || !sis_has_exchange(body) || body->telegram->is_before)
        return NULL;
    object = wmem_new0(body->pinfo->pool, sis_object_t);
    object->type = type;
    object->station = station_text(body);
    return object;
}

void
sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data)
{
    wmem_allocator_t *pool = body->pinfo->pool;
    sis_object_t *object = new_object(body, "parameter");
    char *name;

    if (object == NULL)
        return;
    name = wmem_strdup_printf(pool, "station-%s_device-%u_%s_packet-%u.bin", object->station, device,
                              sis_ident_text(pool, ident), body->pinfo->num);
    object->name = g_strdelimit(name, " ", '-'); /* a shell needs no quotes for it */
    object->length = tvb_captured_length(data);
    object->data = tvb_memdup(pool, data, 0, object->length);
    tap_queue_packet(tap, body->pinfo, object);
}

void
sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length)
{
    sis_object_t *object = new_object(body, body->is_reaction ? SIS_MEMORY_READ : SIS_MEMORY_WRITTEN);

    if (object == NULL || length == 0)
        return;
    object->address = address;
    object->length = length;
    object->data = tvb_memdup(body->pinfo->pool, body->tvb, (int)offset, length);
    tap_queue_packet(tap, body->pinfo, object);
}

void
sis_export_register(void)
{
    tap = register_tap("sis_eo"); /* Wireshark's name of the tap of a protocol's objects */
}
