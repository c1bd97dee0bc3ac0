/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Text of drives, as a person reads it. */

#include "parameters/text.h"

/* Never ends at a NUL, and shows control characters as their pictures (U+2400 and following). */
const char *
sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");

    for (unsigned i = 0; i < length; i++) {
        uint8_t c = compat_get_uint8(tvb, offset + i);

        wmem_strbuf_append_unichar(text, c < 0x20 ? 0x2400 + c : c < 0x7F ? c : c == 0x7F ? 0x2421 : 0xFFFD);
    }
    return wmem_strbuf_get_str(text);
}
