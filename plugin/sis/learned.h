/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus has said about the parameters of a telegram's station. */

#ifndef SIS_LEARNED_H
#define SIS_LEARNED_H

#include "parameters/learned.h"
#include "sis/body.h"

/* The device of a command. */
sis_place_t sis_station_place(const sis_exchange_t *exchange, uint8_t device);

/* The device of a body of its station; without stations if these are unknown. */
sis_place_t sis_station_of(const sis_body_t *body, uint8_t device);

/* What was known of a parameter of that station when its command was sent. */
sis_known_t sis_station_known(sis_body_t *body, sis_ident_t ident, uint8_t device);

/* Later passes: adds what the bus has said of it only afterwards. */
void sis_station_complete(const sis_body_t *body, sis_ident_t ident, uint8_t device, sis_known_t *known);

/* A good reaction tells the type of a device. */
void sis_station_identify(const sis_body_t *body, sis_identity_t what, tvbuff_t *tvb);

/* What was learned on a bus. */
sis_learned_t *sis_learned_of(sis_bus_t *bus);

/* A reaction with an element of a parameter, with all its data; `shown` is its value as text. */
void sis_station_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element,
                       tvbuff_t *tvb, const char *shown);

#endif
