/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x02, flash operation (chapter 5). */
#include "sis/services/services.h"

#include "protocol/limits.h"
#include "protocol/services.h"
#include "sis/export.h"

#define ERASE_FLASH 0x94

#define FIRST_SUPPORTED_TYPE 2 /* of a device: RAM */

static void
take_flash_address(sis_body_t *body, unsigned size)
{
    uint32_t address;

    if (!sis_take(body, hf_sis_flash_address, size, &address))
        return;
    sis_say(body, ", 0x%08x", address);
    if (body->request != NULL) {
        body->request->has_address = true;
        body->request->address = address;
    }
}

static void
check_most(sis_body_t *body, unsigned length, unsigned most)
{
    if (length > most)
        sis_mark(body, &ei_sis_body_note, "more than %u bytes", most);
}

static void
take_flash_length(sis_body_t *body, unsigned size)
{
    uint32_t length;

    if (!sis_take(body, hf_sis_flash_length, size, &length))
        return;
    sis_say_bytes(body, ", ", length);
    if (size == 1) {
        check_most(body, length, SIS_MOST_READ);
        body->request->setting = length;
    }
}

/* Data of the memory; the command has the address. */
static void
take_data(sis_body_t *body, unsigned size _U_)
{
    const sis_request_t *request = sis_request_of(body);
    unsigned offset = body->offset, length = sis_left(body);

    if (!sis_needs(body, hf_sis_data, 1))
        return;
    sis_take_rest(body, hf_sis_data);
    sis_say_bytes(body, ", ", length);
    if (!body->is_reaction)
        check_most(body, length, SIS_MOST_PROGRAMMED);
    else if (request != NULL && length < request->setting && !body->is_cut)
        sis_mark(body, &ei_sis_body_note, "fewer bytes than asked for");
    else if (request != NULL && request->setting > 0 && length > request->setting)
        sis_mark(body, &ei_sis_body_note, "more bytes than asked for");
    if (request != NULL && request->has_address)
        sis_export_memory(body, request->address, offset, length);
}

static void
take_flash_device_type(sis_body_t *body, unsigned size)
{
    uint32_t type;
    const char *text = sis_take_code(body, hf_sis_flash_device_type, size, sis_device_types, &type);

    if (text == NULL)
        return;
    sis_say_words(body, ", ", text, NULL);
    if (try_val_to_str(type, sis_device_types) == NULL)
        sis_mark(body, &ei_sis_body_note, "0x%02x is not defined", type);
    else if (type < FIRST_SUPPORTED_TYPE)
        sis_mark(body, &ei_sis_body_note, "device types 0 and 1 are not supported");
}

static const sis_layouts_t layouts = SIS_LAYOUTS_FLASH;

/* Both numbers 0xFFFFFFFF (fig. 5-15). */
static bool
take_erase_everything(sis_body_t *body)
{
    static const char words[] = "complete erase without loader and kernel";

    if (sis_left(body) < 8 || tvb_get_letoh64(body->tvb, body->offset) != G_MAXUINT64)
        return false;
    sis_take(body, hf_sis_flash_address, 4, NULL);
    proto_item_append_text(body->item, " (%s)", words);
    sis_take(body, hf_sis_flash_length, 4, NULL);
    proto_item_append_text(body->item, " (%s)", words);
    sis_say_words(body, ", all but loader and kernel", NULL);
    return true;
}

void
sis_dissect_flash(sis_body_t *body)
{
    uint32_t subservice;

    if (!sis_take_subservice(body, &subservice))
        return;
    if (body->is_reaction || subservice != ERASE_FLASH || !take_erase_everything(body))
        sis_take_layout_or_error(body, &layouts, subservice);
}
