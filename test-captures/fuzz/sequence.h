/* SPDX-License-Identifier: GPL-2.0-or-later */
/* An input of the fuzzer: packets that are dissected one after the other in one capture, and how. */

#ifndef FUZZ_SEQUENCE_H
#define FUZZ_SEQUENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <glib.h>

#define MOST_PACKETS 400u
#define MOST_BYTES   300000u /* of a packet: Wireshark refuses longer ones than 262,144 bytes in a file */

/* By which way a packet comes to the plugin. corpus.py has the same list. */
typedef enum {
    ROAD_SERTAP,
    ROAD_SIS,
    ROAD_3964R,
    ROAD_RK512I,
    ROAD_ARCNET7F,
    ROAD_SYNAXPK,
    ROAD_SYNAXPCP,
    ROAD_SYNAXPD, /* to here: link type 252, the dissector by its name */
    ROAD_USER0,
    ROAD_RTAC,
    ROAD_TCP,
    ROADS
} road_t;

/* What is unusual about a packet. */
enum {
    QUIRK_CUT = 0x01,     /* the capture has only two thirds of it */
    QUIRK_SECONDS = 0x02, /* its step in time counts seconds, not ns: years that no file has */
    QUIRK_LOST = 0x04,    /* a TCP segment before it is missing */
    QUIRK_AGAIN = 0x08,   /* TCP repeats some bytes */
    QUIRK_SECTION = 0x10, /* a new section of the file begins */
};

/* In which order the packets are dissected. */
enum {
    WAY_TREE_FIRST = 0x01, /* the first pass makes trees, too */
    WAY_TAPS_FIRST = 0x02, /* the first pass feeds the statistics: a live capture in Wireshark */
    WAY_BACKWARDS = 0x04,  /* the second pass: a user who clicks on packets from the last to the first */
    WAY_ONCE = 0x08,       /* no second pass: tshark without -2 */
};

typedef struct {
    uint8_t road;
    uint8_t interface;
    uint8_t quirks;
    int64_t step; /* since the packet before it */
    uint32_t length;
    uint8_t *bytes;
} packet_t;

typedef struct {
    uint32_t preferences; /* two bits each, in the order of preferences.c */
    uint32_t changed;     /* what they are changed to, while all is still in memory */
    uint8_t way;
    GArray *packets; /* packet_t */
} sequence_t;

/* Always a sequence: bytes that are none begin an empty one, and a cut one ends before the cut. */
sequence_t sequence_read(const uint8_t *data, size_t size);

/* How many bytes were written: whole packets, as many as there is room for. */
size_t sequence_write(const sequence_t *sequence, uint8_t *data, size_t room);
void sequence_free(sequence_t *sequence);
packet_t *sequence_packet(const sequence_t *sequence, unsigned number);
packet_t packet_copy(const packet_t *packet);

#endif
