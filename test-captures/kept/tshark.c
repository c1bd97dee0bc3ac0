/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A tshark for the tests that starts at once: it asks one that has registered its protocols already
 * (library.c), and starts that if there is none. What depends on how tshark starts has the real one.
 */

#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "kept.h"

#ifndef REAL
#define REAL "/usr/bin/tshark"
#endif

static uint64_t key = 14695981039346656037u; /* FNV-1a, of all that tshark reads while it starts */
static int talking;

static void
add(const void *bytes, size_t length)
{
    const unsigned char *byte = bytes;
    uint64_t word;
    for (; length >= sizeof word; length -= sizeof word, byte += sizeof word) {
        memcpy(&word, byte, sizeof word);
        key = (key ^ word) * 1099511628211u;
        key ^= key >> 29;
    }
    for (; length > 0; length--)
        key = (key ^ *byte++) * 1099511628211u;
}

static void
add_text(const char *text)
{
    add(text, strlen(text) + 1);
}

static int
add_file(const char *path, const struct stat *about, int type, struct FTW *place)
{
    (void)type;
    if (!S_ISREG(about->st_mode) || about->st_size == 0)
        return 0;
    add_text(path + place->base);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    void *bytes = file < 0 ? MAP_FAILED : mmap(NULL, (size_t)about->st_size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED)
        return 1;
    add(bytes, (size_t)about->st_size);
    munmap(bytes, (size_t)about->st_size);
    return close(file);
}

static bool
is_there(const char *path, const char *folder)
{
    char full[4096];
    return folder && snprintf(full, sizeof full, path, folder) > 0 && access(full, F_OK) == 0;
}

/* Only what reads a file, with no other end than its own: no pipe, script, list of what there is, limit,
 * settings or personal plugins, which are read while it starts. */
static bool
can_be_kept(char **arguments)
{
    bool reads = false;
    for (char **argument = arguments + 1; *argument; argument++) {
        if (strcmp(*argument, "-r") == 0)
            reads = argument[1] && strcmp(argument[1], "-") != 0;
        if (strncmp(*argument, "-X", 2) == 0 || strncmp(*argument, "-G", 2) == 0 ||
            strcmp(*argument, "-v") == 0)
            return false;
    }
    struct stat output;
    if (fstat(1, &output) != 0 ||
        S_ISCHR(output.st_mode)) /* /dev/null: what it needs is measured, see Tshark.usage */
        return false;
    static const int limits[] = {RLIMIT_AS, RLIMIT_CPU, RLIMIT_FSIZE, RLIMIT_DATA};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        struct rlimit limit;
        if (getrlimit(limits[i], &limit) != 0 || limit.rlim_cur != RLIM_INFINITY)
            return false;
    }
    return reads && !is_there("%s/wireshark", getenv("XDG_CONFIG_HOME")) &&
           !is_there("%s/.config/wireshark", getenv("HOME")) && !is_there("%s/.wireshark", getenv("HOME")) &&
           !is_there("%s/.local/lib/wireshark", getenv("HOME")) && !getenv("WIRESHARK_CONFIG_DIR");
}

static socklen_t
address(struct sockaddr_un *name)
{
    const char *plugins = getenv("WIRESHARK_PLUGIN_DIR"), *data = getenv("WIRESHARK_DATA_DIR");
    uid_t user = geteuid();
    add(&user, sizeof user);
    add_text(REAL);
    add_text(data ? data : "");
    add_text(getenv("KEPT_TSHARK"));
    add_text(getenv("GLIBC_TUNABLES") ? getenv("GLIBC_TUNABLES") : "");
    if (plugins)
        add_text("plugins");
    if (plugins && nftw(plugins, add_file, 8, FTW_PHYS) != 0)
        return 0;
    *name = (struct sockaddr_un){.sun_family = AF_UNIX};
    int length = snprintf(name->sun_path + 1, sizeof name->sun_path - 1, "kept-tshark-%016llx",
                          (unsigned long long)key);
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length);
}

/* Start one that listens; if another process is quicker, that is as good. */
static void
start(const struct sockaddr_un *name, socklen_t length, const char *library)
{
    int listening = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    if (bind(listening, (const struct sockaddr *)name, length) != 0 || listen(listening, 64) != 0) {
        close(listening);
        return;
    }
    if (fork() == 0) {
        setsid();
        if (fork() != 0)
            _exit(0);
        dup2(listening, 3);
        dup2(open("/dev/null", O_RDWR), 0);
        dup2(0, 1);
        dup2(memfd_create("said", 0), 2); /* one that says something while it starts is not kept */
        closefrom(4);
        setenv("LD_PRELOAD", library, 1);
        if (chdir("/") == 0)
            execl(REAL, "tshark", (char *)NULL);
        _exit(127);
    }
    wait(NULL);
    close(listening);
}

/* Append words with their zeros. Returns the new length: more than there is room, if there is none. */
static size_t
pack(char *bytes, size_t length, char **words)
{
    for (; *words && length <= KEPT_BYTES; words++) {
        size_t size = strlen(*words) + 1;
        if (length + size <= KEPT_BYTES)
            memcpy(bytes + length, *words, size);
        length += size;
    }
    return length;
}

static bool
ask(int connection, int count, char **arguments)
{
    static char bytes[KEPT_BYTES];
    size_t length = pack(bytes, pack(bytes, sizeof count, arguments), environ);
    if (length > sizeof bytes)
        return false;
    memcpy(bytes, &count, sizeof count);
    int fds[KEPT_FDS] = {0, 1, 2, open(".", O_PATH | O_CLOEXEC)};
    char control[CMSG_SPACE(sizeof fds)];
    struct iovec part = {bytes, length};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    struct cmsghdr *header = CMSG_FIRSTHDR(&message);
    *header =
        (struct cmsghdr){.cmsg_len = CMSG_LEN(sizeof fds), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS};
    memcpy(CMSG_DATA(header), fds, sizeof fds);
    return sendmsg(connection, &message, MSG_NOSIGNAL) == (ssize_t)length;
}

static void
pass_on(int number)
{
    unsigned char byte = (unsigned char)number;
    send(talking, &byte, 1, MSG_NOSIGNAL);
}

/* Return a connection to the kept tshark, or -1. */
static int
connected(const char *library)
{
    struct sockaddr_un name;
    socklen_t length = address(&name);
    int connection = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (length > 0 && connect(connection, (struct sockaddr *)&name, length) == 0)
        return connection;
    if (length > 0)
        start(&name, length, library);
    return length > 0 && connect(connection, (struct sockaddr *)&name, length) == 0 ? connection : -1;
}

int
main(int argc, char **argv)
{
    const char *library = getenv("KEPT_TSHARK");
    int status;
    if (library && can_be_kept(argv) && (talking = connected(library)) >= 0 && ask(talking, argc, argv)) {
        signal(SIGINT, pass_on);
        signal(SIGTERM, pass_on);
        if (TEMP_FAILURE_RETRY(recv(talking, &status, sizeof status, 0)) == sizeof status) {
            if (!WIFSIGNALED(status))
                return WEXITSTATUS(status);
            signal(WTERMSIG(status), SIG_DFL);
            raise(WTERMSIG(status));
        }
    }
    execv(REAL, argv);
    return 127;
}
