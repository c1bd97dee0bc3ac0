/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reads and writes: accesses to the operating data of a parameter. The reaction completes an access. */

#ifndef SIS_ACCESS_H
#define SIS_ACCESS_H

#include "sis/learned.h"

/* Received by tables and by users of the field sis.access. */
typedef struct {
    bool is_write;
    bool is_refused;
    uint32_t bus;   /* number of the line or connection */
    uint8_t master; /* the station that sent the command */
    sis_place_t place;
    sis_ident_t ident;
    sis_known_t known; /* when the command was sent */
    const char *value; /* as displayed, bytes if the attribute is unknown; NULL: missing or incomplete */
    bool is_number;
    double number; /* the number in `value` */
    tvbuff_t *data;
    const char *error; /* of a refused access */
} sis_access_t;

/* First pass: a command has all data to write. */
void sis_keep_written(sis_body_t *body, tvbuff_t *data);

/* A reaction has brought the last data of a read; `data` is NULL if they are incomplete. */
void sis_note_read(sis_body_t *body, tvbuff_t *data);

/* A reaction has accepted a write, or refused a read or write. */
void sis_note_answer(sis_body_t *body, bool is_write);

/* "3" or, behind routers, "3/2/8". */
const char *sis_place_text(wmem_allocator_t *scope, const sis_place_t *place);

void sis_access_register(void);

#endif
