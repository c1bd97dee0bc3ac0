/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Memory that Export Objects reassembles: finds the list entry of a piece. */

#ifndef SIS_MEMORIES_H
#define SIS_MEMORIES_H

#include "compat.h"

#include <epan/export_object.h>

/* The content type of a list entry that is memory; its hostname is the station. */
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

/* Adds a piece that begins inside a memory of the list, or directly after it, to the first such memory.
 * The later of overlapping bytes count. False if there is none. */
bool sis_memories_extend(export_object_list_t *list, const sis_piece_t *piece);

/* Records a memory that was appended to the list, because its first piece extended none. */
void sis_memories_add(export_object_list_t *list, export_object_entry_t *entry);

/* Call before a search or an addition: the list's user may have deleted its entries. */
void sis_memories_refresh(export_object_list_t *list);

/* Forgets all lists without freeing their entries. */
void sis_memories_reset(void);

/* Gives an entry a name with the beginning and end of its memory. */
void sis_memories_name(export_object_entry_t *entry, uint64_t begin);

#endif
