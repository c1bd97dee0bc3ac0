/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Relations between telegrams: command and reaction, repeats (chapter 2.4), and the same exchange on two
 * levels of a hierarchy (chapter 2.2), in the order of the capture. */
#include "sis/exchange.h"

#include <epan/conversation.h>

#include "kept.h"
#include "parts.h"
#include "sertap/line.h"
#include "sis/address.h"
#include "sis/names.h"

static wmem_map_t *buses;   /* by key */
static wmem_map_t *streams; /* by bus and both stations */

static bool
is_connection(packet_info *pinfo)
{
    return pinfo->ptype != PT_NONE;
}

/* A capture has one interface for each line; SIS over TCP or UDP has connections. */
static uint64_t
bus_key(packet_info *pinfo)
{
    const conversation_t *conversation = is_connection(pinfo) ? find_conversation_pinfo(pinfo, 0) : NULL;

    if (conversation != NULL)
        return UINT64_C(1) << 63 | conversation->conv_index;
    return sertap_bus_key(pinfo);
}

sis_bus_t *
sis_exchange_bus(packet_info *pinfo)
{
    uint64_t key = bus_key(pinfo);
    sis_bus_t *bus = kept_value(buses, &key, sizeof key, sizeof *bus);

    if (bus->number == 0) {
        bus->number = wmem_map_size(buses);
        bus->is_connection = is_connection(pinfo);
        bus->last = wmem_map_new(wmem_file_scope(), g_direct_hash, g_direct_equal);
    }
    return bus;
}

KEPT_KEY(sis_stream_key_t, 8 + 3 + 7 + 1 + 5)

static sis_stream_key_t
stream_key(const sis_bus_t *bus, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    sis_stream_key_t key = {0};

    key.bus = bus->key;
    key.low = MIN(telegram->sender, telegram->receiver);
    key.high = MAX(telegram->sender, telegram->receiver);
    key.subaddress_count = telegram->subaddress_count;
    tvb_memcpy(tvb, key.subaddresses, SIS_STATIC_LENGTH, telegram->subaddress_count);
    key.is_before = telegram->is_before;
    return key;
}

/* Of a command: the first one begins the stream. */
static sis_stream_t *
stream_of_command(sis_bus_t *bus, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    sis_stream_key_t key = stream_key(bus, tvb, telegram);
    sis_stream_t *stream = kept_value(streams, &key, sizeof key, sizeof *stream);

    if (stream->bus == NULL) {
        stream->number = wmem_map_size(streams) - 1;
        stream->bus = bus;
    }
    return stream;
}

sis_direction_t *
sis_exchange_direction(const sis_exchange_t *exchange)
{
    return &exchange->stream->from[exchange->direction];
}

/* 0 or 1: the direction of a telegram's command in its stream. */
static unsigned
command_direction(const sis_telegram_t *telegram)
{
    return telegram->sender > telegram->receiver;
}

static void
note_damaged(sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram)
{
    bool is_legible = !telegram->is_reaction && tvb_captured_length(tvb) >= telegram->body_offset;

    bus->damaged_in = pinfo->num;
    bus->damaged_count++;
    bus->damage.is_there = true;
    bus->damage.command_in = is_legible ? pinfo->num : 0;
    bus->damage.head_length = (uint8_t)telegram->body_offset;
    if (is_legible)
        tvb_memcpy(tvb, bus->damage.head, 0, telegram->body_offset);
}

/* A telegram with a damaged length is not a telegram: the tap reports it as other characters. */
static void
note_disturbance(sis_bus_t *bus, const sertap_record_t *record)
{
    sertap_disturbance_t seen = sertap_disturbance(record);

    bus->lost_in = MAX(bus->lost_in, seen.lost_in);
    if (seen.unframed_in > bus->damaged_in) {
        bus->damaged_in = seen.unframed_in;
        bus->damaged_count++;
        bus->damage.is_there = true;
        bus->damage.command_in = 0;
    }
}

/* tvb_memeql() fails for two empty ranges. */
static bool
is_equal(tvbuff_t *tvb, unsigned offset, const uint8_t *bytes, unsigned length)
{
    return length == 0 || tvb_memeql(tvb, offset, bytes, length) == 0;
}

