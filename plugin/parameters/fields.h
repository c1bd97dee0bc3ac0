/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What every road shows of a parameter: its data, its value as a number, and what is not decoded. */

#ifndef PARAMETERS_FIELDS_H
#define PARAMETERS_FIELDS_H

extern int proto_sis; /* whose fields they are */

extern int hf_sis_data;   /* operating data and nothing else */
extern int hf_sis_raw;    /* bytes that are not decoded */
extern int hf_sis_number; /* a value, where it is a number */

void sis_parameter_fields_register(void);

#endif
