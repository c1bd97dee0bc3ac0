/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Bytes: of a parameter, and those that are not decoded. */

#include "parameters/fields.h"

#include "compat.h"

int proto_sis = -1;
int hf_sis_data = -1;
int hf_sis_raw = -1;

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_sis_data, {"Data", "sis.data", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_sis_raw, {"Not decoded", "sis.raw", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
};
/* clang-format on */

void
sis_parameter_fields_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
