/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x03, initialization of the SIS communication (chapter 6). */

#include "sis-body.h"

#define SET_TRS       0x01
#define SET_TZA       0x02
#define SET_TMAS      0x03
#define SET_BAUD_RATE 0x07
#define TEST_BAUD     0x08

static int hf_time = -1;
static int hf_test_time = -1;

static void
take_time(sis_body_t *body, int hf)
{
    uint32_t ms;

    if (!sis_take(body, hf, 2, &ms))
        return;
    proto_item_append_text(body->item, " ms");
    sis_say(body, ", %u ms", ms);
}

static void
dissect_command(sis_body_t *body, uint32_t subservice)
{
    switch (subservice) {
    case SET_TRS:
    case SET_TZA:
    case SET_TMAS:
        take_time(body, hf_time);
        break;
    case TEST_BAUD:
        take_time(body, hf_test_time);
        sis_take_baud_mask(body, false);
        break;
    case SET_BAUD_RATE:
        sis_take_baud_mask(body, false);
        break;
    case 0xFF:
        break;
    default:
        sis_take_rest(body, hf_sis_raw);
        return;
    }
    if (sis_take_rest(body, hf_sis_raw))
        sis_mark(body, &ei_sis_note, "more data: further subservices? their layout is not defined");
}

void
sis_dissect_initialization(sis_body_t *body)
{
    uint32_t subservice;

    if (!sis_take_subservice(body, sis_subservices_initialization, &subservice))
        return;
    if (!body->is_reaction) {
        dissect_command(body, subservice);
    } else if (sis_is_ok(body)) {
        if (sis_take_rest(body, hf_sis_raw))
            sis_mark(body, &ei_sis_note, "more data: further subservices? their layout is not defined");
    } else if (!sis_take_channel_error(body)) {
        sis_take_error_byte(body, (uint8_t)subservice, sis_errors_initialization);
    }
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_time, {"Time", "sis.timing.ms", FT_UINT16, BASE_DEC, NULL, 0, "In ms", HFILL}},
    {&hf_test_time, {"Duration of the test", "sis.test_ms", FT_UINT16, BASE_DEC, NULL, 0, "In ms", HFILL}},
};
/* clang-format on */

void
sis_initialization_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
