/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The rules are those of CommandLineToArgvW. The first word ends with a blank outside of quotes, and a backslash means
 * nothing in it. All others are passed on unread, so no rule for them is needed here. */
#include "tail.h"

static int is_blank(wchar_t c)
{
    return c == L' ' || c == L'\t';
}

const wchar_t *arguments(const wchar_t *command_line)
{
    int quoted = 0;

    for (; *command_line && (quoted || !is_blank(*command_line)); command_line++)
        if (*command_line == L'"')
            quoted = !quoted;
    while (is_blank(*command_line))
        command_line++;
    return command_line;
}

int append(wchar_t *buffer, size_t size, const wchar_t *text)
{
    size_t used = wcslen(buffer), length = wcslen(text);

    if (used + length >= size)
        return 0;
    wmemcpy(buffer + used, text, length + 1);
    return 1;
}

/* A backslash before the last quote would make a character of that quote: so there are two. */
int append_quoted(wchar_t *buffer, size_t size, const wchar_t *word)
{
    size_t length = wcslen(word);

    return append(buffer, size, L"\"") && append(buffer, size, word) &&
           append(buffer, size, length && word[length - 1] == L'\\' ? L"\\\"" : L"\"");
}

wchar_t *next_line(wchar_t **rest)
{
    wchar_t *line = *rest, *end = line + wcscspn(line, L"\r\n");

    if (!*line)
        return NULL;
    *rest = end + wcsspn(end, L"\r\n");
    *end = 0;
    return line;
}
