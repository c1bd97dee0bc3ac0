/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The plainest reader of serial ports there can be: the measure for sistap's.
 *
 *     reader OUTPUT PORT...
 *
 * Prints "ready" when it listens, and reads until the other end of a port closes. OUTPUT gets for each character three
 * int64_t of native byte order: the number of its port (0 the first), the character, and when it was read
 * (CLOCK_REALTIME, ns).
 */

#include <fcntl.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

enum { PORTS_MAX = 2 };

static int
take(int64_t number, int fd, FILE *out)
{
    unsigned char characters[4096];
    ssize_t length = read(fd, characters, sizeof characters);
    struct timespec now;

    clock_gettime(CLOCK_REALTIME, &now);
    for (ssize_t i = 0; i < length; i++) {
        int64_t item[] = {number, characters[i], now.tv_sec * INT64_C(1000000000) + now.tv_nsec};

        fwrite(item, sizeof item, 1, out);
    }
    return length > 0;
}

int
main(int count, char **arguments)
{
    struct pollfd ports[PORTS_MAX];
    int used = count - 2, listening = 1;
    FILE *out;

    if (used < 1 || used > PORTS_MAX || !(out = fopen(arguments[1], "wb"))) {
        fprintf(stderr, "usage: reader OUTPUT PORT [PORT]\n");
        return 2;
    }
    for (int i = 0; i < used; i++) {
        ports[i].events = POLLIN;
        if ((ports[i].fd = open(arguments[2 + i], O_RDONLY | O_NOCTTY)) < 0) {
            perror(arguments[2 + i]);
            return 3;
        }
    }
    puts("ready");
    fflush(stdout);
    while (listening && poll(ports, used, -1) > 0)
        for (int i = 0; i < used; i++)
            if (ports[i].revents && !take(i, ports[i].fd, out))
                listening = 0;
    return fclose(out) == 0 ? 0 : 1;
}
