/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Common fields of the other SYNAX200 transports: a protocol for them, and their expert items. */

#ifndef SYNAX_FIELDS_H
#define SYNAX_FIELDS_H

#include "compat.h"

#include <epan/expert.h>

extern int proto_synax;

extern int hf_synax_request_in;  /* of an answer */
extern int hf_synax_answer_in;   /* of a request */
extern int hf_synax_answer_time; /* from the request to its answer */

/* Every use has a text of its own. */
extern expert_field ei_synax_note; /* undefined in the documents */
extern expert_field ei_synax_short;
extern expert_field ei_synax_unexpected;
extern expert_field ei_synax_error;             /* that an answer reports */
extern expert_field ei_synax_unanswered;        /* only a later packet shows it */
extern expert_field ei_synax_unanswered_before; /* on the request that follows */
extern expert_field ei_synax_too_many;          /* pieces of a transfer */

void synax_fields_register(void);

#endif
