/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Useful data: which file takes which service apart. */

#ifndef SIS_DISPATCH_H
#define SIS_DISPATCH_H

#include "sis/body.h"

/* Takes a whole body apart, status byte first; what is left over is marked. */
void sis_dissect_body(sis_body_t *body);

void sis_dispatch_register(void);

#endif
