/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x02, flash operation (chapter 5). */

#include "sis/services/services.h"

#include "sis/export.h"

#define READ_FLASH     0x92
#define FIND_HEADER    0x93
#define BUILD_CHECKSUM 0x97

/* The memory that a telegram can carry (chapters 5.4 and 5.7). */
#define MOST_READ       244u
#define MOST_PROGRAMMED 240u

static int hf_address = -1;
static int hf_length = -1;
static int hf_target = -1;
static int hf_device_type = -1;
static int hf_crc = -1;

typedef enum { NOTHING, TARGET, ADDRESS, LENGTH_BYTE, LENGTH, DEVICE_TYPE, DATA } part_t;

/* The fields after the subservice in a command. */
static const struct {
    uint8_t subservice;
    part_t parts[4];
} commands[] = {
    {0x90, {TARGET, ADDRESS}}, {0x91, {ADDRESS}},         {0x92, {ADDRESS, LENGTH_BYTE}},
    {0x93, {NOTHING}},         {0x94, {ADDRESS, LENGTH}}, {0x96, {ADDRESS, DEVICE_TYPE, DATA}},
    {0x97, {ADDRESS, LENGTH}}, {0x9F, {NOTHING}},
};

static void
take_address(sis_body_t *body)
{
    uint32_t address;

    if (!sis_take(body, hf_address, 4, &address))
        return;
    sis_say(body, ", 0x%08x", address);
    if (body->request != NULL) {
        body->request->has_address = true;
        body->request->address = address;
    }
}

static void
say_length(sis_body_t *body, unsigned length)
{
    sis_say_words(body, ", ", NULL);
    sis_say_bytes(body, length);
}

static void
check_most(sis_body_t *body, unsigned length, unsigned most)
{
    if (length > most)
        sis_mark(body, &ei_sis_note, "more than %u bytes", most);
}

static void
take_length(sis_body_t *body, unsigned size)
{
    uint32_t length;

    if (!sis_take(body, hf_length, size, &length))
        return;
    say_length(body, length);
    if (size == 1) {
        check_most(body, length, MOST_READ);
        body->request->setting = length;
    }
}

static void
take_code(sis_body_t *body, int hf, const value_string *texts)
{
    uint32_t value;
    const char *text = sis_take_code(body, hf, 1, texts, &value);

    if (text == NULL)
        return;
    sis_say_words(body, ", ", text, NULL);
    if (try_val_to_str(value, texts) == NULL)
        sis_mark(body, &ei_sis_note, "0x%02x is not defined", value);
}

/* Data of the memory; the command has the address. */
static void
take_data(sis_body_t *body, const sis_request_t *request)
{
    unsigned offset = body->offset, length = sis_left(body);

    if (!sis_needs(body, hf_sis_data, 1))
        return;
    sis_take_rest(body, hf_sis_data);
    say_length(body, length);
    if (!body->is_reaction)
        check_most(body, length, MOST_PROGRAMMED);
    else if (request != NULL && length < request->setting && !body->is_cut)
        sis_mark(body, &ei_sis_note, "%u byte%s asked for, %u sent", request->setting,
                 plurality(request->setting, "", "s"), length);
    if (request != NULL && request->has_address)
        sis_export_memory(body, request->address, offset, length);
}

static void
take_part(sis_body_t *body, part_t part)
{
    switch (part) {
    case TARGET:
        take_code(body, hf_target, sis_shutdown_targets);
        break;
    case ADDRESS:
        take_address(body);
        break;
    case LENGTH_BYTE:
        take_length(body, 1);
        break;
    case LENGTH:
        take_length(body, 4);
        break;
    case DEVICE_TYPE:
        take_code(body, hf_device_type, sis_device_types);
        break;
    case DATA:
        take_data(body, body->request);
        break;
    case NOTHING:
        break;
    }
}

/* Both numbers 0xFFFFFFFF: everything but loader and kernel. */
static bool
take_erase_everything(sis_body_t *body)
{
    if (sis_left(body) < 8 || tvb_get_letoh64(body->tvb, body->offset) != G_MAXUINT64)
        return false;
    sis_take(body, hf_address, 4, NULL);
    sis_take(body, hf_length, 4, NULL);
    sis_say_words(body, ", all but loader and kernel", NULL);
    return true;
}

static void
dissect_command(sis_body_t *body, uint32_t subservice)
{
    if (subservice == 0x94 && take_erase_everything(body))
        return;
    for (unsigned i = 0; i < array_length(commands); i++) {
        if (commands[i].subservice != subservice)
            continue;
        for (unsigned j = 0; j < array_length(commands[i].parts); j++)
            take_part(body, commands[i].parts[j]);
        return;
    }
    sis_take_rest(body, hf_sis_raw);
}

static void
dissect_data(sis_body_t *body, uint32_t subservice)
{
    uint32_t crc;

    if (subservice == READ_FLASH) {
        take_data(body, body->asked);
    } else if (subservice == FIND_HEADER) {
        take_address(body);
    } else if (subservice == BUILD_CHECKSUM && sis_left(body) >= 4) { /* IndraDrive; IF02 has no data here */
        sis_take(body, hf_crc, 4, &crc);
        sis_say(body, ", 0x%08x", crc);
    } else if (try_val_to_str(subservice, sis_subservices_flash) == NULL) {
        sis_take_rest(body, hf_sis_raw);
    }
}

void
sis_dissect_flash(sis_body_t *body)
{
    uint32_t subservice;

    if (!sis_take_subservice(body, sis_subservices_flash, &subservice))
        return;
    if (!body->is_reaction)
        dissect_command(body, subservice);
    else if (sis_is_ok(body))
        dissect_data(body, subservice);
    else if (!sis_take_channel_error(body))
        sis_take_error_byte(body, (uint8_t)subservice, sis_errors_flash);
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_address, {"Memory address", "sis.flash.address", FT_UINT32, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_length, {"Length", "sis.flash.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&units_byte_bytes), 0, NULL, HFILL}},
    {&hf_target, {"Target", "sis.flash.target", FT_UINT8, BASE_HEX, VALS(sis_shutdown_targets), 0, NULL, HFILL}},
    {&hf_device_type, {"Device type", "sis.flash.device_type", FT_UINT8, BASE_HEX, VALS(sis_device_types), 0, NULL, HFILL}},
    {&hf_crc, {"CRC32", "sis.flash.crc32", FT_UINT32, BASE_HEX, NULL, 0, NULL, HFILL}},
};
/* clang-format on */

void
sis_flash_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
