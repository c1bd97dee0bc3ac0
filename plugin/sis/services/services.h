/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The services, one file for each group, in the order of the specification. Each function decodes what
 * follows the status byte of a reaction, or the whole body of a command. What the first pass has to learn
 * from it afterwards, it leaves in body->learn. */

#ifndef SIS_SERVICES_SERVICES_H
#define SIS_SERVICES_SERVICES_H

#include "sis/body.h"

void sis_dissect_identification(sis_body_t *body);
void sis_dissect_cancel(sis_body_t *body);
void sis_dissect_flash(sis_body_t *body);
void sis_dissect_initialization(sis_body_t *body);
void sis_dissect_parameter(sis_body_t *body);
void sis_dissect_phase(sis_body_t *body);

/* Adds what the first pass knows of the phase switch that a reaction polls. */
void sis_show_switch(sis_body_t *body);

#endif
