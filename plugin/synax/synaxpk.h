/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The parameter channel in the cyclic data of Profibus (chapter 3 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P). */

#ifndef SYNAX_SYNAXPK_H
#define SYNAX_SYNAXPK_H

#include "compat.h"

void synax_synaxpk_register(void);
void synax_synaxpk_handoff(void);

#endif
