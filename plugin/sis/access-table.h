/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The list of parameters. */

#ifndef SIS_ACCESS_TABLE_H
#define SIS_ACCESS_TABLE_H

#include "compat.h"

void sis_access_table_register(void);

#endif
