/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Wireshark's tools that follow related packets: conversation filters for an exchange and for two
 * stations, and Follow for a stream (`tshark -z follow,sis,hex,0`; in Wireshark's menus from 4.4 on). */
#include "parts.h"

#include <epan/conversation_filter.h>
#include <epan/follow.h>
#include <epan/tap.h>

#include "sis/address.h"
#include "sis/exchange.h"

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

#define MOST_REACTIONS 100 /* of one command and its repeats that a filter lists */

/* The frames that a filter for an exchange names. */
typedef struct {
    const sis_exchange_t *chosen; /* the exchange of the packet */
    GString *first;               /* the first of the same commands, on each level of a hierarchy */
    GString *answered;            /* these, and their repeats that have a reaction */
} frames_t;

static void
append_frame(GString *frames, uint32_t frame)
{
    g_string_append_printf(frames, "%s%u", frames->len > 0 ? ", " : "", frame);
}

/* Appends a command and its repeats; returns what the next router made of it, NULL: nothing. sis.repeat_of
 * finds the repeats. A master may ask an absent station for days, so the filter does not list them. */
static const sis_exchange_t *
append_commands(const frames_t *frames, const sis_exchange_t *exchange)
{
    const sis_exchange_t *forwarded = NULL;
    unsigned room = MOST_REACTIONS;

    if (exchange->first != NULL)
        exchange = exchange->first;
    append_frame(frames->first, exchange->command_in);
    append_frame(frames->answered, exchange->command_in);
    for (; exchange != NULL; exchange = exchange->again) {
        if (exchange->first != NULL && exchange->reaction_in != 0 &&
            (room > 0 || exchange == frames->chosen)) {
            append_frame(frames->answered, exchange->command_in);
            room -= room > 0;
        }
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
    frames_t frames = {exchange, g_string_new(""), g_string_new("")};
    char *filter;

    while (sis_exchange_above(exchange) != NULL)
        exchange = sis_exchange_above(exchange);
    while (exchange != NULL)
        exchange = append_commands(&frames, exchange);
    filter = ws_strdup_printf("frame.number in {%s} || sis.repeat_of in {%s} || sis.command_in in {%s}",
                              frames.first->str, frames.first->str, frames.answered->str);
    g_string_free(frames.first, TRUE);
    g_string_free(frames.answered, TRUE);
    return filter;
}

/* The stream asked for last. Wireshark does not tell follow_telegram() which stream it is to follow. */
static unsigned asked_stream;

static char *
stream_filter(unsigned stream, unsigned sub_stream _U_)
{
    asked_stream = stream;
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
add_record(follow_info_t *follow, packet_info *pinfo, const sis_telegram_t *telegram, bool is_slave)
{
    follow_record_t *record = g_new0(follow_record_t, 1);

    record->is_server = is_slave;
    record->packet_num = pinfo->num;
    record->abs_ts = pinfo->abs_ts;
    record->data =
        g_byte_array_append(g_byte_array_sized_new(telegram->length),
                            tvb_get_ptr(telegram->tvb, 0, (int)telegram->length), telegram->length);
    follow->bytes_written[is_slave] += telegram->length;
    follow->payload = g_list_prepend(follow->payload, record);
}

/* Whether a telegram of that stream is in the packet. */
static bool
is_stream_in(packet_info *pinfo, unsigned stream)
{
    for (const sis_telegram_t *telegram = sis_packet(pinfo)->last; telegram != NULL;
         telegram = telegram->before) {
        if (telegram->record->exchange != NULL && telegram->record->exchange->stream->number == stream)
            return true;
    }
    return false;
}

/* By the command: a reaction has the addresses of its command, but a device may swap them. */
static void
find_stations(const sis_telegram_t *telegram, address *master, address *slave)
{
    const uint8_t *receiver = &telegram->record->exchange->path[0];

    sis_station_address(slave, receiver);
    sis_station_address(master, telegram->sender == *receiver ? &telegram->receiver : &telegram->sender);
}

/* The first telegram decides which stream is followed, and which station is the window's master. If its
 * packet has several streams, the one asked for. */
static bool
begin_follow(follow_info_t *follow, packet_info *pinfo, const sis_telegram_t *telegram)
{
    unsigned stream = telegram->record->exchange->stream->number;
    address master, slave;

    if (stream != asked_stream && is_stream_in(pinfo, asked_stream))
        return false;
    find_stations(telegram, &master, &slave);
    copy_address(&follow->client_ip, &master);
    copy_address(&follow->server_ip, &slave);
    follow->client_port = MASTER_PORT;
    follow->server_port = SLAVE_PORT;
    follow->substream_id = stream; /* nobody else uses it here */
    return true;
}

/* Telegrams of other streams in the same packet are left out. */
static tap_packet_status
follow_telegram(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
                tap_flags_t flags _U_)
{
    follow_info_t *follow = data;
    const sis_telegram_t *telegram = tapped;
    const sis_exchange_t *exchange = telegram->record->exchange;
    address master, slave;

    if (exchange == NULL || (follow->payload == NULL && !begin_follow(follow, pinfo, telegram)) ||
        exchange->stream->number != follow->substream_id)
        return TAP_PACKET_DONT_REDRAW;
    find_stations(telegram, &master, &slave);
    add_record(follow, pinfo, telegram, telegram->is_reaction == addresses_equal(&slave, &follow->server_ip));
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