/* The same bytes again, if the first had no good reaction; or with the same telegram number, whose
 * reaction the slave has kept. Another step of a long read has the same bytes, too, but a reaction in
 * between. */
static void
find_repeat(sis_exchange_t *exchange, sis_direction_t *from, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    sis_exchange_t *before = from->last;

    if (before == NULL || from->length != telegram->declared ||
        !is_equal(tvb, 0, from->bytes, telegram->declared))
        return;
    from->same = before->request;
    exchange->is_reaction_kept = telegram->number > 0;
    exchange->is_kept_reaction_seen = exchange->is_reaction_kept && before->reaction_in != 0;
    if (before->reaction_in != 0 && !exchange->is_reaction_kept)
        return;
    exchange->first = before->first != NULL ? before->first : before;
    before->again = exchange;
}

static sis_routing_t *
routing_of(sis_exchange_t *exchange)
{
    if (exchange->routing == NULL)
        exchange->routing = wmem_new0(wmem_file_scope(), sis_routing_t);
    return exchange->routing;
}

/* It no longer waits for a router's version. */
static void
leave_route(sis_exchange_t *exchange)
{
    if (exchange->routing != NULL)
        sis_route_leave(&exchange->routing->waiting);
}

/* A router's version of a waiting command belongs to it; a router passes a command on once. */
static void
find_route(sis_exchange_t *exchange, tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram)
{
    sis_exchange_t *above = sis_route_find(tvb, pinfo, telegram);

    if (above == NULL)
        return;
    leave_route(above);
    routing_of(exchange)->above = above;
    routing_of(above)->forwarded = exchange;
}

static int64_t
wait_since(int64_t end, const sis_times_t *times)
{
    int64_t wait = sertap_elapsed(end, times->begin);

    return sis_is_measured(wait, times) ? wait : -1;
}

/* A master sends its next command: was the one before answered, and how long did it wait (TwM, chapter 10.5)?
 */
static void
follow_command(sis_exchange_t *exchange, sis_exchange_t *before, const sis_telegram_t *telegram)
{
    const sis_exchange_t *same = sis_exchange_direction(exchange)->last;

    if (before->needs_reaction && before->reaction_in == 0) {
        before->next_command_in = exchange->command_in;
        before->is_reaction_damaged = exchange->stream->bus->damaged_in > before->command_in;
        exchange->gave_up = before->command_in;
        exchange->gave_up_station = before->path[0];
    }
    if (exchange->first != NULL)
        exchange->wait = wait_since(same->command_end, &telegram->times);
    else if (!sis_is_answered(before->station))
        exchange->wait = wait_since(before->command_end, &telegram->times);
}

/* What the commands before it are to a command of this file. */
static void
find_relations(sis_exchange_t *exchange, sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo,
               const sis_telegram_t *telegram)
{
    const void *master = GUINT_TO_POINTER(telegram->sender);
    sis_exchange_t *before = wmem_map_lookup(bus->last, master);

    find_route(exchange, tvb, pinfo, telegram);
    if (before != NULL)
        follow_command(exchange, before, telegram);
    wmem_map_insert(bus->last, master, exchange);
    bus->newest = exchange;
}

static sis_exchange_t *
begin_exchange(sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram)
{
    sis_stream_t *stream = stream_of_command(bus, tvb, telegram);
    unsigned direction = command_direction(telegram);
    sis_direction_t *from = &stream->from[direction];
    sis_exchange_t *exchange = wmem_new0(wmem_file_scope(), sis_exchange_t);

    exchange->stream = stream;
    exchange->direction = (uint8_t)direction;
    exchange->station = telegram->last_address;
    exchange->path_length = 1 + telegram->subaddress_count;
    tvb_memcpy(tvb, exchange->path, 7, exchange->path_length);
    exchange->command_in = pinfo->num;
    exchange->command_end = telegram->times.end;
    exchange->command_duration = (uint32_t)MIN(telegram->times.end - telegram->times.begin, UINT32_MAX);
    exchange->command_spread =
        telegram->times.is_bounded
            ? (uint32_t)MIN(telegram->times.end - telegram->times.end_earliest, UINT32_MAX)
            : UINT32_MAX;
    exchange->wait = -1;
    from->same = NULL;
    exchange->needs_reaction =
        sis_is_answered(telegram->last_address) && telegram->service != SIS_TOKEN_PASSING;
    if (exchange->needs_reaction)
        find_repeat(exchange, from, tvb, telegram);
    exchange->request =
        sis_request_new(wmem_file_scope(), telegram->service, from->same, exchange->first != NULL);
    if (!telegram->is_before)
        find_relations(exchange, bus, tvb, pinfo, telegram);

    if (from->last != NULL)
        leave_route(from->last);
    wmem_free(wmem_file_scope(), from->bytes);
    from->bytes = tvb_memdup(wmem_file_scope(), tvb, 0, telegram->declared);
    from->length = telegram->declared;
    from->last = exchange;
    if (telegram->subaddress_count > 0 && !telegram->is_before)
        sis_route_wait(&routing_of(exchange)->waiting, exchange, tvb, pinfo, telegram);
    return exchange;
}

