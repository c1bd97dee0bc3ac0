/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Services with the same layout, and their common first fields (chapters 2.1 and 8). */

#ifndef SIS_LAYOUTS_H
#define SIS_LAYOUTS_H

#include "compat.h"

#include <epan/prefs.h>

/* 0x10 for 0x10, 0x80, 0x90: the general service that corresponds to a product group's service, else the
 * service itself. */
uint8_t sis_general_service(uint8_t service);

/* Whether a body begins with parameter control and device address. */
bool sis_has_control_byte(uint8_t service);
#define SIS_LAST_TRANSMISSION 0x04 /* bit 2 of the parameter control, fig. 8-1 */
#define SIS_ELEMENT(control)  ((control) >> 3 & 7)

/* Whether a reaction of this service begins with a status byte. */
bool sis_has_status(uint8_t service);

/* The preferences for services that the documents leave open. */
void sis_layouts_register(module_t *module);

#endif
