/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Plays one stream of characters into pseudo terminals at the pace of a serial line.
 *
 *     writer CHARACTERS INSTANTS STEP_NS FD...
 *
 * CHARACTERS has for each character two int64_t of native byte order: the character, and how long after the one before
 * it (ns). Each descriptor gets it STEP_NS after the one before, so that two readers do not wake at the same moment.
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
    int64_t step, due, character[2], written_at;
    FILE *in, *out;

    if (count < 5 || !(in = fopen(arguments[1], "rb")) || !(out = fopen(arguments[2], "wb"))) {
        fprintf(stderr, "usage: writer CHARACTERS INSTANTS STEP_NS FD...\n");
        return 2;
    }
    step = atoll(arguments[3]);
    due = now_ns(CLOCK_MONOTONIC);
    while (fread(character, sizeof character, 1, in) == 1) {
        due += character[1];
        for (int i = 4; i < count; i++) {
            int64_t later = (i - 4) * step;

            due = play(atoi(arguments[i]), (char)character[0], due + later, &written_at) - later;
            fwrite(&written_at, sizeof written_at, 1, out);
        }
    }
    return fclose(out) == 0 ? 0 : 1;
}
