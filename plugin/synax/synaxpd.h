/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Process data over UDP (chapter 6). */

#ifndef SYNAX_SYNAXPD_H
#define SYNAX_SYNAXPD_H

#include "compat.h"

/* The dissector "synaxpd", its preferences and the table "SYNAX process data". */
void synaxpd_register(void);

void synaxpd_handoff(void);

#endif
