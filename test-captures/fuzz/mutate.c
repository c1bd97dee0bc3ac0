/* SPDX-License-Identifier: GPL-2.0-or-later */
/* How one input becomes another. libFuzzer changes bytes; here the heads around them stay right, so that more
 * than heads is tried: records keep as many times and flags as characters, telegrams get their lengths and
 * checksums. */

#include <string.h>
#include <glib.h>

#include "sequence.h"

#define RECORD_HEAD      20u
#define RECORD_TYPE      2u
#define RECORD_COUNT     16u
#define TYPE_EVENT       2u
#define PER_CHARACTER    6u /* itself, four bytes of time, flags */
#define TELEGRAM_HEAD    8u
#define TELEGRAM_LONGEST (TELEGRAM_HEAD + 255u)
#define GROWTH           300u
#define PREFERENCE_BITS  26u

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed);
size_t LLVMFuzzerCustomCrossOver(const uint8_t *one, size_t one_size, const uint8_t *two, size_t two_size,
                                 uint8_t *out, size_t room, unsigned seed);

static uint64_t state;

/* A number below `end`, which is not 0 (xorshift: the seed alone decides). */
static unsigned
choose(unsigned end)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (unsigned)(state >> 32) % end;
}

static void
seed_with(unsigned seed)
{
    state = seed * UINT64_C(0x9E3779B97F4A7C15) | 1;
}

/* Length, its repetition and checksum of a telegram that is as long as there are bytes. */
static void
repair_telegram(uint8_t *bytes, uint32_t length)
{
    uint8_t sum = 0;

    if (length < TELEGRAM_HEAD)
        return;
    length = MIN(length, TELEGRAM_LONGEST);
    bytes[0] = 0x02;
    bytes[1] = 0;
    bytes[2] = bytes[3] = (uint8_t)(length - TELEGRAM_HEAD);
    for (uint32_t i = 0; i < length; i++)
        sum += bytes[i];
    bytes[1] = (uint8_t)-sum;
}

/* As many telegrams as their lengths say; the last one takes what is left. */
static void
repair_telegrams(uint8_t *bytes, uint32_t length)
{
    while (length >= TELEGRAM_HEAD) {
        uint32_t whole = TELEGRAM_HEAD + bytes[2];

        if (whole + TELEGRAM_HEAD > length)
            whole = length;
        repair_telegram(bytes, whole);
        bytes += whole;
        length -= whole;
    }
}

/* The block check of 3964R. */
static void
repair_block(uint8_t *bytes, uint32_t length)
{
    uint8_t check = 0;

    if (length < 4)
        return;
    bytes[length - 3] = 0x10;
    bytes[length - 2] = 0x03;
    for (uint32_t i = bytes[0] == 0x02; i + 1 < length; i++)
        check ^= bytes[i];
    bytes[length - 1] = check;
}

static void
repair(uint8_t road, uint8_t *bytes, uint32_t length)
{
    switch (road) {
    case ROAD_SERTAP:
    case ROAD_SIS:
    case ROAD_USER0:
        if (choose(3))
            repair_telegram(bytes, length);
        break;
    case ROAD_RTAC:
        if (choose(3) && length > 12)
            repair_telegram(bytes + 12, length - 12);
        break;
    case ROAD_TCP:
        if (choose(3))
            repair_telegrams(bytes, length);
        break;
    case ROAD_3964R:
        if (choose(2))
            repair_block(bytes, length);
        break;
    default:
        break;
    }
}

/* libFuzzer changes bytes, and may make them longer or shorter. */
static void
change_bytes(uint8_t **bytes, uint32_t *length)
{
    uint32_t more = 1 + choose(GROWTH), room = MIN(*length + more, MOST_BYTES);

    *bytes = (uint8_t *)g_realloc(*bytes, room + 1);
    *length = (uint32_t)LLVMFuzzerMutate(*bytes, MIN(*length, room), room);
}

/* A record whose count of characters is true. */
static bool
is_whole_record(const packet_t *packet)
{
    uint32_t count;

    if (packet->length < RECORD_HEAD || packet->bytes[1] != RECORD_HEAD ||
        packet->bytes[RECORD_TYPE] >= TYPE_EVENT)
        return false;
    count = (uint32_t)packet->bytes[RECORD_COUNT] << 8 | packet->bytes[RECORD_COUNT + 1];
    return packet->length == RECORD_HEAD + count * PER_CHARACTER;
}

/* New characters: the times and flags of the old ones stay, those of more are copies of the last ones. */
static void
change_characters(packet_t *packet)
{
    uint32_t old = (packet->length - RECORD_HEAD) / PER_CHARACTER, count = old;
    uint8_t *characters = (uint8_t *)g_memdup2(packet->bytes + RECORD_HEAD, old + 1);
    const uint8_t *times = packet->bytes + RECORD_HEAD + old, *flags = times + 4 * (size_t)old;
    uint8_t *made;

    change_bytes(&characters, &count);
    if (packet->bytes[11] == 1)
        repair(ROAD_3964R, characters, count);
    else
        repair(ROAD_SERTAP, characters, count);
    count = MIN(count, UINT16_MAX / 2);
    made = (uint8_t *)g_malloc0(RECORD_HEAD + count * PER_CHARACTER + 1);
    memcpy(made, packet->bytes, RECORD_HEAD);
    made[RECORD_COUNT] = (uint8_t)(count >> 8);
    made[RECORD_COUNT + 1] = (uint8_t)count;
    memcpy(made + RECORD_HEAD, characters, count);
    for (uint32_t i = 0; i < count && old > 0; i++) {
        uint32_t from = MIN(i, old - 1);

        memcpy(made + RECORD_HEAD + count + 4 * (size_t)i, times + 4 * (size_t)from, 4);
        made[RECORD_HEAD + 5 * count + i] = flags[from];
    }
    g_free(characters);
    g_free(packet->bytes);
    packet->bytes = made;
    packet->length = RECORD_HEAD + count * PER_CHARACTER;
}

