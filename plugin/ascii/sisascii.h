/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The ASCII protocol of ECODRIVE and IndraDrive. */

#ifndef ASCII_SISASCII_H
#define ASCII_SISASCII_H

#include "protocol/codes.h"

/* Received by the tap "sisascii": an answer whose time was measured. */
typedef struct {
    sisascii_kind_t kind; /* of its command */
    int64_t elapsed;      /* ns */
} sisascii_answer_t;

#endif
