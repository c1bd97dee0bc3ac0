/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Parts of a command line of Windows. No Windows in it, so that it can be tested anywhere. */
#ifndef TAIL_H
#define TAIL_H

#include <stddef.h>
#include <wchar.h>

/* The arguments behind the program's own name, as they were written: none of them is changed. */
const wchar_t *arguments(const wchar_t *command_line);

/* Appends a word in quotes to what is in a buffer of `size` characters; 0 if there is no room. The word has no quote in
 * it: a path of Windows cannot. */
int append_quoted(wchar_t *buffer, size_t size, const wchar_t *word);

/* Appends text as it is; 0 if there is no room. */
int append(wchar_t *buffer, size_t size, const wchar_t *text);

/* Cuts the next line off; returns NULL if there is none. */
wchar_t *next_line(wchar_t **rest);

#endif
