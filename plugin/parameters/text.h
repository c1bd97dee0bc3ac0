/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Text of drives, in readable form. */

#ifndef PARAMETERS_TEXT_H
#define PARAMETERS_TEXT_H

#include "compat.h"

/* All characters, in readable form. */
const char *sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length);

/* A text of up to that many characters, followed by "..." if there are more. */
const char *sis_text_shortened(wmem_allocator_t *scope, const char *text, unsigned most);

#endif
