/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Interbus PCP: services on objects, in words. */

#ifndef SYNAX_SYNAXPCP_H
#define SYNAX_SYNAXPCP_H

#include "compat.h"

/* The dissector "synaxpcp": a message from its service code on. */
void synaxpcp_register(void);

#endif
