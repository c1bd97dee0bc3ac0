/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A parameter in the tree: its ident, and what is known of it. */

#ifndef PARAMETERS_IDENT_H
#define PARAMETERS_IDENT_H

#include "parameters/parameters.h"

#define SIS_NO_TYPE_BYTE UINT_MAX

/* The place of an ident: all of it, its type byte (SIS_NO_TYPE_BYTE: known from elsewhere) and its number
 * word. */
typedef struct {
    unsigned offset, length; /* no length: it is not here, the command has it */
    unsigned type_at, number_at;
    unsigned encoding; /* of the number word */
} sis_ident_place_t;

/* Adds sis.parameter, the parts of the ident, name, unit and limits. Returns its item. */
proto_item *sis_add_ident(proto_tree *tree, wmem_allocator_t *scope, tvbuff_t *tvb,
                          const sis_ident_place_t *place, sis_ident_t ident, const sis_known_t *known);

#endif
