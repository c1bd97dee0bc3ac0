/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Conversation filters, Follow. */

#ifndef SIS_FOLLOW_H
#define SIS_FOLLOW_H

#include "compat.h"

void sis_follow_register(void);

#endif
