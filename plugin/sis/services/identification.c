/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x00, node identification (chapter 3). */

#include "sis/services/services.h"

#define VERSION_LENGTH  5 /* "nnVmm" */
#define MOST_CHARACTERS 40

static int hf_version = -1;
static int hf_firmware = -1;
static int hf_type_key = -1;

static void
take_long_text(sis_body_t *body, int hf)
{
    bool is_too_long = sis_left(body) > MOST_CHARACTERS;

    sis_take_text(body, hf);
    if (is_too_long)
        sis_mark(body, &ei_sis_note, "more than %u characters", MOST_CHARACTERS);
}

static void
dissect_data(sis_body_t *body, uint32_t subservice)
{
    switch (subservice) {
    case 0x01:
        if (sis_left(body) != VERSION_LENGTH && !body->is_cut)
            sis_mark(body, sis_left(body) < VERSION_LENGTH ? &ei_sis_missing : &ei_sis_unexpected,
                     "a SIS version has %u characters", VERSION_LENGTH);
        sis_take_text(body, hf_version);
        break;
    case 0x02:
        take_long_text(body, hf_firmware);
        break;
    case 0x03:
        take_long_text(body, hf_type_key);
        break;
    case 0x04:
        sis_take_baud_mask(body, true);
        break;
    default:
        sis_take_rest(body, hf_sis_raw);
    }
}

void
sis_dissect_identification(sis_body_t *body)
{
    uint32_t subservice;

    if (!sis_take_subservice(body, sis_subservices_identification, &subservice) || !body->is_reaction)
        return;
    if (sis_is_ok(body))
        dissect_data(body, subservice);
    else if (!sis_take_channel_error(body))
        sis_take_rest(body, hf_sis_raw); /* chapter 3 has no error codes */
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_version, {"SIS version", "sis.version", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_firmware, {"Firmware (FWA) number", "sis.firmware", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_type_key, {"Device type key", "sis.type_key", FT_STRING, BASE_NONE, NULL, 0, NULL, HFILL}},
};
/* clang-format on */

void
sis_identification_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
