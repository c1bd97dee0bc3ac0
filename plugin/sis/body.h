/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The useful data of one service: the rest of it, and functions that read it field by field. */

#ifndef SIS_BODY_H
#define SIS_BODY_H

#include "sis/exchange.h"
#include "sis/names.h"

typedef struct sis_body {
    const sis_telegram_t *telegram;
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root; /* of the telegram, or of an element of service 0x04 */
    proto_item *item; /* of the last field read */
    unsigned offset;  /* of the first byte not read yet */
    unsigned end;     /* of the available useful data */
    unsigned element; /* its number in a list, from 1; 0: the service of the telegram */
    bool is_cut;      /* the telegram is not whole: the header's note says so, so a missing field has none */
    bool is_short;    /* a field that was read had too few bytes; then nothing more is read */
    bool is_reaction;
    uint8_t service;
    uint8_t status; /* of a reaction */
    const char *status_text;
    proto_item *status_item;
    uint32_t error; /* the code, 0: none */
    const char *error_text;
    const sis_error_t *errors; /* of the elements of service 0x04, the last first */
    bool is_explained;         /* an error code was shown, so the status is not marked, too */
    wmem_strbuf_t *summary;    /* for the packet list, after the service's name */
    wmem_strbuf_t *marks;      /* and what is wrong, after that */
    sis_request_t
        *request;         /* of a command: filled in while reading, in the first pass that of its exchange */
    sis_request_t *asked; /* as the first pass has read it; NULL: unknown, or it is reading it */
    sis_record_t *record; /* of the whole telegram; NULL for a damaged one */
    /* What this teaches, found while reading; the first pass takes it afterwards (learn.c). NULL: nothing. */
    void (*learn)(struct sis_body *body);
    tvbuff_t *data;   /* of an element of a parameter, complete; NULL: missing or incomplete */
    const char *text; /* and their value as text, or another text that was read; NULL: none */
    uint32_t phase;   /* of a reaction */
} sis_body_t;

/* Decodes a whole body, status byte first; marks bytes that are left over (dispatch.c). */
void sis_dissect_body(sis_body_t *body);

/* Whether the telegram is a good one, whose exchange is known. */
bool sis_has_exchange(const sis_body_t *body);

/* Whether that many bytes are left for a field; if not, adds a note once per body. */
bool sis_needs(sis_body_t *body, int hf, unsigned size);

/* Adds `size` bytes, little endian, as field `hf`, and returns their value; item is set. If bytes are
 * missing, adds a note once per body and returns false. */
bool sis_take(sis_body_t *body, int hf, unsigned size, uint32_t *value);

/* The same for a code whose text depends on the service: "Text (0x12)". Returns the text. */
const char *
sis_take_code(sis_body_t *body, int hf, unsigned size, const value_string *texts, uint32_t *value);

/* Device address and subservice, the first fields of the bodies of services that have subservices. */
bool sis_take_subservice(sis_body_t *body, uint32_t *subservice);

/* What a command asks for, or a reaction answers; NULL: unknown. */
sis_request_t *sis_request_of(const sis_body_t *body);

/* Of a command: the request of the next element of a list, or of a further subservice. */
sis_request_t *sis_request_add(sis_body_t *body, uint8_t service);

/* Remembers the device of a command. */
void sis_request_device(sis_body_t *body, uint32_t device);

/* A part of the useful data. */
typedef struct {
    void (*take)(sis_body_t *body, unsigned size); /* NULL: as its field says */
    int *hf;                                       /* NULL: this is the end */
    const value_string *codes;
    unsigned size; /* bytes; 0: the rest */
    bool may_be_missing;
} sis_item_t;

/* What follows a subservice (protocol/services.toml). */
typedef struct {
    uint8_t subservice;
    const sis_item_t *command, *reaction; /* an item without a field ends them */
} sis_layout_t;

typedef struct {
    uint8_t service;
    const value_string *errors; /* after status 1, by subservice and error byte; NULL: none is documented */
    unsigned count;             /* of layouts */
    const sis_layout_t *layouts;
} sis_layouts_t;

/* The layout of a subservice; NULL: there is none. */
const sis_layout_t *sis_find_layout(const sis_layouts_t *service, uint32_t subservice);

/* Takes a layout; NULL: bytes that no document defines, which are shown raw. */
void sis_take_layout(sis_body_t *body, const sis_layout_t *layout);

/* What follows a subservice in a command or a good reaction, or an error. */
void sis_take_layout_or_error(sis_body_t *body, const sis_layouts_t *service, uint32_t subservice);

/* The rest of the body as bytes; false if there is none. */
bool sis_take_rest(sis_body_t *body, int hf);

/* The rest of the body as text, and into the summary. */
void sis_take_text(sis_body_t *body, int hf);

/* A mask of baud rates; of several rates only where `several` are allowed. Adds them to the summary. Gives
 * the rate where it is one; 0: it is not. */
uint32_t sis_take_baud_mask(sis_body_t *body, bool several);

unsigned sis_left(const sis_body_t *body);

/* A reaction without error; its useful data follow. */
bool sis_is_ok(const sis_body_t *body);

/* The error code of the service instead of useful data: two bytes, with `advice` for some codes (NULL: none)
 * ... */
void sis_take_error(sis_body_t *body, const value_string *texts, const value_string *advice);
/* ... or one byte, which forms a code together with the subservice. */
void sis_take_error_byte(sis_body_t *body, uint8_t subservice, const value_string *texts);

/* After a status that is neither good nor the service's own error: takes what is there; false for those two.
 */
bool sis_take_channel_error(sis_body_t *body);

/* Words for the packet list, and for a fault. */
void sis_say(sis_body_t *body, const char *format, ...) G_GNUC_PRINTF(2, 3);
/* The same for plain strings, after the last of which stands NULL: printf() is half of what a telegram costs.
 */
void sis_say_words(sis_body_t *body, const char *word, ...) G_GNUC_NULL_TERMINATED;
/* "1 byte", "7 bytes", behind a word. */
void sis_say_bytes(sis_body_t *body, const char *before, unsigned count);
void sis_mark(sis_body_t *body, expert_field *ei, const char *format, ...) G_GNUC_PRINTF(3, 4);

#endif
