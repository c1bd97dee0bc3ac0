/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The cycle in which a master sends its master control word to a drive. First pass only. */

#ifndef SIS_CYCLE_H
#define SIS_CYCLE_H

#include "sis/body.h"

/* A telegram has come: the bus may have been dead before. */
void sis_cycle_heard(const sis_bus_t *bus, const sis_times_t *times, uint32_t frame);

/* Takes a command that may carry a master control word. */
void sis_cycle_learn(const sis_body_t *body);

#endif
