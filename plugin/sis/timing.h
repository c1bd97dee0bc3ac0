/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Verdicts on the timing of telegrams (chapter 10), and how busy the bus is. */

#ifndef SIS_TIMING_H
#define SIS_TIMING_H

#include "sis/body.h"

/* Adds the timing of a telegram to its tree, and notes; fills in telegram->timing. `body` is decoded
 * already. */
void sis_timing_dissect(sis_telegram_t *telegram, const sis_record_t *record, const sis_body_t *body);

#endif
