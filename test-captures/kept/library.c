/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Keeps a tshark that has registered all protocols; each request is a fork of it, in which main begins anew.
 *
 * For LD_PRELOAD. The socket to listen at is descriptor 3. tshark.c starts it and asks it.
 */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "kept.h"

enum { LISTENING = 3, MOST = 64, IDLE_MS = 60000 };

typedef int (*main_t)(int, char **, char **);

static main_t program;
static int is_kept;
extern void set_persconffile_dir(const char *) __attribute__((weak));

static char bytes[KEPT_BYTES]; /* the newest request */

/* Receive a request with its descriptors. Returns its length. */
static ssize_t
receive(int connection, int *fds)
{
    char control[CMSG_SPACE(KEPT_FDS * sizeof *fds)];
    struct iovec part = {bytes, sizeof bytes};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    ssize_t length = recvmsg(connection, &message, MSG_CMSG_CLOEXEC);
    struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    if (length <= (ssize_t)sizeof(int) || header == NULL ||
        header->cmsg_len != CMSG_LEN(KEPT_FDS * sizeof *fds))
        return 0;
    memcpy(fds, CMSG_DATA(header), KEPT_FDS * sizeof *fds);
    return length;
}

/* In the fork: be the tshark that was asked for. */
static void
serve(ssize_t length, const int *fds)
{
    static char *arguments[KEPT_BYTES / 2];
    for (int i = 0; i < 3; i++)
        dup2(fds[i], i);
    if (fchdir(fds[3]) != 0)
        _exit(125);
    closefrom(3);

    int count, number = 0;
    memcpy(&count, bytes, sizeof count);
    clearenv();
    for (char *word = bytes + sizeof count; word < bytes + length; word += strlen(word) + 1, number++) {
        if (number < count)
            arguments[number] = word;
        else
            putenv(word);
    }

    char folder[4096]; /* of the profile, which Wireshark has looked for already */
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    snprintf(folder, sizeof folder, config ? "%s/wireshark" : "%s/.config/wireshark",
             config ? config
             : home ? home
                    : "");
    set_persconffile_dir(folder);
    tzset();
    exit(program(count, arguments, environ));
}

/* One that runs: its connection and its process. */
static struct pollfd polled[1 + 2 * MOST] = {{LISTENING, POLLIN, 0}};
static pid_t processes[MOST];
static int running;

static void
begin(void)
{
    int fds[KEPT_FDS], connection = accept4(LISTENING, NULL, NULL, SOCK_CLOEXEC);
    ssize_t length = connection < 0 ? 0 : receive(connection, fds);
    if (length == 0) {
        close(connection);
        return;
    }
    pid_t child = fork();
    if (child == 0)
        serve(length, fds);
    for (int i = 0; i < KEPT_FDS; i++)
        close(fds[i]);
    processes[running] = child;
    polled[1 + 2 * running] = (struct pollfd){connection, POLLIN, 0};
    polled[2 + 2 * running] = (struct pollfd){(int)syscall(SYS_pidfd_open, child, 0), POLLIN, 0};
    running++;
}

static void
end(int index)
{
    struct pollfd *connection = &polled[1 + 2 * index], *process = connection + 1;
    int status;
    waitpid(processes[index], &status, 0);
    send(connection->fd, &status, sizeof status, MSG_NOSIGNAL);
    close(connection->fd);
    close(process->fd);
    running--;
    processes[index] = processes[running];
    *connection = polled[1 + 2 * running];
    *process = polled[2 + 2 * running];
}

/* Pass a signal on; whose asker has gone, is killed. */
static void
pass_on(int index)
{
    unsigned char number;
    bool gone = recv(polled[1 + 2 * index].fd, &number, 1, 0) <= 0;
    kill(processes[index], gone ? SIGKILL : number);
    if (gone)
        polled[1 + 2 * index].fd = -1;
}

static void
keep(void)
{
    while (poll(polled, 1 + 2 * (nfds_t)running, IDLE_MS) != 0 || running > 0) {
        for (int i = running - 1; i >= 0; i--) {
            if (polled[1 + 2 * i].revents)
                pass_on(i);
            if (polled[2 + 2 * i].revents)
                end(i);
        }
        if (polled[0].revents && running < MOST)
            begin();
    }
    _exit(0);
}

/* The two that a second main must not call again. Their arguments differ between versions of Wireshark. */
typedef int (*start_t)(long, long, long, long);

int
wtap_init(long a, long b, long c, long d)
{
    return is_kept ? 0 : ((start_t)dlsym(RTLD_NEXT, "wtap_init"))(a, b, c, d);
}

int
epan_init(long a, long b, long c, long d)
{
    if (is_kept)
        return 1;
    if (!((start_t)dlsym(RTLD_NEXT, "epan_init"))(a, b, c, d))
        return 0;
    is_kept = 1;
    if (lseek(2, 0, SEEK_CUR) > 0) /* the askers start the real one, which says it to them */
        _exit(0);
    keep();
    return 1;
}

/* Frees what registering has made, page after page of it copied before. */
void
epan_cleanup(void)
{
}

int
__libc_start_main(main_t main, int argc, char **argv, void (*init)(void), void (*fini)(void),
                  void (*rtld_fini)(void), void *stack_end)
{
    typedef int (*function)(main_t, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);
    program = main;
    return ((function)dlsym(RTLD_NEXT, "__libc_start_main"))(main, argc, argv, init, fini, rtld_fini,
                                                             stack_end);
}
