/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Parameters: how they are written, what is known of them, and their elements (chapters 8.1 and IEC 61491).
 */

#ifndef PARAMETERS_PARAMETERS_H
#define PARAMETERS_PARAMETERS_H

#include "compat.h"

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

/* Type byte and number word of a parameter (fig. 8-3). An ident of four bytes, which only values have, also
 * has a structure: its instance in the high byte, its element in the low one. */
typedef struct {
    uint8_t type;
    uint16_t number;
    uint16_t structure;
} sis_ident_t;

/* A device behind a station, perhaps through routers. */
typedef struct {
    uint8_t path[8];     /* from the first router to the station; zeros behind it */
    uint8_t path_length; /* tells 3 from 3/0 */
    uint8_t device;
} sis_place_t;

/* The same text. */
const char *sis_place_text(wmem_allocator_t *scope, const sis_place_t *place);

typedef enum {
    SIS_FROM_NOWHERE,
    SIS_FROM_BUS,
    SIS_FROM_TABLE,
    SIS_FROM_TWIN, /* heard from a device of the same type */
    SIS_BUILT_IN,
    SIS_FROM_STANDARD,
} sis_source_t;

/* What is known of a parameter, each part from the best source. Never changed once made: new knowledge
 * makes a new one. */
typedef struct sis_known {
    const char *name; /* NULL: unknown */
    const char *unit;
    const char *bits;    /* names of bits as in the user's table, NULL: unknown */
    const char *minimum; /* as text with its unit */
    const char *maximum;
    uint32_t attribute;       /* valid unless attribute_from is SIS_FROM_NOWHERE */
    uint32_t first_attribute; /* the first that was read on the bus, valid if attribute is from there */
    sis_source_t name_from;
    sis_source_t unit_from;
    sis_source_t attribute_from;
    sis_source_t minimum_from;
    sis_source_t maximum_from;
    const sis_place_t *twin; /* valid if a part is from there */
} sis_known_t;

/* "S-0-0044", "P-2-0012", "A-0-0004", "C-0-0066", "type3-0-0066", "S-0-0390.0.136". */
const char *sis_ident_text(wmem_allocator_t *scope, sis_ident_t ident);

/* The ident of such a text, of the first four kinds; the place behind it. NULL: none is there. */
const char *sis_ident_parse(const char *text, sis_ident_t *ident);

/* What the user's table, the built-in one and Wireshark's names of S parameters say. Without a place: what
 * they say of every station. */
sis_known_t sis_known_from_tables(const sis_place_t *place, sis_ident_t ident);

/* A named bit of such a text; `bits` goes behind it. */
typedef struct {
    unsigned number;
    const char *name;
    unsigned length; /* of the name */
} sis_bit_t;

/* Takes the next bit. False: it is none. */
bool sis_bit_take(const char **bits, sis_bit_t *bit);

#endif
