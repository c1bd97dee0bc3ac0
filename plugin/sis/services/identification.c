/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x00, node identification (chapter 3). */
#include "sis/services/services.h"

#include "protocol/limits.h"
#include "protocol/services.h"
#include "sis/station.h"
#include "sis/told.h"

#define VERSION_LENGTH 5 /* "nnVmm" */

static void
take_identity(sis_body_t *body, int hf)
{
    bool is_too_long = sis_left(body) > SIS_MOST_CHARACTERS;

    sis_take_text(body, hf);
    sis_tell_text(body->pinfo, hf, body->text);
    if (is_too_long)
        sis_mark(body, &ei_sis_body_note, "more than %u characters", SIS_MOST_CHARACTERS);
}

static void
learn_firmware(sis_body_t *body)
{
    sis_station_identify(body, SIS_FIRMWARE);
}

static void
take_firmware(sis_body_t *body, unsigned size _U_)
{
    take_identity(body, hf_sis_firmware);
    body->learn = learn_firmware;
}

static void
learn_type_key(sis_body_t *body)
{
    sis_station_identify(body, SIS_TYPE_KEY);
}

static void
take_type_key(sis_body_t *body, unsigned size _U_)
{
    take_identity(body, hf_sis_type_key);
    body->learn = learn_type_key;
}

/* Two digits, V, two digits. */
static void
check_version(sis_body_t *body)
{
    bool is_good = true;

    if (sis_left(body) != VERSION_LENGTH) {
        if (!body->is_cut)
            sis_mark(body, sis_left(body) < VERSION_LENGTH ? &ei_sis_body_missing : &ei_sis_body_unexpected,
                     "a SIS version has %u characters", VERSION_LENGTH);
        return;
    }
    for (unsigned i = 0; i < VERSION_LENGTH; i++) {
        char c = (char)compat_get_uint8(body->tvb, body->offset + i);

        is_good &= i == 2 ? c == 'V' : g_ascii_isdigit(c);
    }
    if (!is_good)
        sis_mark(body, &ei_sis_body_note, "a SIS version has the form nnVmm");
}

static void
take_version(sis_body_t *body, unsigned size _U_)
{
    check_version(body);
    sis_take_text(body, hf_sis_version);
}

static void
take_init_baud_mask(sis_body_t *body, unsigned size _U_)
{
    sis_take_baud_mask(body, true);
}

static const sis_layouts_t layouts = SIS_LAYOUTS_IDENTIFICATION;

void
sis_dissect_identification(sis_body_t *body)
{
    uint32_t subservice;

    if (sis_take_subservice(body, &subservice) && body->is_reaction)
        sis_take_layout_or_error(body, &layouts, subservice);
}
