/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Statistics of the line itself. */

#ifndef SERTAP_STATISTICS_H
#define SERTAP_STATISTICS_H

#include "compat.h"

void sertap_statistics_register(void);

#endif
