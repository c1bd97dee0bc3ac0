/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS: objects too long for the packet list. */

#ifndef SIS_EXPORT_H
#define SIS_EXPORT_H

#include "sis/body.h"

/* What a piece of memory is; else it is a parameter. */
#define SIS_MEMORY_READ    "read"
#define SIS_MEMORY_WRITTEN "written"

/* Received by the tap "sis_eo". */
typedef struct {
    const char *name; /* of a parameter's file; NULL: a piece of memory */
    const char *type;
    const char *station;
    uint32_t address;
    const uint8_t *data;
    unsigned length;
} sis_object_t;

/* Data of a parameter reassembled from pieces. */
void sis_export_parameter(const sis_body_t *body, sis_ident_t ident, uint8_t device, tvbuff_t *data);

/* Memory of a device, read or programmed: `length` bytes of the telegram. */
void sis_export_memory(const sis_body_t *body, uint32_t address, unsigned offset, unsigned length);

#endif
