/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus itself has said of its parameters: whoever reads name, unit and attribute tells every
 * listener. */

#ifndef SIS_LEARNED_H
#define SIS_LEARNED_H

#include "sis-body.h"

/* What one bus has said: nothing yet. Lives as long as the file. */
wmem_map_t *sis_learned_new(void);

/* What is known of a parameter of a device at this telegram: from the bus, else from the user's table, else
 * built in. */
sis_known_t sis_learned_known(sis_body_t *body, sis_ident_t ident, uint8_t device);

/* A good reaction with an element, all of it, and the text that it was shown with (NULL: none). */
void sis_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element, tvbuff_t *tvb,
               const char *shown);

#endif
