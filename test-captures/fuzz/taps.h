/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Everything that counts, collects and exports: all windows of Wireshark's menus, open at once, and rows. */

#ifndef FUZZ_TAPS_H
#define FUZZ_TAPS_H

void taps_begin(void); /* rows, for good: nothing of Wireshark closes what `-z` has opened */
void taps_open(void);
void taps_close(void); /* draws them first */

#endif
