/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Recognises a SIS telegram: start character, equal lengths, checksum (chapter 2.1). */
#include "sis/frame.h"

unsigned
sis_declared_length(tvbuff_t *tvb, unsigned offset)
{
    const uint8_t *lengths;

    if (tvb_captured_length_remaining(tvb, offset) < 4)
        return 0;
    lengths = tvb_get_ptr(tvb, offset + 2, 2);
    return lengths[0] == lengths[1] ? SIS_STATIC_LENGTH + lengths[0] : 0;
}

uint8_t
sis_sum(tvbuff_t *tvb, unsigned offset, unsigned length)
{
    const uint8_t *bytes = tvb_get_ptr(tvb, offset, length);
    uint8_t sum = 0;

    for (unsigned i = 0; i < length; i++)
        sum += bytes[i];
    return sum;
}

bool
sis_is_good(tvbuff_t *tvb, unsigned offset)
{
    unsigned declared = sis_declared_length(tvb, offset);

    return declared > 0 && tvb_bytes_exist(tvb, offset, declared) &&
           compat_get_uint8(tvb, offset) == SIS_START && sis_sum(tvb, offset, declared) == 0;
}
