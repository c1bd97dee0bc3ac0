/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What all transports show of a parameter: its data, its value as a number, and bytes that are not
 * decoded. */

#include "parameters/fields.h"

#include "compat.h"

int proto_sis = -1;
int hf_sis_data = -1;
int hf_sis_raw = -1;
int hf_sis_number = -1;

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_sis_data, {"Data", "sis.data", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_sis_raw, {"Not decoded", "sis.raw", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_sis_number, {"Number", "sis.value.number", FT_DOUBLE, BASE_NONE, NULL, 0, "The value without its unit, for filters, columns and graphs", HFILL}},
};
/* clang-format on */

void
sis_parameter_fields_register(void)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
}
