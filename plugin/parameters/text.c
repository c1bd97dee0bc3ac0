/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Text of drives, in readable form. */
#include "parameters/text.h"

/* Latin-1, because drives are older than UTF-8. Control characters are shown as their pictures (U+2400 and
 * following). The control characters of Latin-1, and the soft hyphen, are shown as codes: "<9b>". */
static void
append(wmem_strbuf_t *text, uint8_t c)
{
    if ((c >= 0x80 && c < 0xA0) || c == 0xAD)
        wmem_strbuf_append_printf(text, "<%02x>", c);
    else
        wmem_strbuf_append_unichar(text, c < 0x20 ? 0x2400 + c : c == 0x7F ? 0x2421 : c);
}

/* Does not end at a NUL. */
const char *
sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");

    for (unsigned i = 0; i < length; i++)
        append(text, compat_get_uint8(tvb, offset + i));
    return wmem_strbuf_get_str(text);
}

const char *
sis_text_shortened(wmem_allocator_t *scope, const char *text, unsigned most)
{
    if (g_utf8_strlen(text, -1) <= (glong)most)
        return text;
    return wmem_strdup_printf(scope, "%.*s...", (int)(g_utf8_offset_to_pointer(text, most) - text), text);
}