/* Parameter control (without bit 2) and device address of a parameter service, as far as available. */
static bool
is_same_access(const uint8_t *command, unsigned length, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    unsigned body = telegram->body_offset; /* in a reaction the status comes first */

    if (!sis_has_control_byte(telegram->service) || body + 2 > length || body + 3 > telegram->declared)
        return true;
    return ((command[body] ^ compat_get_uint8(tvb, body + 1)) & (uint8_t)~SIS_TRANSMISSION) == 0 &&
           command[body + 1] == compat_get_uint8(tvb, body + 2);
}

/* The subservice, second byte of the useful data of a command, third of a reaction, where both have it. */
static bool
is_same_subservice(const uint8_t *command, unsigned length, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    unsigned body = telegram->body_offset;

    if (body + 2 > length || body + 3 > telegram->declared)
        return true;
    return sis_may_answer_subservice(telegram->service, command[body + 1], compat_get_uint8(tvb, body + 2));
}

/* Whether a reaction fits the last command of a direction. A reaction keeps the command's addresses; a
 * device may also swap sender and receiver. */
static bool
is_reaction_to(const uint8_t *command, unsigned length, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    unsigned rest = telegram->body_offset - SIS_STATIC_LENGTH; /* subaddresses and telegram number */
    bool is_kept = command[6] == telegram->sender && command[7] == telegram->receiver;
    bool is_swapped = command[6] == telegram->receiver && command[7] == telegram->sender;
    uint8_t layout = SIS_CONTROL_SUBADDRESSES | SIS_CONTROL_NUMBER;

    if (command[5] != telegram->service || ((command[4] ^ telegram->control) & layout) != 0)
        return false;
    if (!(is_kept || is_swapped) || !is_equal(tvb, SIS_STATIC_LENGTH, command + SIS_STATIC_LENGTH, rest))
        return false;
    return is_same_access(command, length, tvb, telegram) &&
           is_same_subservice(command, length, tvb, telegram);
}

/* It was answered or the master went on, and a damaged telegram came since. That one may have been another
 * command, so a reaction that comes now belongs to the damaged telegram. What needs no reaction, such as a
 * token (chapter 9 does not say), may have one only before the next command of any master. */
static bool
is_over(const sis_exchange_t *exchange)
{
    const sis_bus_t *bus = exchange->stream->bus;
    uint32_t end = exchange->reaction_in != 0 ? exchange->reaction_in : exchange->next_command_in;

    if (!exchange->needs_reaction && !bus->is_connection && bus->newest != exchange)
        return true;
    return end != 0 && bus->damaged_in > end;
}

/* Chapter 2.4: point to point, a slave answers a damaged command, with 0xF1, 0xF2 or 0xF4; on a bus it is
 * silent. */
static bool
is_answer_to_damage(const sis_bus_t *bus, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    uint8_t status;

    if (!bus->damage.is_there || telegram->body_offset >= telegram->declared ||
        !sis_has_status(telegram->service))
        return false;
    status = compat_get_uint8(tvb, telegram->body_offset);
    return status == 0xF1 || status == 0xF2 || status == 0xF4;
}

