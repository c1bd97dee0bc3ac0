/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Fields of more than one file of the dissector. */

#include "sis/fields.h"

#include <epan/tap.h>

#include "sis/names.h"

int sis_tap = -1;
expert_module_t *sis_experts;

int hf_sis_service = -1;
int hf_sis_status = -1;
int hf_sis_device = -1;
int hf_sis_subservice = -1;
int hf_sis_error = -1;
int hf_sis_baud_mask = -1;
int hf_sis_phase = -1;

expert_field ei_sis_missing = EI_INIT;
expert_field ei_sis_unexpected = EI_INIT;
expert_field ei_sis_note = EI_INIT;
expert_field ei_sis_status = EI_INIT;
expert_field ei_sis_status_telegram = EI_INIT;

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_sis_service, {"Service", "sis.service", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_services), 0, NULL, HFILL}},
    {&hf_sis_status, {"Status", "sis.status", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_status), 0, NULL, HFILL}},
    {&hf_sis_device, {"Device address", "sis.device", FT_UINT8, BASE_DEC, NULL, 0, "Of the device behind the station; its own address, or 0 for the control itself", HFILL}},
    {&hf_sis_subservice, {"Subservice", "sis.subservice", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_sis_error, {"Error code", "sis.error", FT_UINT16, BASE_HEX, NULL, 0, "The full code, where a byte is sent together with its subservice", HFILL}},
    {&hf_sis_phase, {"Phase", "sis.phase", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_sis_baud_mask, {"Baud rate mask", "sis.init.baud_mask", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
};

static ei_register_info experts[] = {
    {&ei_sis_missing, {"sis.body.missing", PI_PROTOCOL, PI_WARN, "Useful data are missing", EXPFILL}},
    {&ei_sis_unexpected, {"sis.body.unexpected", PI_PROTOCOL, PI_WARN, "More useful data than the service has", EXPFILL}},
    {&ei_sis_note, {"sis.body.note", PI_PROTOCOL, PI_NOTE, "Useful data that the documents do not define", EXPFILL}},
    {&ei_sis_status, {"sis.status.execution_error", PI_RESPONSE_CODE, PI_NOTE, "The status is an execution error", EXPFILL}},
    {&ei_sis_status_telegram, {"sis.status.telegram_error", PI_RESPONSE_CODE, PI_WARN, "The status is a telegram error", EXPFILL}},
};
/* clang-format on */

void
sis_fields_register(void)
{
    proto_sis = proto_register_protocol("Rexroth SIS serial protocol", "SIS", "sis");
    sis_experts = expert_register_protocol(proto_sis);
    proto_register_field_array(proto_sis, fields, array_length(fields));
    expert_register_field_array(sis_experts, experts, array_length(experts));
    sis_tap = register_tap("sis");
}
