/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus has said about the parameters of a telegram's station. */

#ifndef SIS_STATION_H
#define SIS_STATION_H

#include "parameters/learned.h"
#include "sis/body.h"

/* What was learned on a bus. */
sis_learned_t *sis_learned_of(sis_bus_t *bus);

/* The device of a body of its station; without stations if these are unknown. */
sis_place_t sis_station_of(const sis_body_t *body, uint8_t device);

/* What was known of a parameter of that station when its command was sent. */
sis_known_t sis_station_known(sis_body_t *body, sis_ident_t ident, uint8_t device);

/* Later passes: adds what the bus has said only afterwards of the parameter that was asked for. */
void sis_station_complete(const sis_body_t *body, sis_known_t *known);

/* First pass: a good reaction has told the type of its device, as body->text. */
void sis_station_identify(const sis_body_t *body, sis_identity_t what);

/* First pass: a reaction has brought an element of the parameter that was asked for. */
void sis_station_learn(sis_body_t *body);

#endif
