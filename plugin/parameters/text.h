/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Text of drives, as a person reads it. */

#ifndef PARAMETERS_TEXT_H
#define PARAMETERS_TEXT_H

#include "compat.h"

/* Characters as a person reads them, all of them. */
const char *sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length);

/* So many characters of a text at most, and "..." behind them where there are more. */
const char *sis_text_shortened(wmem_allocator_t *scope, const char *text, unsigned most);

#endif
