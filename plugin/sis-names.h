/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Every code of the SIS documents and its text. */

#ifndef SIS_NAMES_H
#define SIS_NAMES_H

#include "compat.h"

extern const range_string sis_services[];

extern const range_string sis_receivers_if02[];
extern const range_string sis_receivers_ecodrive03[];
extern const range_string sis_senders_if02[];
extern const range_string sis_senders_ecodrive03[];

extern const value_string sis_control_status_ecodrive03[];

extern const range_string sis_status[];
extern const range_string sis_status_phase[];

/* "Read parameter", or "ECODRIVE service 0x83" where only the range has a name. */
const char *sis_service_name(wmem_allocator_t *scope, uint8_t service);

#endif
