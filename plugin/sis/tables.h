/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Tables of the timing. */

#ifndef SIS_TABLES_H
#define SIS_TABLES_H

#include "compat.h"

void sis_tables_register(void);

#endif
