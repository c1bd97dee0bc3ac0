/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What a packet tells programs that make no tree of it (windows/rows.c). */

#ifndef SIS_TOLD_H
#define SIS_TOLD_H

#include "sis/telegram.h"

struct sis_access;

/* A telegram, or what stands in the place of one. It says of fields what no record has: "NAME=VALUE\t"... */
typedef struct sis_part {
    struct sis_part *next;          /* in the same packet */
    const sis_telegram_t *telegram; /* NULL: it has no whole header */
    bool is_telegram;               /* else nobody knows what it is, or another protocol */
    wmem_strbuf_t *said;
    wmem_array_t *accesses; /* of const sis_access_t * */
} sis_part_t;

/* Whether somebody reads it. If not, nothing is kept. */
bool sis_is_told(void);

/* Those of a packet, in their order. */
const sis_part_t *sis_parts(packet_info *pinfo);

/* Begins the next one; NULL: nobody reads it. What follows is said of it. */
sis_part_t *sis_part_begin(packet_info *pinfo);

void sis_tell(packet_info *pinfo, int hf, uint32_t value);
void sis_tell_text(packet_info *pinfo, int hf, const char *text);

/* An expert item: it tells a fault, or what is against the specification. */
void sis_tell_expert(packet_info *pinfo, const expert_field *ei);

/* The data of the access stay as they are while the packet is dissected. */
void sis_tell_access(packet_info *pinfo, const struct sis_access *access);

/* Appends "NAME=VALUE\t". No text of a capture ends a value, a column or a row. */
void sis_say_number(wmem_strbuf_t *said, const char *name, uint64_t value);
void sis_say_text(wmem_strbuf_t *said, const char *name, const char *text);
void sis_append_escaped(wmem_strbuf_t *said, const char *text);

#endif
