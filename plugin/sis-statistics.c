/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Wireshark's Conversations and Endpoints by station: `tshark -z conv,sis`, `-z endpoints,sis`. */

#include "packet-sis.h"

#include <epan/conversation_table.h>
#include <epan/tap.h>

#include "sis-address.h"

static const char *
conversation_filter(conv_item_t *item _U_, conv_filter_type_e filter)
{
    switch (filter) {
    case CONV_FT_SRC_ADDRESS:
        return "sis.talker";
    case CONV_FT_DST_ADDRESS:
        return "sis.listener";
    case CONV_FT_ANY_ADDRESS:
        return "sis.station";
    default:
        return CONV_FILTER_INVALID;
    }
}

static ct_dissector_info_t conversation_info = {&conversation_filter};

static tap_packet_status
conversation_packet(void *table, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data,
                    tap_flags_t flags)
{
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!telegram->is_good)
        return TAP_PACKET_DONT_REDRAW; /* its addresses may be anybody's */
    hash->flags = flags;
    sis_station_address(&talker, &telegram->talker);
    sis_station_address(&listener, &telegram->listener);
    add_conversation_table_data(hash, &talker, &listener, 0, 0, 1, telegram->length, &pinfo->rel_ts,
                                &pinfo->abs_ts, &conversation_info, CONVERSATION_NONE);
    return TAP_PACKET_REDRAW;
}

static const char *
endpoint_filter(endpoint_item_t *item _U_, conv_filter_type_e filter)
{
    return filter == CONV_FT_ANY_ADDRESS ? "sis.station" : CONV_FILTER_INVALID;
}

static et_dissector_info_t endpoint_info = {&endpoint_filter};

static tap_packet_status
endpoint_packet(void *table, packet_info *pinfo _U_, epan_dissect_t *edt _U_, const void *data,
                tap_flags_t flags)
{
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!telegram->is_good)
        return TAP_PACKET_DONT_REDRAW; /* its addresses may be anybody's */
    hash->flags = flags;
    sis_station_address(&talker, &telegram->talker);
    sis_station_address(&listener, &telegram->listener);
    add_endpoint_table_data(hash, &talker, 0, TRUE, 1, telegram->length, &endpoint_info, ENDPOINT_NONE);
    add_endpoint_table_data(hash, &listener, 0, FALSE, 1, telegram->length, &endpoint_info, ENDPOINT_NONE);
    return TAP_PACKET_REDRAW;
}

void
sis_statistics_register(void)
{
    register_conversation_table(proto_sis, TRUE, conversation_packet, endpoint_packet);
}
