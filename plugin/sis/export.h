/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS: objects too long for the packet list. */

#ifndef SIS_EXPORT_H
#define SIS_EXPORT_H

#include "sis/body.h"

/* Data of a parameter reassembled from pieces. */
void sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data);

/* Memory of a device, read or programmed: `length` bytes of the telegram. */
void sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length);

#endif
