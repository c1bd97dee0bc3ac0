/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Lines of the ASCII protocol that belong together: a command, its echo and its answer. */

#ifndef ASCII_DIALOGUE_H
#define ASCII_DIALOGUE_H

#include "parameters/learned.h"
#include "protocol/codes.h"
#include "sis/asked.h"
#include "sis/bus.h"

/* What a line says by itself. A line that says nothing of all this is a text. */
typedef struct {
    sisascii_kind_t kind;
    const char *text; /* all of it, without its end */
    unsigned at;      /* where the drive, the element or the error code begins */
    uint8_t drive;
    sis_ident_t ident; /* of a read or write, with its element */
    sis_element_t element;
    unsigned value_at; /* of a write */
    uint16_t error;
} sisascii_said_t;

/* A line that wants an answer, and the answer as far as the capture has it. Lives as long as the file. */
typedef struct sisascii_command {
    sisascii_said_t said;
    struct sisascii_command *list; /* of an element, and of the end of a list: the write that began it */
    const sis_known_t *known;      /* what the bus had said of the parameter; NULL: nothing */
    const sis_twin_t *twin;        /* the same of a device of its type; NULL: nothing */
    wmem_strbuf_t *value;          /* what was read or written, elements with ", " between */
    unsigned count;                /* of the elements in it */
    sis_asked_t *asked;            /* of its line */
    uint32_t end_in, next_in;      /* 0: none. The end is a prompt, or "?" */
    uint32_t unanswered_before, repeat_of;
    uint16_t error; /* 0: none */
    bool has_error, has_drive, is_echoed;
    uint8_t drive;
} sisascii_command_t;

/* A line, with the results of the first pass. The tap "sisascii" receives answers whose time was measured. */
typedef struct {
    sis_asked_t asked; /* it answers if it is the first line of an answer */
    sisascii_kind_t kind;
    sisascii_command_t *command; /* this is, or belongs to; NULL: none is known */
    bool is_command;             /* this is it */
    unsigned number; /* of a value in its list, from 1; 0: it is none, or the first that was read */
    bool has_drive;
    uint8_t drive;       /* the one that is open */
    sis_setting_t limit; /* the user's TrS; value 0: none */
} sisascii_unit_t;

/* The line of this packet; found in the first pass, and kept. */
const sisascii_unit_t *
sisascii_find(packet_info *pinfo, const sisascii_said_t *said, const sis_times_t *times);

/* The place of a drive: its address is that of its only device, too (MPH-02, p. 10-100). */
sis_place_t sisascii_place(const sisascii_command_t *command);

#endif
