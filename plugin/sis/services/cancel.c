/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x01, cancel data transmission (chapter 4): address and service may be missing, each or both. */
#include "sis/services/services.h"

#include "sis/names.h"

static void
take_ambiguous(sis_body_t *body)
{
    if (body->request != NULL) {
        body->request->is_ambiguous = true;
        body->request->subservice = compat_get_uint8(body->tvb, body->offset);
    }
    sis_take_rest(body, hf_sis_raw);
    sis_mark(body, &ei_sis_body_note, "device address or service, one byte does not tell");
}

static void
take_device_and_service(sis_body_t *body)
{
    uint32_t device, service;

    if (!sis_take(body, hf_sis_device, 1, &device) || !sis_take(body, hf_sis_canceled_service, 1, &service))
        return;
    sis_request_device(body, device);
    if (body->request != NULL) {
        body->request->has_subservice = true;
        body->request->subservice = (uint8_t)service;
    }
    sis_say(body, ", %s, device %u", sis_service_name(body->pinfo->pool, (uint8_t)service), device);
    if (sis_general_service((uint8_t)service) == 0x1D)
        sis_mark(body, &ei_sis_body_note, "a phase switch cannot be cancelled"); /* chapter 8.5 */
}

static void
dissect_command(sis_body_t *body)
{
    if (sis_left(body) == 0)
        sis_say_words(body, ", all that is under way", NULL);
    else if (sis_left(body) == 1)
        take_ambiguous(body);
    else
        take_device_and_service(body);
}

/* The address is repeated if the command had one. The length of error data is not documented, but they
 * follow an error only. */
static void
dissect_reaction(sis_body_t *body)
{
    bool had_device = body->asked != NULL && body->asked->has_device;
    bool is_open = body->asked == NULL || body->asked->is_ambiguous; /* whether it had */
    bool is_alone = is_open && sis_left(body) == 1 && body->status == 0;
    bool is_before_code = is_open && sis_left(body) == 3 && body->status == 0x02;

    if ((had_device || is_alone || is_before_code) && !sis_take(body, hf_sis_device, 1, NULL))
        return;
    if (body->status == 0x02 && sis_left(body) >= 2)
        sis_take_channel_error(body);
    else if (body->status != 0 && body->status < 0xF0)
        sis_take_rest(body, hf_sis_raw);
}

void
sis_dissect_cancel(sis_body_t *body)
{
    if (body->is_reaction)
        dissect_reaction(body);
    else
        dissect_command(body);
}
