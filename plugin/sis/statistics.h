/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Wireshark's standard statistics of telegrams. */

#ifndef SIS_STATISTICS_H
#define SIS_STATISTICS_H

#include "compat.h"

void sis_statistics_register(void);

#endif
