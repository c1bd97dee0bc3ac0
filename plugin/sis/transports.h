/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sources of telegrams besides the serial tap. */

#ifndef SIS_TRANSPORTS_H
#define SIS_TRANSPORTS_H

#include "compat.h"

#include <epan/prefs.h>

void sis_transports_register(module_t *module);

void sis_transports_handoff(void);

#endif
