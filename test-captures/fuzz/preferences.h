/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The plugin's preferences, as the user's dialog sets them. */

#ifndef FUZZ_PREFERENCES_H
#define FUZZ_PREFERENCES_H

#include <stdint.h>

/* Two bits choose the value of each. Does nothing if they are so already. */
void preferences_set(uint32_t choice);

#endif
