/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The characters of a serial line that come over TCP. A terminal server may speak Telnet (RFC 854; RFC 2217
 * sets the line's rate by it): it begins with a negotiation. From then on each FF is doubled, and commands
 * stand anywhere between the characters. */
#include "sis/segments.h"

#include <epan/conversation.h>

#include "protocol/fields.h"
#include "protocol/limits.h"

#define IAC      0xFF
#define SE       0xF0
#define SB       0xFA
#define WILL     0xFB
#define DO       0xFD
#define COM_PORT 0x2C /* the option of RFC 2217; what else serial lines need has smaller numbers */

#define NEGOTIATION_LENGTH 3u /* that shows what it is; fewer bytes may become one */

/* What is left of a segment. */
typedef struct {
    tvbuff_t *tvb;
    unsigned *places; /* where each character stands in the segment, then what is no character yet */
    unsigned end;     /* of what is whole */
} characters_t;

/* Of the command at offset; more than there is: its end is missing. 0: a character, FF FF included. */
static unsigned
command_length(tvbuff_t *tvb, unsigned offset)
{
    unsigned there = tvb_captured_length_remaining(tvb, offset);
    uint8_t verb;

    if (compat_get_uint8(tvb, offset) != IAC)
        return 0;
    if (there == 1)
        return 2;
    verb = compat_get_uint8(tvb, offset + 1);
    if (verb == IAC)
        return 0;
    if (verb != SB)
        return verb > SB ? 3 : 2;
    for (unsigned i = 3; i < MIN(there, SIS_MOST_TELNET); i++) {
        if (compat_get_uint8(tvb, offset + i) == SE && compat_get_uint8(tvb, offset + i - 1) == IAC)
            return i + 1;
    }
    return there < SIS_MOST_TELNET ? there + 1 : 2;
}

/* Noise of a line begins so in one segment of 180,000. */
static bool
is_negotiation(tvbuff_t *tvb)
{
    uint8_t verb = tvb_captured_length(tvb) >= NEGOTIATION_LENGTH ? compat_get_uint8(tvb, 1) : 0;
    uint8_t option = verb != 0 ? compat_get_uint8(tvb, 2) : 0;

    return verb != 0 && compat_get_uint8(tvb, 0) == IAC &&
           (verb == SB ? option == COM_PORT : (verb == WILL || verb == DO) && option <= COM_PORT);
}

/* The packet from which on a connection is Telnet; 0: it is not. */
static uint32_t
telnet_from(packet_info *pinfo)
{
    conversation_t *connection = find_or_create_conversation(pinfo);

    return GPOINTER_TO_UINT(conversation_get_proto_data(connection, proto_sis));
}

void
sis_segments_look(tvbuff_t *tvb, packet_info *pinfo)
{
    if (is_negotiation(tvb) && telnet_from(pinfo) == 0)
        conversation_add_proto_data(find_or_create_conversation(pinfo), proto_sis,
                                    GUINT_TO_POINTER(pinfo->num));
}

static characters_t
characters_of(tvbuff_t *tvb, packet_info *pinfo)
{
    unsigned there = tvb_captured_length(tvb), count = 0, length;
    uint8_t *values = wmem_alloc(pinfo->pool, there + 1);
    characters_t left = {.places = wmem_alloc_array(pinfo->pool, unsigned, there + 1)};

    while (left.end < there && (length = command_length(tvb, left.end)) <= there - left.end) {
        if (length == 0) {
            left.places[count] = left.end;
            values[count] = compat_get_uint8(tvb, left.end);
            length = values[count++] == IAC ? 2 : 1;
        }
        left.end += length;
    }
    left.places[count] = left.end;
    left.tvb = tvb_new_child_real_data(tvb, values, count, count + tvb_reported_length(tvb) - there);
    if (count > 0)
        add_new_data_source(pinfo, left.tvb, "Characters without Telnet");
    return left;
}

static void
wait_for_more(packet_info *pinfo, unsigned offset)
{
    pinfo->desegment_offset = offset;
    pinfo->desegment_len = DESEGMENT_ONE_MORE_SEGMENT;
}

int
sis_segments_dissect(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree,
                     unsigned (*length_of)(packet_info *, tvbuff_t *, int, void *), dissector_t dissect_unit,
                     void *data)
{
    unsigned there = tvb_captured_length(tvb);
    characters_t left = {tvb, NULL, there};
    uint32_t from;

    sis_segments_look(tvb, pinfo);
    from = telnet_from(pinfo);
    if (from != 0 && from <= pinfo->num)
        left = characters_of(tvb, pinfo);
    else if (pinfo->can_desegment && there < NEGOTIATION_LENGTH && command_length(tvb, 0) > there)
        left.end = 0;
    if (left.end > 0)
        tcp_dissect_pdus(left.tvb, pinfo, tree, TRUE, 1, length_of, dissect_unit, data);
    if (pinfo->desegment_len > 0 && left.places != NULL)
        wait_for_more(pinfo,
                      left.places[pinfo->desegment_offset]); /* nobody knows how many bytes that takes */
    else if (pinfo->desegment_len == 0 && pinfo->can_desegment && left.end < there)
        wait_for_more(pinfo, left.end);
    return (int)there;
}

compat_bool
sis_recognize(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, dissector_handle_t handle,
              dissector_t dissect)
{
    conversation_set_dissector_from_frame_number(find_or_create_conversation(pinfo), pinfo->num, handle);
    dissect(tvb, pinfo, tree, NULL); /* called by its handle, it could not ask TCP for more */
    return TRUE;
}

void
sis_separate(packet_info *pinfo)
{
    const char *info = col_get_text(pinfo->cinfo, COL_INFO);

    if (info != NULL && info[0] != '\0' && !g_str_has_suffix(info, " "))
        col_append_str(pinfo->cinfo, COL_INFO, " | ");
}
