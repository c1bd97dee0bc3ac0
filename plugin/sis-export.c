/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS. Long parameters are a file each. Memory that Program flash and Read flash
 * carry piece by piece is put together by address: a file for each run without a hole, which says its first
 * and last address. */

#include "sis-export.h"

#include <epan/export_object.h>
#include <epan/tap.h>

#include "sis-exchange.h"

typedef struct {
    uint8_t station;
    const char *name; /* of a parameter's file; NULL: memory */
    const char *hostname;
    uint32_t address;
    const uint8_t *data;
    unsigned length;
} object_t;

/* A run of memory that is in the list already; it grows there. */
typedef struct {
    uint8_t station;
    uint64_t begin;
    uint64_t end;
    export_object_entry_t *entry;
} run_t;

static int tap = -1;

/* Of the list that is being made: Wireshark makes one at a time, and says when it forgets it. */
static GArray *runs;

static void
send_object(const sis_body_t *body, object_t *object)
{
    const sis_exchange_t *exchange = body->record != NULL ? body->record->exchange : NULL;

    if (exchange == NULL)
        return;
    object->station = exchange->station;
    object->hostname = wmem_strdup_printf(body->pinfo->pool, "station %u", exchange->station);
    tap_queue_packet(tap, body->pinfo, object);
}

void
sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data)
{
    wmem_allocator_t *pool = body->pinfo->pool;
    object_t *object;

    if (!have_tap_listener(tap))
        return;
    object = wmem_new0(pool, object_t);
    object->name = wmem_strdup_printf(pool, "%s of device %u, packet %u.bin", sis_ident_text(pool, ident),
                                      device, body->pinfo->num);
    object->length = tvb_captured_length(data);
    object->data = tvb_memdup(pool, data, 0, object->length);
    send_object(body, object);
}

void
sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length)
{
    object_t *object;

    if (!have_tap_listener(tap) || length == 0)
        return;
    object = wmem_new0(body->pinfo->pool, object_t);
    object->address = address;
    object->length = length;
    object->data = tvb_memdup(body->pinfo->pool, body->tvb, (int)offset, length);
    send_object(body, object);
}

static void
name_run(run_t *run)
{
    g_free(run->entry->filename);
    run->entry->filename = g_strdup_printf("memory of station %u, 0x%08x to 0x%08x.bin", run->station,
                                           (unsigned)run->begin, (unsigned)(run->end - 1));
}

static export_object_entry_t *
new_entry(const packet_info *pinfo, const object_t *object, const char *type)
{
    export_object_entry_t *entry = g_new0(export_object_entry_t, 1);

    entry->pkt_num = pinfo->num;
    entry->hostname = g_strdup(object->hostname);
    entry->content_type = g_strdup(type);
    entry->filename = g_strdup(object->name);
    entry->payload_len = object->length;
    entry->payload_data = g_memdup2(object->data, object->length);
    return entry;
}

/* A piece that begins inside a run or directly behind it: what is there twice, the later one wins. */
static bool
extend_run(run_t *run, const object_t *object)
{
    uint64_t begin = object->address, end = begin + object->length;

    if (run->station != object->station || begin < run->begin || begin > run->end)
        return false;
    if (end > run->end) {
        run->end = end;
        run->entry->payload_len = (size_t)(end - run->begin);
        run->entry->payload_data = g_realloc(run->entry->payload_data, run->entry->payload_len);
    }
    memcpy(run->entry->payload_data + (begin - run->begin), object->data, object->length);
    name_run(run);
    return true;
}

static void
add_memory(export_object_list_t *list, const packet_info *pinfo, const object_t *object)
{
    run_t run = {object->station, object->address, (uint64_t)object->address + object->length, NULL};

    if (runs == NULL)
        runs = g_array_new(FALSE, FALSE, sizeof(run_t));
    for (unsigned i = runs->len; i > 0; i--) { /* memory is mostly written upwards: the latest run first */
        if (extend_run(&g_array_index(runs, run_t, i - 1), object))
            return;
    }
    run.entry = new_entry(pinfo, object, "memory");
    name_run(&run);
    g_array_append_val(runs, run);
    list->add_entry(list->gui_data, run.entry);
}

static tap_packet_status
export_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    export_object_list_t *list = data;
    const object_t *object = tapped;

    if (object->name == NULL)
        add_memory(list, pinfo, object);
    else
        list->add_entry(list->gui_data, new_entry(pinfo, object, "parameter"));
    return TAP_PACKET_REDRAW;
}

static void
forget_runs(void)
{
    if (runs != NULL)
        g_array_free(runs, TRUE);
    runs = NULL;
}

void
sis_export_register(void)
{
    tap = register_tap("sis_eo");
    register_export_object(proto_sis, export_packet, forget_runs);
}
