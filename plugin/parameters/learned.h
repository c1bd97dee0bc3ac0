/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus said about parameters. It is learned in the first pass. A user of it keeps what was known
 * then, so that all passes show the same. */

#ifndef PARAMETERS_LEARNED_H
#define PARAMETERS_LEARNED_H

#include "parameters/parameters.h"

/* What was said on one bus; lives as long as the file. */
typedef struct sis_learned sis_learned_t;

sis_learned_t *sis_learned_new(void);

/* What was said about a parameter so far; NULL: nothing. Never changed once made. */
const sis_known_t *sis_learned_find(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident);

/* What tells the type of a device; two devices that say the same have the same parameters. */
typedef enum { SIS_TYPE_KEY, SIS_FIRMWARE, SIS_IDENTITIES } sis_identity_t;

/* First pass: a device has told its type. */
void
sis_learned_identity(sis_learned_t *learned, const sis_place_t *place, sis_identity_t what, const char *text);

/* What a device of the same type said of its parameter. */
typedef struct sis_twin {
    const sis_known_t *known; /* NULL: nothing */
    const sis_place_t *place;
} sis_twin_t;

sis_twin_t sis_learned_twin(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident);

/* Completed from the user's table, from a twin, and from the other tables. `said`, `twin` and `place` may be
 * NULL: nothing, a place that is not known. */
sis_known_t sis_learned_or_from_tables(const sis_known_t *said, const sis_twin_t *twin,
                                       const sis_place_t *place, sis_ident_t ident);

/* What an element of a parameter says. */
typedef struct {
    sis_element_t element;
    uint32_t attribute; /* of that element */
    const char *text;   /* of the others; NULL: nothing */
} sis_fact_t;

/* From all data of an element; `shown` is its value as text. False: it says nothing valid. */
bool sis_fact_read(sis_fact_t *fact, wmem_allocator_t *pool, sis_element_t element, tvbuff_t *tvb,
                   const char *shown);

/* First pass: an element of a parameter was read. */
void
sis_learned_add(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident, const sis_fact_t *fact);

/* In later passes: adds to what was known of a parameter in the first pass what was only read afterwards. */
void sis_learned_complete(const packet_info *pinfo, sis_learned_t *learned, const sis_place_t *place,
                          sis_ident_t ident, sis_known_t *known);

#endif
