/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Memory that Export Objects puts together piece by piece: which entry of a list a piece belongs to. */

#ifndef SIS_MEMORIES_H
#define SIS_MEMORIES_H

#include "compat.h"

#include <epan/export_object.h>

/* An entry of such a list that is memory, by its content type; its hostname is the station. */
#define SIS_MEMORY_READ    "read"
#define SIS_MEMORY_WRITTEN "written"

/* A piece of memory. */
typedef struct {
    const char *type;
    const char *station;
    uint32_t address;
    const uint8_t *data;
    unsigned length;
} sis_piece_t;

/* Puts a piece that begins inside a memory of the list, or directly behind it, into the first such memory;
 * what is there twice, the later one wins. False where there is none. */
bool sis_memories_extend(export_object_list_t *list, const sis_piece_t *piece);

/* Takes note of a memory that has become the last entry of the list, as its first piece extended none. */
void sis_memories_add(export_object_list_t *list, export_object_entry_t *entry);

/* Before anything is looked for or added: whoever shows a list may have thrown its entries away. */
void sis_memories_refresh(export_object_list_t *list);

/* Forgets all lists; their entries are somebody else's. */
void sis_memories_reset(void);

/* Gives an entry the name that says where its memory begins and ends. */
void sis_memories_name(export_object_entry_t *entry, uint64_t begin);

#endif
