/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sequential telegrams: long data in pieces (chapters 8.2 and 8.7). */

#ifndef SIS_SEQUENCE_H
#define SIS_SEQUENCE_H

#include "sis/body.h"

/* What a transfer is about; between its pieces all of it stays the same. */
typedef struct {
    sis_ident_t ident;
    uint8_t element;
    uint8_t device;
    uint32_t segment; /* as in the request */
} sis_subject_t;

/* The data of a telegram that reads or writes a parameter, from body->offset to its end. `is_last` as its
 * parameter control says. Adds what is known of the transfer. Gives the whole data where these are the last
 * piece, NULL where they are another, and the data themselves where they are alone. */
tvbuff_t *sis_sequence_data(sis_body_t *body, const sis_subject_t *subject, bool is_last);

/* Whether a transfer of this parameter is under way: then its last piece may be empty. */
bool sis_is_sequence_open(const sis_body_t *body, const sis_subject_t *subject);

/* Whether these data are a piece. */
bool sis_is_piece(const sis_body_t *body);

/* A good telegram that may end a transfer: cancelled, refused, or overtaken by another parameter of the same
 * device. */
void sis_sequence_watch(sis_body_t *body);

void sis_sequence_register(void);

#endif
