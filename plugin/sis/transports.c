/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sources of SIS telegrams besides the serial tap: TCP, RTAC serial captures, a user link type. */

#include "sis/transports.h"

#include <epan/conversation.h>
#include <epan/dissectors/packet-tcp.h>
#include <wiretap/wtap.h>

#include "parameters/fields.h"
#include "sis/frame.h"
#include "sis/packet-sis.h"

/* S/IP, another protocol of the same drives. */
#define SIP_PORT 35021

#define DLT_USER_OFF (-1)

static dissector_handle_t tcp_handle;
static compat_bool tcp_heuristic = TRUE;
static int dlt_user = DLT_USER_OFF;
static int dlt_user_taken = DLT_USER_OFF;

/* Whether a telegram may begin at this start character, judging by the available bytes. */
static bool
may_begin(tvbuff_t *tvb, unsigned offset)
{
    unsigned there = tvb_captured_length_remaining(tvb, offset), declared = sis_declared_length(tvb, offset);

    return there < 4 || declared > there || sis_is_good(tvb, offset);
}

/* For tcp_dissect_pdus(): the length of the telegram at offset. Without a telegram (a segment was lost, the
 * capture began in the middle): the length up to the next one. A damaged telegram also ends there: if a
 * character was lost, its length counts the first one of the next. 0 if more bytes are needed. */
static unsigned
telegram_length(packet_info *pinfo, tvbuff_t *tvb, int offset, void *data _U_)
{
    unsigned rest = tvb_reported_length_remaining(tvb, offset), declared = 0;
    unsigned captured = tvb_captured_length_remaining(tvb, offset), next = offset;

    if (compat_get_uint8(tvb, offset) == SIS_START) {
        declared = sis_declared_length(tvb, offset);
        if (declared > captured || sis_is_good(tvb, offset))
            return declared;
        if (captured < 4)
            return pinfo->can_desegment ? 0 : rest;
        if (declared > 0)
            rest = declared;
    }
    while (compat_find_uint8(tvb, next + 1, SIS_START, &next) && next - offset < rest) {
        if (may_begin(tvb, next) && (declared == 0 || tvb_captured_length_remaining(tvb, next) >= 4))
            return next - offset;
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
dissect_tcp(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data)
{
    tcp_dissect_pdus(tvb, pinfo, tree, TRUE, 1, telegram_length, dissect_pdu, data);
    return tvb_captured_length(tvb);
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
dissect_tcp_heuristic(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data)
{
    if (!tcp_heuristic || pinfo->srcport == SIP_PORT || pinfo->destport == SIP_PORT || !is_sis(tvb))
        return FALSE;

    /* From here on: earlier bytes were something else, in the second pass, too. */
    conversation_set_dissector_from_frame_number(find_or_create_conversation(pinfo), pinfo->num, tcp_handle);
    dissect_tcp(tvb, pinfo, tree, data);
    return TRUE;
}

/* clang-format off */
static const enum_val_t dlt_user_choices[] = {
    {"off", "Off", DLT_USER_OFF},
    {"user0", "USER0 (147)", 0},
    {"user1", "USER1 (148)", 1},
    {"user2", "USER2 (149)", 2},
    {"user3", "USER3 (150)", 3},
    {"user4", "USER4 (151)", 4},
    {"user5", "USER5 (152)", 5},
    {"user6", "USER6 (153)", 6},
    {"user7", "USER7 (154)", 7},
    {"user8", "USER8 (155)", 8},
    {"user9", "USER9 (156)", 9},
    {"user10", "USER10 (157)", 10},
    {"user11", "USER11 (158)", 11},
    {"user12", "USER12 (159)", 12},
    {"user13", "USER13 (160)", 13},
    {"user14", "USER14 (161)", 14},
    {"user15", "USER15 (162)", 15},
    {NULL, NULL, 0},
};
/* clang-format on */

void
sis_transports_register(module_t *module)
{
    prefs_register_enum_preference(module, "dlt_user", "Decode a user link type as SIS",
                                   "Captures of this link type hold bare telegrams. Goes before the table of "
                                   "protocol DLT_USER while it is set",
                                   &dlt_user, dlt_user_choices, FALSE);
    prefs_register_bool_preference(
        module, "tcp_heuristic", "Recognize SIS on any TCP port",
        "Where a segment starts with a whole telegram: equal lengths, right checksum", &tcp_heuristic);
}

/* An entry of "wtap_encap" silently overrides the user's own DLT_USER table. So none is made unless
 * requested, and the link type is returned to that table afterwards. */
static void
apply_dlt_user(void)
{
    if (dlt_user == dlt_user_taken)
        return;
    if (dlt_user_taken != DLT_USER_OFF) {
        dissector_delete_uint("wtap_encap", WTAP_ENCAP_USER0 + dlt_user_taken, sis_handle);
        dissector_add_uint("wtap_encap", WTAP_ENCAP_USER0 + dlt_user_taken, find_dissector("user_dlt"));
    }
    if (dlt_user != DLT_USER_OFF)
        dissector_add_uint("wtap_encap", WTAP_ENCAP_USER0 + dlt_user, sis_handle);
    dlt_user_taken = dlt_user;
}

void
sis_transports_handoff(void)
{
    tcp_handle = create_dissector_handle(dissect_tcp, proto_sis);
    dissector_add_for_decode_as("tcp.port", tcp_handle);
    heur_dissector_add("tcp", dissect_tcp_heuristic, "SIS over TCP", "sis_tcp", proto_sis, HEURISTIC_ENABLE);
    dissector_add_for_decode_as("rtacser.data", sis_handle);
    /* For each file, and not when preferences are applied: a change of profile resets them without that. */
    register_init_routine(apply_dlt_user);
}
