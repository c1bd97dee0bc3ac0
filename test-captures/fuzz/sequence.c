/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A sequence as bytes, all numbers in the order of this machine (corpus.py: little-endian):
 * preferences (4), changed preferences (4), way (1); then for each packet
 * road (1), interface (1), quirks (1), step (8), length (4), its bytes. */

#include "sequence.h"

#include <string.h>

#define HEAD_SIZE   9u
#define PACKET_SIZE 15u

static void
packet_clear(void *packet)
{
    g_free(((packet_t *)packet)->bytes);
}

packet_t *
sequence_packet(const sequence_t *sequence, unsigned number)
{
    return &g_array_index(sequence->packets, packet_t, number);
}

packet_t
packet_copy(const packet_t *packet)
{
    packet_t copy = *packet;

    copy.bytes = (uint8_t *)g_malloc(packet->length + 1);
    memcpy(copy.bytes, packet->bytes, packet->length);
    return copy;
}

/* Bytes of a packet with its head, 0 where it is cut. */
static size_t
packet_read(packet_t *packet, const uint8_t *data, size_t size)
{
    packet_t found = {0};

    if (size < PACKET_SIZE)
        return 0;
    found.road = data[0] % ROADS;
    found.interface = data[1];
    found.quirks = data[2];
    memcpy(&found.step, data + 3, sizeof found.step);
    memcpy(&found.length, data + 11, sizeof found.length);
    if (found.length > MOST_BYTES || found.length > size - PACKET_SIZE)
        return 0;
    found.bytes = (uint8_t *)data + PACKET_SIZE;
    *packet = packet_copy(&found);
    return PACKET_SIZE + found.length;
}

sequence_t
sequence_read(const uint8_t *data, size_t size)
{
    sequence_t sequence = {.packets = g_array_new(FALSE, FALSE, sizeof(packet_t))};
    packet_t packet;
    size_t at = HEAD_SIZE, taken;

    g_array_set_clear_func(sequence.packets, packet_clear);
    if (size < HEAD_SIZE)
        return sequence;
    memcpy(&sequence.preferences, data, 4);
    memcpy(&sequence.changed, data + 4, 4);
    sequence.way = data[8];
    while (sequence.packets->len < MOST_PACKETS && (taken = packet_read(&packet, data + at, size - at)) > 0) {
        g_array_append_val(sequence.packets, packet);
        at += taken;
    }
    return sequence;
}

size_t
sequence_write(const sequence_t *sequence, uint8_t *data, size_t room)
{
    size_t at = HEAD_SIZE;

    if (room < HEAD_SIZE)
        return 0;
    memcpy(data, &sequence->preferences, 4);
    memcpy(data + 4, &sequence->changed, 4);
    data[8] = sequence->way;
    for (unsigned i = 0; i < sequence->packets->len; i++) {
        const packet_t *packet = sequence_packet(sequence, i);

        if (room - at < PACKET_SIZE + packet->length)
            break;
        data[at] = packet->road;
        data[at + 1] = packet->interface;
        data[at + 2] = packet->quirks;
        memcpy(data + at + 3, &packet->step, sizeof packet->step);
        memcpy(data + at + 11, &packet->length, sizeof packet->length);
        memcpy(data + at + PACKET_SIZE, packet->bytes, packet->length);
        at += PACKET_SIZE + packet->length;
    }
    return at;
}

void
sequence_free(sequence_t *sequence)
{
    g_array_free(sequence->packets, TRUE);
}
