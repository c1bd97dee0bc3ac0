/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Recognises a SIS telegram: start character, equal lengths, checksum (chapter 2.1). */

#ifndef SIS_FRAME_H
#define SIS_FRAME_H

#include "compat.h"

#define SIS_START         0x02
#define SIS_STATIC_LENGTH 8u /* of the header; DatLW counts the bytes after it */

/* The declared length of the telegram at offset; 0: unknown (too short, or its two lengths differ). */
unsigned sis_declared_length(tvbuff_t *tvb, unsigned offset);

/* Sum of bytes modulo 256; 0 for a telegram with a good checksum. */
uint8_t sis_sum(tvbuff_t *tvb, unsigned offset, unsigned length);

/* A whole telegram with start character, equal lengths and a zero sum. */
bool sis_is_good(tvbuff_t *tvb, unsigned offset);

#endif
