/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The data exchange protocol on ARCNET, protocol id 0x7F (chapter 7 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P). */

#ifndef SYNAX_ARCNET7F_H
#define SYNAX_ARCNET7F_H

#include "compat.h"

void synax_arcnet7f_register(void);
void synax_arcnet7f_handoff(void);

#endif
