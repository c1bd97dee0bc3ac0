/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Every code of the SIS documents and its text. */

#ifndef SIS_NAMES_H
#define SIS_NAMES_H

#include "compat.h"

/* Preference sis.edition: addresses, names of services and bits of the telegram control differ. */
typedef enum { SIS_EDITION_IF02, SIS_EDITION_ECODRIVE03 } sis_edition_t;
extern int sis_edition;

extern const range_string sis_services[];

typedef enum {
    SIS_STATION,
    SIS_SERVICE_MASTER,
    SIS_POINT_TO_POINT,
    SIS_NOT_ASSIGNED,
    SIS_RESERVED,
    SIS_NO_SENDER,
    SIS_GROUP, /* this and the following are not answered */
    SIS_LEVEL_BROADCAST,
    SIS_GLOBAL_BROADCAST,
} sis_address_kind_t;

extern const value_string sis_address_kinds[];

extern const value_string sis_control_status_ecodrive03[];

extern const range_string sis_status[];
extern const range_string sis_status_phase[];

extern const value_string sis_errors_channel[];
extern const value_string sis_subservices_identification[];
extern const value_string sis_subservices_flash[];
extern const value_string sis_errors_flash[];
extern const value_string sis_shutdown_targets[];
extern const value_string sis_device_types[];
extern const value_string sis_subservices_initialization[];
extern const value_string sis_errors_initialization[];
extern const value_string sis_baud_masks[];
extern const value_string sis_elements[];
extern const value_string sis_errors_parameter[];
extern const value_string sis_errors_phase[];
extern const value_string sis_phases[];
extern const value_string sis_data_states[];

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

#endif
