/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Statistics of the other transports. */

#ifndef SYNAX_STATISTICS_H
#define SYNAX_STATISTICS_H

#include "compat.h"

void synax_statistics_register(void);

#endif