/* Whether the damaged command has the same service and addresses. */
static bool
has_damaged_head(const sis_damage_t *damage, tvbuff_t *tvb, const sis_telegram_t *telegram)
{
    uint8_t layout = SIS_CONTROL_SUBADDRESSES | SIS_CONTROL_NUMBER;

    return damage->command_in != 0 && damage->head_length == telegram->body_offset &&
           ((damage->head[4] ^ telegram->control) & layout) == 0 &&
           is_equal(tvb, 5, damage->head + 5, telegram->body_offset - 5);
}

/* Whether the command before went to the point-to-point address, and would fit but for that. */
static bool
is_own_number(const sis_bus_t *bus, const sis_telegram_t *telegram)
{
    const sis_exchange_t *before = wmem_map_lookup(bus->last, GUINT_TO_POINTER(telegram->sender));

    return before != NULL && before->reaction_in == 0 &&
           sis_receiver_kind(before->station) == SIS_POINT_TO_POINT &&
           sis_receiver_kind(telegram->last_address) == SIS_STATION &&
           sis_exchange_direction(before)->bytes[5] == telegram->service;
}

static void
end_exchange(sis_record_t *record, sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo,
             const sis_telegram_t *telegram)
{
    sis_stream_key_t key = stream_key(bus, tvb, telegram);
    const sis_stream_t *stream = wmem_map_lookup(streams, &key);
    unsigned kept = command_direction(telegram);

    for (unsigned i = 0; stream != NULL && i < 2; i++) {
        unsigned direction = i == 0 ? kept : !kept;
        sis_exchange_t *exchange = stream->from[direction].last;

        if (exchange == NULL ||
            !is_reaction_to(stream->from[direction].bytes, stream->from[direction].length, tvb, telegram))
            continue;
        if (is_over(exchange)) {
            if (exchange->needs_reaction)
                stream->bus->damaged_count++; /* its contents are lost, as if it were damaged, too */
            continue;
        }
        record->exchange = exchange;
        record->is_swapped = direction != kept;
        if (exchange->reaction_in != 0) {
            record->reaction_before = exchange->reaction_in;
            return;
        }
        exchange->reaction_in = pinfo->num;
        if (stream->bus->is_connection)
            exchange->next_command_in = 0; /* a master need not wait there */
        leave_route(exchange);
        exchange->has_time = exchange->command_in != pinfo->num && !telegram->is_before;
        exchange->reaction_time = sertap_elapsed(exchange->command_end, telegram->times.begin);
        exchange->is_measured = sis_is_measured(exchange->reaction_time, &telegram->times);
        if (sis_exchange_below(exchange) != NULL)
            sis_make_rare(record, 0)->routed_from = sis_exchange_below(exchange)->reaction_in;
        return;
    }
    if (is_answer_to_damage(bus, tvb, telegram))
        sis_make_rare(record, 0)->origin = SIS_TO_DAMAGED;
    else if (is_own_number(bus, telegram))
        sis_make_rare(record, 0)->origin = SIS_OWN_NUMBER;
}

void
sis_exchange_learn(sis_record_t *record, sis_bus_t *bus, tvbuff_t *tvb, packet_info *pinfo,
                   const sis_telegram_t *telegram)
{
    const sertap_record_t *tap = sertap_record(pinfo);

    if (tap != NULL)
        note_disturbance(bus, tap);
    if (!telegram->is_good) {
        if (!telegram->is_before)
            note_damaged(bus, tvb, pinfo, telegram);
        return;
    }
    if (!telegram->is_reaction) {
        record->exchange = begin_exchange(bus, tvb, pinfo, telegram);
    } else if (is_answer_to_damage(bus, tvb, telegram) && has_damaged_head(&bus->damage, tvb, telegram)) {
        sis_make_rare(record, 0)->origin = SIS_TO_DAMAGED;
        sis_make_rare(record, 0)->damaged_in = bus->damage.command_in;
        bus->damaged_count--; /* it was not executed, so its damage has cost nothing */
    } else {
        end_exchange(record, bus, tvb, pinfo, telegram);
    }
    bus->damage.is_there &= telegram->is_before;
}

void
sis_exchange_register(void)
{
    buses = kept_map_of_numbers();
    streams = kept_map(hash_sis_stream_key_t, are_equal_sis_stream_key_t);
}
