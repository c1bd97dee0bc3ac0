/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus said about parameters. It is learned in the first pass. A user of it keeps what was known
 * then, so that all passes show the same. */

#ifndef PARAMETERS_LEARNED_H
#define PARAMETERS_LEARNED_H

#include "parameters/parameters.h"

/* A device behind a station, perhaps through routers. */
typedef struct {
    uint8_t path[8];     /* from the first router to the station; zeros behind it */
    uint8_t path_length; /* tells 3 from 3/0 */
    uint8_t device;
} sis_place_t;

/* What was said on one bus; lives as long as the file. */
typedef struct sis_learned sis_learned_t;

sis_learned_t *sis_learned_new(void);

/* What was said about a parameter so far; NULL: nothing. Never changed once made. */
const sis_known_t *sis_learned_find(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident);

/* Completed from the tables. `said` may be NULL. */
sis_known_t sis_learned_or_from_tables(const sis_known_t *said, sis_ident_t ident);

/* First pass: an element of a parameter was read, with all its data; `shown` is its value as text. */
void sis_learned_add(sis_learned_t *learned, wmem_allocator_t *pool, const sis_place_t *place,
                     sis_ident_t ident, sis_element_t element, tvbuff_t *tvb, const char *shown);

#endif
