/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x03, initialization of the SIS communication (chapter 6). */
#include "sis/services/services.h"

#include "protocol/services.h"
#include "sis/bus.h"

/* In ms; 0 if it is missing. */
static uint16_t
take_time(sis_body_t *body, int hf)
{
    uint16_t ms;
    nstime_t value;

    if (!sis_needs(body, hf, 2))
        return 0;
    ms = tvb_get_letohs(body->tvb, body->offset);
    value = sertap_time(ms * INT64_C(1000000));
    body->item =
        proto_tree_add_time_format_value(body->tree, hf, body->tvb, body->offset, 2, &value, "%u ms", ms);
    body->offset += 2;
    sis_say(body, hf == hf_sis_init_time ? " = %u ms" : ", %u ms", ms);
    return ms;
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

static void
take_init_time(sis_body_t *body, unsigned size _U_)
{
    body->request->setting = take_time(body, hf_sis_init_time);
}

static void
take_init_test_time(sis_body_t *body, unsigned size _U_)
{
    body->request->test_ms = take_time(body, hf_sis_init_test_time);
}

/* A mask without a rate sets nothing. */
static void
take_init_baud_mask(sis_body_t *body, unsigned size _U_)
{
    body->request->setting = sis_take_baud_mask(body, false);
    if (body->request->setting == 0)
        body->request->has_setting = false;
}

static const sis_layouts_t layouts = SIS_LAYOUTS_INITIALIZATION;

/* The data of a subservice in a command; its request has a setting if they are complete. */
static void
take_setting(sis_body_t *body, uint32_t subservice, sis_request_t *request)
{
    sis_request_t *first = body->request;
    const sis_layout_t *layout = sis_find_layout(&layouts, subservice);

    if (layout == NULL) { /* an undefined subservice has its note already */
        if (sis_take_rest(body, hf_sis_raw) &&
            try_val_to_str(subservice, sis_subservices_initialization) != NULL)
            sis_mark(body, &ei_sis_body_note, "no document says what is in it");
        return;
    }
    body->request = request;
    request->has_setting = true;
    sis_take_layout(body, layout);
    if (body->is_short)
        request->has_setting = false;
    body->request = first;
}

/* The bytes of a subservice's data. A reaction has none. */
static unsigned
size_of_setting(const sis_body_t *body, const sis_layout_t *layout)
{
    unsigned size = 0;

    if (!body->is_reaction) {
        for (const sis_item_t *item = layout->command; item->hf != NULL; item++)
            size += item->size;
    }
    return size;
}

/* Whether the rest is entirely further subservices of fixed length (chapter 6.1), each with the device
 * address before it or without. A reaction has those of its command. */
static bool
is_layout(const sis_body_t *body, uint8_t device, bool has_device)
{
    const sis_request_t *asked = body->asked != NULL ? body->asked->list : NULL;
    unsigned at = body->offset, head = has_device ? 2 : 1;

    while (at + head <= body->end) {
        uint8_t subservice = compat_get_uint8(body->tvb, at + head - 1);
        const sis_layout_t *layout = sis_find_layout(&layouts, subservice);

        if ((has_device && compat_get_uint8(body->tvb, at) != device) || layout == NULL)
            return false;
        if (body->is_reaction && body->asked != NULL && (asked == NULL || asked->subservice != subservice))
            return false;
        asked = asked != NULL ? asked->next : NULL;
        at += head + size_of_setting(body, layout);
    }
    return at == body->end;
}

/* Another subservice of a command is another request. */
static sis_request_t *
add_request(sis_body_t *body, uint8_t device, uint8_t subservice)
{
    sis_request_t *request = sis_request_add(body, body->service);

    request->has_device = true;
    request->device = device;
    request->subservice = subservice;
    return request;
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
        take_setting(body, subservice, add_request(body, device, (uint8_t)subservice));
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
        sis_mark(body, &ei_sis_body_note, "more data: %s",
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

    if (!sis_take_subservice(body, &subservice))
        return;
    say_subservice(body, subservice);
    if (!body->is_reaction)
        take_setting(body, subservice, body->request);
    if (!body->is_reaction || sis_is_ok(body)) {
        take_all_further(body, compat_get_uint8(body->tvb, device_at));
    } else if (!sis_take_channel_error(body)) {
        sis_take_error_byte(body, (uint8_t)subservice, sis_errors_initialization);
    }
    body->learn = sis_bus_learn;
}
