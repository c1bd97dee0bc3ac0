/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Conversations and Endpoints: who talks to whom (`tshark -z conv,sis`, `-z endpoints,sis`). The addresses
 * are AT_NUMERIC: the windows sort other types as text, 16 before 3. */
#include "parts.h"

#include <epan/conversation_table.h>
#include <epan/tap.h>

#include "protocol/fields.h"
#include "sis/telegram.h"

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

static const char *
endpoint_filter(endpoint_item_t *item _U_, conv_filter_type_e filter)
{
    return filter == CONV_FT_ANY_ADDRESS ? "sis.station" : CONV_FILTER_INVALID;
}

/* False: its addresses are uncertain. */
static bool
find_stations(const sis_telegram_t *telegram, address *talker, address *listener)
{
    set_address(talker, AT_NUMERIC, 1, &telegram->talker);
    set_address(listener, AT_NUMERIC, 1, &telegram->listener);
    return telegram->is_good;
}

static tap_packet_status
count_conversation(void *table, packet_info *pinfo, epan_dissect_t *edt _U_, const void *data,
                   tap_flags_t flags)
{
    static ct_dissector_info_t info = {&conversation_filter};
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!find_stations(telegram, &talker, &listener))
        return TAP_PACKET_DONT_REDRAW;
    hash->flags = flags;
    add_conversation_table_data(hash, &talker, &listener, 0, 0, 1, telegram->length, &pinfo->rel_ts,
                                &pinfo->abs_ts, &info, CONVERSATION_NONE);
    return TAP_PACKET_REDRAW;
}

static tap_packet_status
count_endpoints(void *table, packet_info *pinfo _U_, epan_dissect_t *edt _U_, const void *data,
                tap_flags_t flags)
{
    static et_dissector_info_t info = {&endpoint_filter};
    const sis_telegram_t *telegram = data;
    conv_hash_t *hash = table;
    address talker, listener;

    if (!find_stations(telegram, &talker, &listener))
        return TAP_PACKET_DONT_REDRAW;
    hash->flags = flags;
    add_endpoint_table_data(hash, &talker, 0, TRUE, 1, telegram->length, &info, ENDPOINT_NONE);
    add_endpoint_table_data(hash, &listener, 0, FALSE, 1, telegram->length, &info, ENDPOINT_NONE);
    return TAP_PACKET_REDRAW;
}

void
windows_stations_register(void)
{
    register_conversation_table(proto_sis, TRUE, count_conversation, count_endpoints);
}
