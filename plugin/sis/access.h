/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What was read and written: an access to the operating data of a parameter, told by the reaction to it. */

#ifndef SIS_ACCESS_H
#define SIS_ACCESS_H

#include "sis/learned.h"

/* Tables, and whoever asks for the field sis.access, get these. */
typedef struct {
    bool is_write;
    bool is_refused;
    uint32_t bus;   /* number of the line or connection */
    uint8_t master; /* who has sent the command */
    sis_place_t place;
    sis_ident_t ident;
    sis_known_t known; /* when the command was sent */
    const char *value; /* as it is shown, bytes where no attribute is known; NULL: none, or not all of it */
    bool is_number;
    double number; /* that `value` shows */
    tvbuff_t *data;
    const char *error; /* of a refused one */
} sis_access_t;

/* First pass: a command brings all data that are to be written. */
void sis_keep_written(sis_body_t *body, tvbuff_t *data);

/* A reaction has brought the last data of a reading; `data` is NULL where not all of them are known. */
void sis_note_read(sis_body_t *body, tvbuff_t *data);

/* A reaction has accepted a writing, or refused either. */
void sis_note_answer(sis_body_t *body, bool is_write);

/* "3" or, behind routers, "3/2/8". */
const char *sis_place_text(wmem_allocator_t *scope, const sis_place_t *place);

void sis_access_register(void);

#endif
