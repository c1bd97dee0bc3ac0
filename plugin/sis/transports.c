/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sources of SIS telegrams besides the serial tap: TCP, UDP, RTAC serial captures. */
#include "parts.h"

#include "protocol/fields.h"
#include "sis/frame.h"
#include "sis/packet-sis.h"
#include "sis/segments.h"

/* S/IP, another protocol of the same drives. */
#define SIP_PORT 35021

static dissector_handle_t tcp_handle;

typedef enum { NO_TELEGRAM, GOOD, DAMAGED, INCOMPLETE } candidate_t;

/* What seems to begin at offset, judging by the available bytes.
 *
 * TCP hands over an incomplete telegram again when the rest of it has come. A damaged telegram that ends
 * exactly with the bytes has perhaps come this way. To wait for another one inside it would dissect the same
 * bytes again and again. */
static candidate_t
examine(tvbuff_t *tvb, unsigned offset, bool *can_wait)
{
    unsigned there = tvb_captured_length_remaining(tvb, offset), declared = sis_declared_length(tvb, offset);

    if (compat_get_uint8(tvb, offset) != SIS_START || (there >= 4 && declared == 0))
        return NO_TELEGRAM;
    if (there < 4 || declared > there)
        return INCOMPLETE;
    if (sis_is_good(tvb, offset))
        return GOOD;
    if (declared == there)
        *can_wait = false;
    return DAMAGED;
}

/* For sis_segments_dissect(): the length of the telegram at offset; 0 if more bytes are needed. Without a
 * telegram (a segment was lost, the capture began in the middle): the length up to the next one. A damaged
 * telegram also ends where another one begins: if a character was lost, its length counts the first one of
 * the next. */
static unsigned
telegram_length(packet_info *pinfo _U_, tvbuff_t *tvb, int offset, void *can_wait)
{
    unsigned begin = offset, next = begin, rest = tvb_reported_length_remaining(tvb, begin);
    unsigned declared = sis_declared_length(tvb, begin);
    candidate_t first = examine(tvb, begin, can_wait);

    if (first == GOOD || (first == INCOMPLETE && *(bool *)can_wait))
        return declared;
    if (first == DAMAGED)
        rest = declared;
    while (compat_find_uint8(tvb, next + 1, SIS_START, &next) && next - begin < rest) {
        candidate_t other = examine(tvb, next, can_wait);
        bool is_awaited = other == INCOMPLETE && (first != DAMAGED || sis_declared_length(tvb, next) > 0);

        if (other == GOOD || (is_awaited && *(bool *)can_wait))
            return next - begin;
    }
    return rest;
}

/* SIS writes the columns only if a telegram ends here; TCP describes a segment with just a part. The fence
 * keeps the text of earlier telegrams. */
static int
dissect_pdu(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SIS");
    col_clear(pinfo->cinfo, COL_INFO);
    sis_dissect_telegram(tvb, pinfo, tree);
    col_set_fence(pinfo->cinfo, COL_INFO);
    return tvb_captured_length(tvb);
}

/* Telegrams split over segments and packed into them. */
static int
dissect_tcp(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    bool can_wait = pinfo->can_desegment > 0;

    return sis_segments_dissect(tvb, pinfo, tree, telegram_length, dissect_pdu, &can_wait);
}

/* USIP and others also start with 0x02. So only a whole telegram with equal lengths and a zero checksum
 * counts, and another one must follow it. */
static bool
is_sis(tvbuff_t *tvb)
{
    unsigned declared = sis_declared_length(tvb, 0);

    return sis_is_good(tvb, 0) &&
           (declared == tvb_captured_length(tvb) || compat_get_uint8(tvb, declared) == SIS_START);
}

static compat_bool
dissect_tcp_heuristic(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    sis_segments_look(tvb, pinfo);
    if (!pref_sis_tcp_heuristic || pinfo->srcport == SIP_PORT || pinfo->destport == SIP_PORT || !is_sis(tvb))
        return FALSE;
    return sis_recognize(tvb, pinfo, tree, tcp_handle, dissect_tcp);
}

static compat_bool
dissect_udp_heuristic(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    return pref_sis_udp_heuristic && is_sis(tvb) &&
           sis_recognize(tvb, pinfo, tree, sis_handle, sis_dissect_packet);
}

void
sis_transports_handoff(void)
{
    tcp_handle = create_dissector_handle(dissect_tcp, proto_sis);
    dissector_add_for_decode_as("tcp.port", tcp_handle);
    dissector_add_for_decode_as("udp.port", sis_handle);
    heur_dissector_add("tcp", dissect_tcp_heuristic, "SIS over TCP", "sis_tcp", proto_sis, HEURISTIC_ENABLE);
    heur_dissector_add("udp", dissect_udp_heuristic, "SIS over UDP", "sis_udp", proto_sis, HEURISTIC_ENABLE);
    dissector_add_for_decode_as("rtacser.data", sis_handle);
}
