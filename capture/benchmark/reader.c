/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The plainest reader of a serial port there can be: the measure for sistap's.
 *
 *     reader PORT OUTPUT
 *
 * Prints "ready" when it listens, and reads until the other end closes. OUTPUT gets for each character two int64_t of
 * native byte order: the character, and when it was read (CLOCK_REALTIME, ns).
 */

#include <fcntl.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

int
main(int count, char **arguments)
{
    struct pollfd port = {.events = POLLIN};
    unsigned char characters[4096];
    struct timespec now;
    ssize_t length;
    FILE *out;

    if (count != 3 || (port.fd = open(arguments[1], O_RDONLY | O_NOCTTY)) < 0 || !(out = fopen(arguments[2], "wb"))) {
        fprintf(stderr, "usage: reader PORT OUTPUT\n");
        return 2;
    }
    puts("ready");
    fflush(stdout);
    while (poll(&port, 1, -1) == 1 && (length = read(port.fd, characters, sizeof characters)) > 0) {
        clock_gettime(CLOCK_REALTIME, &now);
        for (ssize_t i = 0; i < length; i++) {
            int64_t item[] = {characters[i], now.tv_sec * INT64_C(1000000000) + now.tv_nsec};

            fwrite(item, sizeof item, 1, out);
        }
    }
    return fclose(out) == 0 ? 0 : 1;
}
