/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sequential telegrams: long data in pieces (chapters 8.2 and 8.7). */

#ifndef SIS_SEQUENCE_H
#define SIS_SEQUENCE_H

#include "sis/body.h"

/* What a transfer is about; constant for all its pieces. */
typedef struct {
    sis_ident_t ident;
    uint8_t element;
    uint8_t device;
    uint32_t segment; /* as requested */
} sis_subject_t;

/* The data of a telegram that reads or writes a parameter, from body->offset to its end. `is_last` comes
 * from its parameter control. Adds what is known of the transfer. Returns the whole data with the last
 * piece, NULL with another one, and the data themselves without a transfer. */
tvbuff_t *sis_sequence_data(sis_body_t *body, const sis_subject_t *subject, bool is_last);

/* Whether a transfer of this parameter is under way: then its last piece may be empty. */
bool sis_is_sequence_open(const sis_body_t *body, const sis_subject_t *subject);

/* Whether these data are a piece. */
bool sis_is_piece(const sis_body_t *body);

/* Whether it is not known if their transfer went on: then the whole may be none. */
bool sis_is_doubtful(const sis_body_t *body);

/* A good telegram that may end a transfer: cancelled, refused, or superseded by another parameter of the
 * same device. */
void sis_sequence_watch(sis_body_t *body);

#endif
