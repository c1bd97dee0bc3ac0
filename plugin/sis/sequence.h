/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sequential telegrams: long data in pieces (chapters 8.2 and 8.7). */

#ifndef SIS_SEQUENCE_H
#define SIS_SEQUENCE_H

#include "sis/body.h"

/* The data of a telegram that reads or writes a parameter, from body->offset to its end. `is_last` comes
 * from its parameter control. Adds what is known of the transfer. Returns the whole data with the last
 * piece, NULL with another one, and the data themselves without a transfer. */
tvbuff_t *sis_sequence_data(sis_body_t *body, bool is_last);

/* Whether these data are a piece. */
bool sis_is_piece(const sis_body_t *body);

/* Whether it is not known that all pieces belong together. */
bool sis_is_doubtful(const sis_body_t *body);

/* First pass: takes a decoded body that may end transfers. */
void sis_sequence_learn(const sis_body_t *body);

/* Adds the transfers that a body ended. */
void sis_sequence_show(sis_body_t *body);

#endif
