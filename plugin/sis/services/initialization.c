/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x03, initialization of the SIS communication (chapter 6). */

#include "sis/services/services.h"

#include "sis/bus.h"

#define UNKNOWN_SIZE 255u

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
    sis_say(body, hf == hf_time ? " = %u ms" : ", %u ms", *ms);
    return true;
}

/* "Set TzA" of "Set TzA (character interval)". */
static const char *
short_text(const sis_body_t *body, const char *text)
{
    return wmem_strndup(body->pinfo->pool, text, strcspn(text, "(") - (strchr(text, '(') != NULL));
}

/* The subservice alone: it says all, and the service's name is long. */
static void
say_subservice(sis_body_t *body, uint32_t subservice)
{
    const char *text = try_val_to_str(subservice, sis_subservices_initialization);

    if (text == NULL)
        return;
    wmem_strbuf_truncate(body->summary, 0);
    sis_say_words(body, short_text(body, text), NULL);
}

/* The data of a subservice; its request if the data are complete. */
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
    default: /* the data of a group are not documented; an undefined subservice has its note already */
        if (sis_take_rest(body, hf_sis_raw) &&
            try_val_to_str(subservice, sis_subservices_initialization) != NULL)
            sis_mark(body, &ei_sis_note, "no document says what is in it");
        return false;
    }
}

/* The length of a subservice's data: it is fixed, so several may follow one another (chapter 6.1). A
 * reaction has none. */
static unsigned
size_of_setting(const sis_body_t *body, uint8_t subservice)
{
    static const struct {
        uint8_t subservice, size;
    } sizes[] = {{SIS_SET_TRS, 2},       {SIS_SET_TZA, 2},   {SIS_SET_TMAS, 2},
                 {SIS_SET_BAUD_RATE, 1}, {SIS_TEST_BAUD, 3}, {SIS_ACCEPT, 0}};

    for (unsigned i = 0; i < array_length(sizes); i++) {
        if (sizes[i].subservice == subservice)
            return body->is_reaction ? 0 : sizes[i].size;
    }
    return UNKNOWN_SIZE;
}

/* Whether the rest is entirely further subservices, each with the device address before it or without. A
 * reaction has those of its command. */
static bool
is_layout(const sis_body_t *body, uint8_t device, bool has_device)
{
    const sis_request_t *asked = body->asked != NULL ? body->asked->list : NULL;
    unsigned at = body->offset, head = has_device ? 2 : 1;

    while (at + head <= body->end) {
        uint8_t subservice = compat_get_uint8(body->tvb, at + head - 1);
        unsigned size = size_of_setting(body, subservice);

        if ((has_device && compat_get_uint8(body->tvb, at) != device) || size == UNKNOWN_SIZE)
            return false;
        if (body->is_reaction && body->asked != NULL && (asked == NULL || asked->subservice != subservice))
            return false;
        asked = asked != NULL ? asked->next : NULL;
        at += head + size;
    }
    return at == body->end;
}

/* Another subservice of a command is another request. */
static sis_request_t *
add_request(sis_body_t *body, uint8_t device, uint8_t subservice)
{
    sis_request_t **end = &body->request->list;

    while (*end != NULL)
        end = &(*end)->next;
    *end = wmem_new0(body->pinfo->pool, sis_request_t);
    (*end)->service = body->service;
    (*end)->has_device = true;
    (*end)->device = device;
    (*end)->subservice = subservice;
    return *end;
}

static void
take_further(sis_body_t *body, uint8_t device, bool has_device)
{
    uint32_t subservice;
    const char *text;

    if (has_device)
        sis_take(body, hf_sis_device, 1, NULL);
    text = sis_take_code(body, hf_sis_subservice, 1, sis_subservices_initialization, &subservice);
    sis_say_words(body, "; ", short_text(body, text), NULL);
    if (body->request != NULL) {
        sis_request_t *request = add_request(body, device, (uint8_t)subservice);

        request->has_setting = take_setting(body, subservice, request);
    }
}

/* The documents do not say whether the device address comes once or before each subservice: the layout
 * that fits all bytes counts. */
static void
take_all_further(sis_body_t *body, uint8_t device)
{
    bool is_once = is_layout(body, device, false), is_each = is_layout(body, device, true);

    if (sis_left(body) == 0 || body->is_short || body->is_cut)
        return;
    if (is_once == is_each) {
        sis_take_rest(body, hf_sis_raw);
        sis_mark(body, &ei_sis_note, "more data: %s",
                 is_once ? "further subservices, but which is not certain"
                         : "no further subservices fit them");
        return;
    }
    while (sis_left(body) > 0)
        take_further(body, device, is_each);
}

void
sis_dissect_initialization(sis_body_t *body)
{
    unsigned device_at = body->offset;
    uint32_t subservice;

    if (!sis_take_subservice(body, sis_subservices_initialization, &subservice))
        return;
    say_subservice(body, subservice);
    if (!body->is_reaction)
        body->request->has_setting = take_setting(body, subservice, body->request);
    if (!body->is_reaction || sis_is_ok(body)) {
        take_all_further(body, compat_get_uint8(body->tvb, device_at));
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
