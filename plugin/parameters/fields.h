/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What all transports show of a parameter: its data, its value as a number, and bytes that are not
 * decoded. */

#ifndef PARAMETERS_FIELDS_H
#define PARAMETERS_FIELDS_H

extern int proto_sis; /* the owner of these fields */

extern int hf_sis_data;   /* operating data only */
extern int hf_sis_raw;    /* bytes that are not decoded */
extern int hf_sis_number; /* a value, where it is a number */

void sis_parameter_fields_register(void);

#endif
