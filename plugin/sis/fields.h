/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What more than one file of the dissector shows: the protocol, its expert items, fields that several
 * services have. */

#ifndef SIS_FIELDS_H
#define SIS_FIELDS_H

#include "parameters/fields.h"

#include <epan/expert.h>

extern int sis_tap; /* receives every sis_telegram_t */
extern expert_module_t *sis_experts;

extern int hf_sis_service;
extern int hf_sis_status;
extern int hf_sis_device;
extern int hf_sis_subservice;
extern int hf_sis_error;
extern int hf_sis_baud_mask;
extern int hf_sis_phase;

/* Wrong or missing data of a service; every use has a text of its own. */
extern expert_field ei_sis_missing;
extern expert_field ei_sis_unexpected;
extern expert_field ei_sis_note;
/* A status or an error code of a reaction. */
extern expert_field ei_sis_status;
extern expert_field ei_sis_status_telegram;

/* The protocol itself; the other files register their own items after it. */
void sis_fields_register(void);

#endif
