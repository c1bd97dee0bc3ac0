/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Parameters: how they are written, what is known of them, and their elements (chapters 8.1 and IEC 61491).
 */

#ifndef PARAMETERS_PARAMETERS_H
#define PARAMETERS_PARAMETERS_H

#include "compat.h"

#include <epan/prefs.h>

/* Elements of a parameter, bits 3 to 5 of the parameter control (fig. 8-1). */
typedef enum {
    SIS_ELEMENT_CHANNEL,
    SIS_ELEMENT_IDENT,
    SIS_ELEMENT_NAME,
    SIS_ELEMENT_ATTRIBUTE,
    SIS_ELEMENT_UNIT,
    SIS_ELEMENT_MINIMUM,
    SIS_ELEMENT_MAXIMUM,
    SIS_ELEMENT_DATA,
} sis_element_t;

/* Type byte and number word of a parameter (fig. 8-3). */
typedef struct {
    uint8_t type;
    uint16_t number;
} sis_ident_t;

typedef enum { SIS_FROM_NOWHERE, SIS_FROM_BUS, SIS_FROM_TABLE, SIS_BUILT_IN } sis_source_t;

/* What is known of a parameter, each part from the best source. Never changed once made: new knowledge
 * makes a new one. */
typedef struct sis_known {
    const char *name; /* NULL: unknown */
    const char *unit;
    const char *minimum; /* as read on the bus, NULL: unknown */
    const char *maximum;
    uint32_t attribute; /* valid unless attribute_from is SIS_FROM_NOWHERE */
    sis_source_t name_from;
    sis_source_t unit_from;
    sis_source_t attribute_from;
} sis_known_t;

/* "S-0-0044", "P-2-0012", "A-0-0004", "C-0-0066", "type3-0-0066". */
const char *sis_ident_text(wmem_allocator_t *scope, sis_ident_t ident);

/* What the user's table and the built-in one say. */
sis_known_t sis_known_from_tables(sis_ident_t ident);

void sis_parameters_register(module_t *module);

#endif
