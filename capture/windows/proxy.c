/* SPDX-License-Identifier: GPL-2.0-or-later */
/* tshark.exe of capture/windows/check: hands its name, folder, environment, arguments and standard input to proxy.py, on
 * the port that PROXY_PORT names, and passes on what comes back. Built once, and copied for each program of Wireshark.
 *
 * To there: a length, then cwd, each variable, an empty text, program and arguments (UTF-8, each with its 0); then pieces
 * of standard input, each behind its length, an empty one for its end. From there: a kind (1 and 2: stdout and stderr,
 * 3: the exit code), a length, and so many bytes. Lengths have 4 bytes, low byte first.
 */
#include <winsock2.h>
#include <windows.h>
#include <shellapi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TO_STDOUT = 1, TO_STDERR = 2, EXIT_CODE = 3, PIECE = 65536, LARGEST = 1 << 20 };

static void fail(const char *what)
{
    fprintf(stderr, "proxy: %s\n", what);
    exit(127);
}

static SOCKET dial(void)
{
    const char *port = getenv("PROXY_PORT");
    struct sockaddr_in address = {.sin_family = AF_INET};
    WSADATA data;
    SOCKET server;

    WSAStartup(MAKEWORD(2, 2), &data);
    server = socket(AF_INET, SOCK_STREAM, 0);
    address.sin_port = htons((u_short)atoi(port ? port : "0"));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(server, (struct sockaddr *)&address, sizeof address) != 0)
        fail("capture/windows/check does not run");
    return server;
}

static int send_piece(SOCKET server, const char *bytes, DWORD count)
{
    return send(server, (const char *)&count, sizeof count, 0) == sizeof count &&
           send(server, bytes, (int)count, 0) == (int)count;
}

static int receive(SOCKET server, void *bytes, DWORD count)
{
    char *at = bytes;
    int came = 1;

    for (; count > 0 && came > 0; at += came, count -= (DWORD)came)
        came = recv(server, at, (int)count, 0);
    return came > 0;
}

/* Appends a text with its 0, in UTF-8; returns where the next one goes. */
static char *put(char *at, const char *end, const wchar_t *text)
{
    int count = WideCharToMultiByte(CP_UTF8, 0, text, -1, at, (int)(end - at), NULL, NULL);

    if (count == 0)
        fail("too many arguments");
    return at + count;
}

static void ask(SOCKET server)
{
    static char question[LARGEST];
    const char *end = question + sizeof question;
    wchar_t folder[MAX_PATH], **words;
    char *at = question;
    int count;

    GetCurrentDirectoryW(MAX_PATH, folder);
    at = put(at, end, folder);
    for (const wchar_t *variable = GetEnvironmentStringsW(); *variable; variable += wcslen(variable) + 1)
        at = put(at, end, variable);
    at = put(at, end, L"");
    words = CommandLineToArgvW(GetCommandLineW(), &count);
    for (int i = 0; i < count; i++)
        at = put(at, end, words[i]);
    if (!send_piece(server, question, (DWORD)(at - question)))
        fail("the question was not taken");
}

static DWORD WINAPI pass_input_on(void *context)
{
    static char piece[PIECE];
    SOCKET server = *(SOCKET *)context;
    DWORD count;

    while (ReadFile(GetStdHandle(STD_INPUT_HANDLE), piece, sizeof piece, &count, NULL) && count > 0)
        if (!send_piece(server, piece, count))
            return 1;
    return !send_piece(server, "", 0);
}

static int pass_output_on(SOCKET server)
{
    static char piece[PIECE];
    unsigned char kind;
    DWORD rest, count, written, code;
    HANDLE stream;

    while (receive(server, &kind, 1) && receive(server, &rest, sizeof rest)) {
        if (kind == EXIT_CODE)
            return receive(server, &code, sizeof code) ? (int)code : 127;
        stream = GetStdHandle(kind == TO_STDERR ? STD_ERROR_HANDLE : STD_OUTPUT_HANDLE);
        for (; rest > 0; rest -= count) {
            count = rest < PIECE ? rest : PIECE;
            if (!receive(server, piece, count) || !WriteFile(stream, piece, count, &written, NULL))
                return 127;
        }
    }
    return 127;
}

int main(void)
{
    SOCKET server = dial();

    ask(server);
    CreateThread(NULL, 0, pass_input_on, &server, 0, NULL);
    ExitProcess((UINT)pass_output_on(server));
}
