/* SPDX-License-Identifier: GPL-2.0-or-later */
/* *Conversation Filter*: for an exchange, and for two stations. */
#include "parts.h"

#include <epan/conversation_filter.h>

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

void
windows_filters_register(void)
{
    compat_register_conversation_filter("sis", "SIS exchange", has_exchange, exchange_filter);
    compat_register_conversation_filter("sis", "SIS station pair", has_stations, stations_filter);
}
