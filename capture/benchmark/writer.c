/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Plays one stream of characters into pseudo terminals at the pace of a serial line.
 *
 *     writer CHARACTERS INSTANTS INTERVAL_NS STEP_NS FD...
 *
 * Each descriptor gets a character STEP_NS after the one before, so that two readers do not wake at the same moment.
 * Waits by turning, not sleeping: a sleep is late by about a character. INSTANTS gets for each character an int64_t a
 * descriptor: just before it was written there (CLOCK_REALTIME, ns).
 */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static int64_t
now_ns(clockid_t clock)
{
    struct timespec now;

    clock_gettime(clock, &now);
    return now.tv_sec * INT64_C(1000000000) + now.tv_nsec;
}

/* Waits until `due` of the monotonic clock and writes. Gives when that was: a line never sends faster than its rate, so
 * after a delay of this process everything that follows is delayed, too. */
static int64_t
play(int fd, char character, int64_t due, int64_t *written_at)
{
    int64_t now;

    while ((now = now_ns(CLOCK_MONOTONIC)) < due)
        ;
    *written_at = now_ns(CLOCK_REALTIME);
    if (write(fd, &character, 1) != 1) {
        perror("writer");
        exit(1);
    }
    return now;
}

int
main(int count, char **arguments)
{
    int64_t interval, step, due, written_at;
    int character;
    FILE *in, *out;

    if (count < 6 || !(in = fopen(arguments[1], "rb")) || !(out = fopen(arguments[2], "wb"))) {
        fprintf(stderr, "usage: writer CHARACTERS INSTANTS INTERVAL_NS STEP_NS FD...\n");
        return 2;
    }
    interval = atoll(arguments[3]);
    step = atoll(arguments[4]);
    due = now_ns(CLOCK_MONOTONIC);
    while ((character = getc(in)) != EOF) {
        due += interval;
        for (int i = 5; i < count; i++) {
            int64_t later = (i - 5) * step;

            due = play(atoi(arguments[i]), (char)character, due + later, &written_at) - later;
            fwrite(&written_at, sizeof written_at, 1, out);
        }
    }
    return fclose(out) == 0 ? 0 : 1;
}