/* Head, a time or flags of a record: as many bytes as before. */
static void
change_in_place(packet_t *packet)
{
    unsigned part = choose(3);
    uint32_t count = (packet->length - RECORD_HEAD) / PER_CHARACTER;
    uint32_t from = part == 0 ? 1 : RECORD_HEAD + count + (part == 1 ? 0 : 4 * count);
    uint32_t size = part == 0 ? RECORD_COUNT - 1 : part == 1 ? 4 * count : count;
    uint32_t changed, longest;

    if (size == 0)
        return;
    changed = choose(size);
    longest = 1 + choose(8);
    size = MIN(size - changed, longest);
    LLVMFuzzerMutate(packet->bytes + from + changed, size, size);
}

static void
change_packet(packet_t *packet)
{
    if (packet->road == ROAD_SERTAP && is_whole_record(packet) && choose(20)) {
        if (choose(3))
            change_characters(packet);
        else
            change_in_place(packet);
        return;
    }
    change_bytes(&packet->bytes, &packet->length);
    repair(packet->road, packet->bytes, packet->length);
}

static void
change_circumstances(packet_t *packet)
{
    static const int64_t steps[] = {
        0, 1, -1, 1000000, 25000000, 500000000, 5000000000, 3600000000000, INT64_MAX, INT64_MIN};

    switch (choose(8)) {
    case 0:
        packet->interface = (uint8_t)choose(4);
        break;
    case 3:
        packet->road = (uint8_t)choose(ROADS);
        break;
    case 4:
        packet->quirks ^= QUIRK_CUT;
        break;
    case 1:
        packet->quirks ^= (uint8_t)(1u << choose(5));
        break;
    case 2:
        packet->step = (int64_t)choose(2000000000);
        break;
    default:
        packet->step = steps[choose(G_N_ELEMENTS(steps))];
    }
}

static void
repeat_packet(sequence_t *sequence, unsigned at)
{
    unsigned times = choose(10) ? 1 + choose(3) : 1 + choose(60);

    while (times-- > 0 && sequence->packets->len < MOST_PACKETS) {
        packet_t copy = packet_copy(sequence_packet(sequence, at));

        g_array_insert_val(sequence->packets, choose(2) ? at : choose(sequence->packets->len + 1), copy);
    }
}

static void
swap_packets(sequence_t *sequence, unsigned at)
{
    packet_t *one = sequence_packet(sequence, at),
             *two = sequence_packet(sequence, choose(sequence->packets->len));
    packet_t kept = *one;

    *one = *two;
    *two = kept;
}

static void
change_sequence(sequence_t *sequence)
{
    unsigned at;

    if (sequence->packets->len == 0)
        return;
    at = choose(sequence->packets->len);
    switch (choose(16)) {
    case 0:
        repeat_packet(sequence, at);
        break;
    case 1:
        g_array_remove_index(sequence->packets, at);
        break;
    case 2:
        swap_packets(sequence, at);
        break;
    case 3:
        sequence->preferences ^= 1u << choose(PREFERENCE_BITS);
        sequence->changed =
            choose(3) ? sequence->preferences : sequence->preferences ^ 1u << choose(PREFERENCE_BITS);
        break;
    case 4:
        sequence->way ^= (uint8_t)(1u << choose(4));
        break;
    case 5:
    case 6:
        change_circumstances(sequence_packet(sequence, at));
        break;
    default:
        change_packet(sequence_packet(sequence, at));
    }
}

size_t
LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed)
{
    sequence_t sequence = sequence_read(data, size);
    unsigned times;

    seed_with(seed);
    times = choose(3) ? 1 + choose(4) : 1 + choose(24);
    while (times-- > 0)
        change_sequence(&sequence);
    size = sequence_write(&sequence, data, room);
    sequence_free(&sequence);
    return size;
}

/* Some packets of the other go in between. */
size_t
LLVMFuzzerCustomCrossOver(const uint8_t *one, size_t one_size, const uint8_t *two, size_t two_size,
                          uint8_t *out, size_t room, unsigned seed)
{
    sequence_t sequence = sequence_read(one, one_size), other = sequence_read(two, two_size);
    unsigned from, at, count;
    size_t size;

    seed_with(seed);
    from = choose(other.packets->len + 1);
    at = choose(sequence.packets->len + 1);
    count = 1 + choose(12);
    count = MIN(other.packets->len - from, count);
    for (unsigned i = 0; i < count && sequence.packets->len < MOST_PACKETS; i++) {
        packet_t copy = packet_copy(sequence_packet(&other, from + i));

        g_array_insert_val(sequence.packets, at + i, copy);
    }
    size = sequence_write(&sequence, out, room);
    sequence_free(&sequence);
    sequence_free(&other);
    return size;
}
