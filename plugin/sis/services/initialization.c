/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x03, initialization of the SIS communication (chapter 6). */

#include "sis/services/services.h"

#include "sis/bus.h"

static int hf_time = -1;
static int hf_test_time = -1;

static bool
take_time(sis_body_t *body, int hf, uint32_t *ms)
{
    nstime_t value;

    if (!sis_needs(body, hf, 2))
        return false;
    *ms = tvb_get_letohs(body->tvb, body->offset);
    value = sertap_time(*ms * INT64_C(1000000));
    body->item =
        proto_tree_add_time_format_value(body->tree, hf, body->tvb, body->offset, 2, &value, "%u ms", *ms);
    body->offset += 2;
    sis_say(body, ", %u ms", *ms);
    return true;
}

/* The data of a subservice; what it asks for where all of it is there. */
static bool
take_setting(sis_body_t *body, uint32_t subservice, sis_request_t *request)
{
    uint32_t test_ms;

    switch (subservice) {
    case SIS_SET_TRS:
    case SIS_SET_TZA:
    case SIS_SET_TMAS:
        return take_time(body, hf_time, &request->setting);
    case SIS_TEST_BAUD:
        if (!take_time(body, hf_test_time, &test_ms))
            return false;
        request->test_ms = (uint16_t)test_ms;
        /* FALLTHROUGH */
    case SIS_SET_BAUD_RATE:
        request->setting = sis_take_baud_mask(body, false);
        return request->setting != 0;
    case SIS_ACCEPT:
        return true;
    default: /* of a group nobody says more; a subservice that is not defined has its note already */
        if (sis_take_rest(body, hf_sis_raw) &&
            try_val_to_str(subservice, sis_subservices_initialization) != NULL)
            sis_mark(body, &ei_sis_note, "no document says what is in it");
        return false;
    }
}

static void
dissect_command(sis_body_t *body, uint32_t subservice)
{
    body->request->has_setting = take_setting(body, subservice, body->request);
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
    sis_bus_learn(body);
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_time, {"Time", "sis.init.time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_test_time, {"Duration of the test", "sis.init.test_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
};
/* clang-format on */

void
sis_initialization_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
