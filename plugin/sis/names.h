/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a service before its bytes are read: its name in the edition that is set, its subservices,
 * the service whose layout it has (chapters 2.1 and 8). */

#ifndef SIS_NAMES_H
#define SIS_NAMES_H

#include "protocol/fields.h"

/* Preference sis.edition: addresses, names of services and bits of the telegram control differ. */
typedef enum { SIS_EDITION_IF02, SIS_EDITION_ECODRIVE03 } sis_edition_t;

/* "Read parameter", or "ECODRIVE service" where only the range has a name. */
const char *sis_service_range_name(uint8_t service);

/* "Read parameter", or "ECODRIVE service 0x83" where only the range has a name. */
const char *sis_service_name(wmem_allocator_t *scope, uint8_t service);

/* The subservices of a service whose body begins with the device address and one of them; NULL: it has none.
 */
const value_string *sis_subservices_of(uint8_t service);

/* Whether a reaction with this subservice may answer a command with that one. A subservice that is not
 * defined tells nothing: fig. 2-13 answers 0x01 with 0xF1. */
bool sis_may_answer_subservice(uint8_t service, uint8_t asked, uint8_t answered);

/* In the edition that is set. */
bool sis_service_is_reserved(uint8_t service);

/* 0x10 for 0x10, 0x80, 0x90: the general service that corresponds to a product group's service, else the
 * service itself. */
uint8_t sis_general_service(uint8_t service);

/* Whether a body begins with parameter control and device address. */
bool sis_has_control_byte(uint8_t service);
#define SIS_ELEMENT_OF(control) (((control)&SIS_ELEMENT) >> 3)

/* Whether a reaction of this service begins with a status byte. */
bool sis_has_status(uint8_t service);

#endif
