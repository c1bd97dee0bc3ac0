/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Useful data: chooses the file that decodes a service. */

#ifndef SIS_DISPATCH_H
#define SIS_DISPATCH_H

#include "sis/body.h"

/* Decodes a whole body, status byte first; marks bytes that are left over. */
void sis_dissect_body(sis_body_t *body);

#endif
