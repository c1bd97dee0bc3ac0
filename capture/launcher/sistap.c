/* SPDX-License-Identifier: GPL-2.0-or-later */
/* sistap.exe: starts `python -P -X utf8 -m sistap extcap` with the arguments with which Wireshark has started it. With
 * COMMAND empty it is the command `sistap`. Wireshark reads UTF-8, whatever the code page is.
 *
 * A .bat cannot: cmd.exe cuts a capture filter such as link[5]==0x10&&link[6]==16 at &&, and drops what stands between
 * two % signs. Which Python, and where the package is, say the two lines of sistap.cfg beside it (UTF-8); without it,
 * python\python.exe and the package in its own folder.
 */
#include <stdio.h>
#include <windows.h>

#include "tail.h"

/* What Python is told before the arguments. */
#ifndef COMMAND
#define COMMAND L"extcap "
#endif

enum { LONGEST = 32767 }; /* characters of a command line, and of a path */

static int fail(const char *what, const wchar_t *which)
{
    static char path[4 * LONGEST]; /* in UTF-8: printf stops at a letter that the code page lacks */

    WideCharToMultiByte(CP_UTF8, 0, which, -1, path, sizeof path, NULL, NULL);
    fprintf(stderr, "sistap: %s %s: run `sistap install` again\n", what, path);
    return 1;
}

/* Ctrl-C is for Python, which ends when it has saved everything; this waits for it. */
static BOOL WINAPI go_on(DWORD event)
{
    (void)event;
    return TRUE;
}

/* The folder of this program, with the backslash. */
static int own_folder(wchar_t *folder)
{
    DWORD length = GetModuleFileNameW(NULL, folder, LONGEST);

    if (length == 0 || length >= LONGEST)
        return 0;
    wcsrchr(folder, L'\\')[1] = 0;
    return 1;
}

/* Reads sistap.cfg; 0 if it is not there. */
static int read_settings(const wchar_t *file, wchar_t *text)
{
    char bytes[2 * MAX_PATH * 4];
    DWORD count = 0;
    HANDLE handle = CreateFileW(file, GENERIC_READ, FILE_SHARE_READ, NULL, OPEN_EXISTING, 0, NULL);

    if (handle == INVALID_HANDLE_VALUE)
        return 0;
    ReadFile(handle, bytes, sizeof bytes, &count, NULL);
    CloseHandle(handle);
    count = count ? (DWORD)MultiByteToWideChar(CP_UTF8, 0, bytes, (int)count, text, LONGEST - 1) : 0;
    text[count] = 0;
    return count > 0;
}

/* Lets the child end with this process, however that ends. */
static void end_together(HANDLE child)
{
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits = {0};
    HANDLE job = CreateJobObjectW(NULL, NULL);

    limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
    SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
    AssignProcessToJobObject(job, child);
}

static void pass_streams_on(STARTUPINFOW *start)
{
    start->dwFlags = STARTF_USESTDHANDLES;
    start->hStdInput = GetStdHandle(STD_INPUT_HANDLE);
    start->hStdOutput = GetStdHandle(STD_OUTPUT_HANDLE);
    start->hStdError = GetStdHandle(STD_ERROR_HANDLE);
    SetHandleInformation(start->hStdInput, HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT);
    SetHandleInformation(start->hStdOutput, HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT);
    SetHandleInformation(start->hStdError, HANDLE_FLAG_INHERIT, HANDLE_FLAG_INHERIT);
}

static int run(const wchar_t *python, wchar_t *command)
{
    STARTUPINFOW start = {.cb = sizeof start};
    PROCESS_INFORMATION child;
    DWORD code = 1;

    SetConsoleCtrlHandler(go_on, TRUE);
    pass_streams_on(&start);
    if (!CreateProcessW(python, command, NULL, NULL, TRUE, CREATE_SUSPENDED, NULL, NULL, &start, &child))
        return fail("cannot start", python);
    end_together(child.hProcess);
    ResumeThread(child.hThread);
    WaitForSingleObject(child.hProcess, INFINITE);
    GetExitCodeProcess(child.hProcess, &code);
    return (int)code;
}

int wmain(void)
{
    static wchar_t folder[LONGEST], file[LONGEST], text[LONGEST], command[LONGEST];
    wchar_t *rest = text, *python = file, *package = folder;

    if (!own_folder(folder))
        return fail("too long a path to", L"sistap.exe");
    append(file, LONGEST, folder);
    append(file, LONGEST, L"sistap.cfg");
    if (read_settings(file, text)) {
        python = next_line(&rest);
        package = next_line(&rest);
        if (!python || !package)
            return fail("two lines are missing in", file);
    } else {
        wcscpy(file, folder);
        append(file, LONGEST, L"python\\python.exe");
    }
    SetEnvironmentVariableW(L"PYTHONPATH", package);
    if (!append_quoted(command, LONGEST, python) || !append(command, LONGEST, L" -P -X utf8 -m sistap " COMMAND) ||
        !append(command, LONGEST, arguments(GetCommandLineW())))
        return fail("too many arguments for", python);
    return run(python, command);
}
