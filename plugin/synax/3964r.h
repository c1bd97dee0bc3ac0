/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The 3964R procedure on a serial line. */

#ifndef SYNAX_3964R_H
#define SYNAX_3964R_H

#include "compat.h"

void synax_3964r_register(void);
void synax_3964r_handoff(void);

#endif
