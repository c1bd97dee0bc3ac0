/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What a packet tells programs that make no tree of it. */
#include "sis/told.h"

#include <epan/tap.h>

#include "parts.h"

static int told = -1; /* nothing comes through this tap: who listens reads the parts of each packet */

bool
sis_is_told(void)
{
    return have_tap_listener(told);
}

const sis_part_t *
sis_parts(packet_info *pinfo)
{
    return sis_packet(pinfo)->parts;
}

sis_part_t *
sis_part_begin(packet_info *pinfo)
{
    sis_packet_t *packet;
    sis_part_t *part;

    if (!sis_is_told())
        return NULL;
    packet = sis_packet(pinfo);
    part = wmem_new0(pinfo->pool, sis_part_t);
    part->said = wmem_strbuf_new(pinfo->pool, "");
    if (packet->part != NULL)
        packet->part->next = part;
    else
        packet->parts = part;
    packet->part = part;
    return part;
}

/* NULL: nobody reads it. */
static sis_part_t *
present(packet_info *pinfo)
{
    sis_part_t *part = sis_is_told() ? sis_packet(pinfo)->part : NULL;

    return part != NULL ? part : sis_part_begin(pinfo);
}

/* printf() would be half of what a row costs. */
void
sis_say_number(wmem_strbuf_t *said, const char *name, uint64_t value)
{
    char text[24], *begin = text + sizeof text;

    *--begin = '\0';
    *--begin = '\t';
    do {
        *--begin = (char)('0' + value % 10);
        value /= 10;
    } while (value > 0);
    *--begin = '=';
    wmem_strbuf_append(said, name);
    wmem_strbuf_append(said, begin);
}

static void
append_control(wmem_strbuf_t *said, char control)
{
    static const char letters[] = {['\t'] = 't', ['\n'] = 'n', ['\r'] = 'r'};
    size_t code = (unsigned char)control;

    if (code < sizeof letters && letters[code] != '\0')
        wmem_strbuf_append_printf(said, "\\%c", letters[code]);
    else
        wmem_strbuf_append_printf(said, "\\x%02zx", code);
}

void
sis_append_escaped(wmem_strbuf_t *said, const char *text)
{
    while (*text != '\0') {
        const char *end = text;

        while (*end != '\0' && !g_ascii_iscntrl(*end))
            end++;
        wmem_strbuf_append_len(said, text, (size_t)(end - text));
        if (*end != '\0')
            append_control(said, *end++);
        text = end;
    }
}

void
sis_say_text(wmem_strbuf_t *said, const char *name, const char *text)
{
    wmem_strbuf_append(said, name);
    wmem_strbuf_append_c(said, '=');
    sis_append_escaped(said, text);
    wmem_strbuf_append_c(said, '\t');
}

void
sis_tell(packet_info *pinfo, int hf, uint32_t value)
{
    sis_part_t *part = present(pinfo);

    if (part != NULL)
        sis_say_number(part->said, proto_registrar_get_nth((unsigned)hf)->abbrev, value);
}

void
sis_tell_text(packet_info *pinfo, int hf, const char *text)
{
    sis_part_t *part = present(pinfo);

    if (part != NULL && text != NULL)
        sis_say_text(part->said, proto_registrar_get_nth((unsigned)hf)->abbrev, text);
}

void
sis_tell_expert(packet_info *pinfo, const expert_field *ei)
{
    sis_tell(pinfo, ei->hf, 1);
}

void
sis_tell_access(packet_info *pinfo, const struct sis_access *access)
{
    sis_part_t *part = present(pinfo);

    if (part == NULL)
        return;
    if (part->accesses == NULL)
        part->accesses = wmem_array_new(pinfo->pool, sizeof access);
    wmem_array_append_one(part->accesses, access);
}

void
sis_told_register(void)
{
    told = register_tap("sis.told");
}
