/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The first pass. */

#ifndef SIS_LEARN_H
#define SIS_LEARN_H

#include "sis/body.h"

/* The record of the next telegram of its packet: in the first pass made from what is known so far, later as
 * it was made then. Never NULL. */
sis_record_t *sis_learn_telegram(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* First pass: takes what a telegram, or an element of a list, has taught; its body is decoded. */
void sis_learn_body(sis_body_t *body);

#endif
