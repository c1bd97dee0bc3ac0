/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Wireshark's tools that follow related packets: conversation filters for an exchange and for two
 * stations, and Follow for a stream (`tshark -z follow,sis,hex,0`; in Wireshark's menus from 4.4 on). */

#include "sis/follow.h"

#include <epan/conversation_filter.h>
#include <epan/follow.h>
#include <epan/tap.h>

#include "sis/address.h"
#include "sis/exchange.h"
#include "sis/fields.h"

/* Of several telegrams in one packet, the last. */
static const sis_telegram_t *
good_telegram(packet_info *pinfo)
{
    const sis_telegram_t *telegram = sis_packet(pinfo)->last;

    return telegram != NULL && telegram->is_good ? telegram : NULL;
}

static const sis_exchange_t *
exchange_of(packet_info *pinfo)
{
    const sis_telegram_t *telegram = good_telegram(pinfo);

    return telegram != NULL ? telegram->record->exchange : NULL;
}

static compat_bool
has_stations(packet_info *pinfo COMPAT_CONVERSATION_DATA)
{
    return good_telegram(pinfo) != NULL;
}

static char *
stations_filter(packet_info *pinfo COMPAT_CONVERSATION_DATA)
{
    const sis_telegram_t *telegram = good_telegram(pinfo);

    return ws_strdup_printf("sis.station == %u && sis.station == %u", telegram->sender, telegram->receiver);
}

static compat_bool
has_exchange(packet_info *pinfo COMPAT_CONVERSATION_DATA)
{
    return exchange_of(pinfo) != NULL;
}

/* Appends the frames of a command and of its repeats; gives what the next router made of it, NULL: nothing.
 */
static const sis_exchange_t *
append_commands(GString *frames, const sis_exchange_t *exchange)
{
    const sis_exchange_t *forwarded = NULL;

    if (exchange->first != NULL)
        exchange = exchange->first;
    for (; exchange != NULL; exchange = exchange->again) {
        g_string_append_printf(frames, "%s%u", frames->len > 0 ? ", " : "", exchange->command_in);
        if (sis_exchange_below(exchange) != NULL)
            forwarded = sis_exchange_below(exchange);
    }
    return forwarded;
}

/* The command, its repeats, their reactions, on all levels of a hierarchy. */
static char *
exchange_filter(packet_info *pinfo COMPAT_CONVERSATION_DATA)
{
    const sis_exchange_t *exchange = exchange_of(pinfo);
    GString *frames = g_string_new("");
    char *filter;

    while (sis_exchange_above(exchange) != NULL)
        exchange = sis_exchange_above(exchange);
    while (exchange != NULL)
        exchange = append_commands(frames, exchange);
    filter = ws_strdup_printf("frame.number in {%s} || sis.command_in in {%s}", frames->str, frames->str);
    g_string_free(frames, TRUE);
    return filter;
}

static char *
stream_filter(unsigned stream, unsigned sub_stream _U_)
{
    return ws_strdup_printf("sis.stream == %u", stream);
}

static char *
follow_filter(epan_dissect_t *edt _U_, packet_info *pinfo, unsigned *stream, unsigned *sub_stream)
{
    const sis_exchange_t *exchange = exchange_of(pinfo);

    if (exchange == NULL)
        return NULL;
    *stream = exchange->stream->number;
    *sub_stream = 0;
    return stream_filter(*stream, 0);
}

/* With the addresses of IP, which are not those of stations. */
static char *
follow_address_filter(address *source _U_, address *destination _U_, int source_port _U_,
                      int destination_port _U_)
{
    return NULL;
}

/* Wireshark asks for ports, which stations do not have. So the window shows "16:master", "3:slave". */
enum { MASTER_PORT, SLAVE_PORT };

static char *
port_to_display(wmem_allocator_t *allocator, unsigned port)
{
    return wmem_strdup(allocator, port == MASTER_PORT ? "master" : "slave");
}

static void
add_record(follow_info_t *follow, packet_info *pinfo, tvbuff_t *tvb, bool is_slave)
{
    unsigned length = tvb_captured_length(tvb);
    follow_record_t *record = g_new0(follow_record_t, 1);

    record->is_server = is_slave;
    record->packet_num = pinfo->num;
    record->abs_ts = pinfo->abs_ts;
    record->data = g_byte_array_append(g_byte_array_sized_new(length), tvb_get_ptr(tvb, 0, length), length);
    follow->bytes_written[is_slave] += length;
    follow->payload = g_list_prepend(follow->payload, record);
}

/* Master and slave of the window are those of its first telegram. Telegrams of other stations in the same
 * packet are left out. */
static tap_packet_status
follow_telegram(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
                tap_flags_t flags _U_)
{
    follow_info_t *follow = data;
    const sis_telegram_t *telegram = tapped;
    const sis_exchange_t *exchange = telegram->record->exchange;
    address master, slave;
    bool is_swapped;

    if (exchange == NULL)
        return TAP_PACKET_DONT_REDRAW;
    /* By the command: a reaction has the addresses of its command, but a device may swap them. */
    sis_station_address(&slave, &exchange->path[0]);
    sis_station_address(&master,
                        telegram->sender == exchange->path[0] ? &telegram->receiver : &telegram->sender);
    if (follow->payload == NULL) {
        copy_address(&follow->client_ip, &master);
        copy_address(&follow->server_ip, &slave);
        follow->client_port = MASTER_PORT;
        follow->server_port = SLAVE_PORT;
    }
    is_swapped = addresses_equal(&master, &follow->server_ip) && addresses_equal(&slave, &follow->client_ip);
    if (is_swapped ||
        (addresses_equal(&master, &follow->client_ip) && addresses_equal(&slave, &follow->server_ip)))
        add_record(follow, pinfo, telegram->tvb, telegram->is_reaction != is_swapped);
    return TAP_PACKET_DONT_REDRAW;
}

void
sis_follow_register(void)
{
    compat_register_conversation_filter("sis", "SIS exchange", has_exchange, exchange_filter);
    compat_register_conversation_filter("sis", "SIS station pair", has_stations, stations_filter);
    compat_register_follow_stream(proto_sis, "sis", follow_filter, stream_filter, follow_address_filter,
                                  port_to_display, follow_telegram, sis_stream_count);
}
