/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Bytes: of a parameter, and those that are not decoded. */

#ifndef PARAMETERS_FIELDS_H
#define PARAMETERS_FIELDS_H

extern int proto_sis; /* whose fields they are */

extern int hf_sis_data; /* operating data and nothing else */
extern int hf_sis_raw;  /* bytes that are not decoded */

void sis_parameter_fields_register(void);

#endif
