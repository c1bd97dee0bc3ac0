/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Operating data in readable form: attribute, scaling, lists (IEC 61491). */

#ifndef PARAMETERS_VALUES_H
#define PARAMETERS_VALUES_H

#include "parameters/parameters.h"

/* Data of an element: all of `tvb`, with its length words where it is a list. */
typedef struct {
    tvbuff_t *tvb;
    unsigned encoding;        /* ENC_LITTLE_ENDIAN in SIS, ENC_BIG_ENDIAN in other transports */
    bool is_whole;            /* false: a segment of a list */
    const sis_place_t *place; /* whose they are; NULL: unknown */
} sis_element_data_t;

/* Adds the data of an element: bytes as sis.data, and what they mean as far as that is known. Gives a short
 * text for the packet list ("12.5000 rpm", "\"Velocity command value\""), NULL where there is nothing better
 * than bytes. `ident` is NULL where the command is not known. */
const char *sis_add_element(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data,
                            sis_element_t element, const sis_ident_t *ident, const sis_known_t *known);

/* The number in the text of such data; false if it has none: bits, idents, lists, infinity. */
bool sis_element_number(const sis_element_data_t *data, const sis_known_t *known, const char *text,
                        double *number);

/* Adds the bits that are set in a value and have a name; `bits` is as in sis_known_t. */
void sis_add_named_bits(proto_item *item, tvbuff_t *tvb, unsigned offset, unsigned length, uint64_t raw,
                        const char *bits);

/* Why the data of an element do not fit its attribute, in words; NULL: they fit. */
const char *
sis_element_misfit(const sis_element_data_t *data, sis_element_t element, const sis_known_t *known);

/* Text of drives, all characters of it in readable form. */
const char *sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length);

/* A text of up to that many characters, followed by "..." if there are more. */
const char *sis_text_shortened(wmem_allocator_t *scope, const char *text, unsigned most);

/* A name or a unit, without the two length words at the beginning of a list. */
const char *sis_element_text(wmem_allocator_t *scope, tvbuff_t *tvb);

#endif
