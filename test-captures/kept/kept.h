/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What tshark.c asks of library.c: one message with four descriptors (stdin, stdout, stderr, current folder),
 * that is the count of arguments, then the arguments and the environment, each with its zero. The answer is
 * the status of waitpid. A byte to the library is a signal for that tshark, and a connection that ends kills
 * it. */

#ifndef KEPT_H
#define KEPT_H

enum { KEPT_FDS = 4, KEPT_BYTES = 1 << 17 };

#endif
