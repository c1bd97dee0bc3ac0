/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Plays one stream of characters into two pseudo terminals at the pace of a serial line.
 *
 *     writer DATA TIMES FD_A FD_B CHARACTER_NS
 *
 * The second gets each character half a character time after the first, so that two readers do not wake at the same
 * moment. Waits by turning, not sleeping: a sleep is late by about a character. TIMES gets for each character two
 * int64_t of native byte order: the instants just before it was written to A and to B (CLOCK_REALTIME, ns).
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
    int64_t half, due, written_at[2];
    FILE *data, *out;
    int character;

    if (count != 6 || !(data = fopen(arguments[1], "rb")) || !(out = fopen(arguments[2], "wb"))) {
        fprintf(stderr, "usage: writer DATA TIMES FD_A FD_B CHARACTER_NS\n");
        return 2;
    }
    half = atoll(arguments[5]) / 2;
    due = now_ns(CLOCK_MONOTONIC);
    while ((character = getc(data)) != EOF) {
        for (int i = 0; i < 2; i++)
            due = play(atoi(arguments[3 + i]), (char)character, due, &written_at[i]) + half;
        fwrite(written_at, sizeof written_at, 1, out);
    }
    return fclose(out) == 0 ? 0 : 1;
}
