/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reads and writes: accesses to the operating data of a parameter. The reaction completes an access. */

#ifndef SIS_ACCESS_H
#define SIS_ACCESS_H

#include "sis/station.h"

/* Told by the field sis.access, and to programs (told.c). */
typedef struct sis_access {
    bool is_write;
    bool has_master;
    uint8_t master; /* the station that sent the command */
    sis_place_t place;
    sis_ident_t ident;
    sis_known_t
        known;      /* when the command was sent; in later passes, if the attribute was unknown: afterwards */
    tvbuff_t *data; /* NULL: missing or incomplete */
    const char *value; /* of the ASCII protocol, as displayed */
    bool is_number;    /* this value */
    const char *text;  /* of the ASCII protocol, all of it: elements with ", " between; NULL: none */
    const char *error; /* of a refused access */
} sis_access_t;

/* Whether anybody wants to know it, or the field in this tree. */
bool sis_access_is_wanted(proto_tree *tree);

/* Tells it. */
void sis_access_tell(const sis_access_t *access, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree);

/* As a JSON object; unknown values are left out. */
const char *sis_access_text(packet_info *pinfo, const sis_access_t *access);

/* First pass: a command has all data to write. */
void sis_keep_written(sis_body_t *body);

/* A reaction has brought the last data of a read, which may be incomplete. */
void sis_note_read(sis_body_t *body);

/* A reaction has accepted a write, or refused a read or write. */
void sis_note_answer(sis_body_t *body, bool is_write);

#endif
