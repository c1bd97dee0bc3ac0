/* SPDX-License-Identifier: GPL-2.0-or-later */
/* File > Export Objects > SIS. Each long parameter is a file. The pieces of memory that Read flash and
 * Program flash carry are joined if one follows or overlaps another. What lies apart is a file of its own, so
 * that gaps stay visible. Programmed memory is what was sent, whether or not the station accepted it. */
#include "parts.h"

#include <epan/export_object.h>
#include <epan/tap.h>

#include "sis/export.h"

/* Memory is put together piece by piece: to which entry of the list does a piece belong? Wireshark owns the
 * list and may empty it at any time. A search of the list for every piece would take too long, because
 * tshark's list is a chain. So this index holds, for each address, the first memory of the list that a piece
 * at this address extends. A piece has at most 255 bytes, so its cost does not grow with the list. */

#define PAGE 64u /* addresses */

/* For each address in a page: the number of the memory, from 1; 0: none. */
typedef uint32_t page_t[PAGE];

typedef struct {
    export_object_entry_t *entry;
    uint64_t begin;
    size_t room; /* allocated bytes; more than needed, so that they seldom move */
} memory_t;

/* What is known of a list. */
typedef struct {
    GArray *memories;   /* memory_t, in the order of the list */
    GHashTable *spaces; /* by type and station: a table of pages, by number */
} known_t;

static GHashTable *lists; /* known_t, by list; NULL: none */

static void
free_known(void *data)
{
    known_t *known = data;

    g_array_free(known->memories, TRUE);
    g_hash_table_destroy(known->spaces);
    g_free(known);
}

static GHashTable *
find_pages(const known_t *known, const char *type, const char *station)
{
    char *key = g_strconcat(type, " ", station, NULL);
    GHashTable *pages = g_hash_table_lookup(known->spaces, key);

    if (pages != NULL) {
        g_free(key);
        return pages;
    }
    pages = g_hash_table_new_full(NULL, NULL, NULL, g_free);
    g_hash_table_insert(known->spaces, key, pages);
    return pages;
}

static void *
page_key(uint64_t address)
{
    return GUINT_TO_POINTER((unsigned)(address / PAGE));
}

/* The first of the list takes precedence. */
static void
claim(GHashTable *pages, uint32_t memory, uint64_t first, uint64_t last)
{
    uint32_t *page = NULL;

    for (uint64_t address = first; address <= last; address++) {
        if (page == NULL || address % PAGE == 0)
            page = g_hash_table_lookup(pages, page_key(address));
        if (page == NULL) {
            page = g_malloc0(sizeof(page_t));
            g_hash_table_insert(pages, page_key(address), page);
        }
        if (page[address % PAGE] == 0 || page[address % PAGE] > memory)
            page[address % PAGE] = memory;
    }
}

static void
add(known_t *known, export_object_entry_t *entry)
{
    const char *begin = strrchr(entry->filename, '_') + 1;
    memory_t memory = {entry, g_ascii_strtoull(begin, NULL, 16), entry->payload_len};

    g_array_append_val(known->memories, memory);
    claim(find_pages(known, entry->content_type, entry->hostname), known->memories->len, memory.begin,
          memory.begin + entry->payload_len);
}

/* A list that was forgotten but is still being filled is searched once. */
static known_t *
find_known(export_object_list_t *list)
{
    known_t *known = lists != NULL ? g_hash_table_lookup(lists, list) : NULL;
    export_object_entry_t *entry;

    if (known != NULL)
        return known;
    known = g_new0(known_t, 1);
    known->memories = g_array_new(FALSE, FALSE, sizeof(memory_t));
    known->spaces =
        g_hash_table_new_full(g_str_hash, g_str_equal, g_free, (GDestroyNotify)g_hash_table_destroy);
    for (int row = 0; (entry = list->get_entry(list->gui_data, row)) != NULL; row++) {
        if (strcmp(entry->content_type, SIS_MEMORY_READ) == 0 ||
            strcmp(entry->content_type, SIS_MEMORY_WRITTEN) == 0)
            add(known, entry);
    }
    if (lists == NULL)
        lists = g_hash_table_new_full(NULL, NULL, NULL, free_known);
    g_hash_table_insert(lists, list, known);
    return known;
}

/* Forgets all lists without freeing their entries. */
static void
forget_lists(void)
{
    if (lists != NULL)
        g_hash_table_remove_all(lists);
}

/* Gives an entry a name with the beginning and end of its memory. */
static void
name_memory(export_object_entry_t *entry, uint64_t begin)
{
    g_free(entry->filename);
    entry->filename =
        g_strdup_printf("station-%s_memory-%s_0x%08" PRIx64 "-0x%08" PRIx64 ".bin", entry->hostname,
                        entry->content_type, begin, begin + entry->payload_len - 1);
    g_strdelimit(entry->filename, " ", '-');
}

/* Enlarges an entry. */
static void
grow(memory_t *memory, size_t length)
{
    export_object_entry_t *entry = memory->entry;

    if (length > memory->room) {
        memory->room = MAX(length, memory->room * 2);
        entry->payload_data = g_realloc(entry->payload_data, memory->room);
    }
    entry->payload_len = length;
    name_memory(entry, memory->begin);
}

/* Adds a piece that begins inside a memory of the list, or directly after it, to the first such memory. The
 * later of overlapping bytes count. False if there is none. */
static bool
extend(export_object_list_t *list, const sis_object_t *piece)
{
    known_t *known = find_known(list);
    GHashTable *pages = find_pages(known, piece->type, piece->station);
    const uint32_t *page = g_hash_table_lookup(pages, page_key(piece->address));
    uint32_t number = page != NULL ? page[piece->address % PAGE] : 0;
    memory_t *memory;
    uint64_t at, end;

    if (number == 0)
        return false;
    memory = &g_array_index(known->memories, memory_t, number - 1);
    at = piece->address - memory->begin;
    end = memory->begin + memory->entry->payload_len;
    if (at + piece->length > memory->entry->payload_len) {
        grow(memory, (size_t)at + piece->length);
        claim(pages, number, end, memory->begin + memory->entry->payload_len);
    }
    memcpy(memory->entry->payload_data + at, piece->data, piece->length);
    return true;
}

static export_object_entry_t *
new_entry(const packet_info *pinfo, const sis_object_t *object)
{
    export_object_entry_t *entry = g_new0(export_object_entry_t, 1);

    entry->pkt_num = pinfo->num;
    entry->hostname = g_strdup(object->station);
    entry->content_type = g_strdup(object->type);
    entry->filename = g_strdup(object->name);
    entry->payload_len = object->length;
    entry->payload_data = g_memdup2(object->data, object->length);
    if (object->name == NULL)
        name_memory(entry, object->address);
    return entry;
}

/* Only the list itself is remembered: its user may delete it at any time. */
static tap_packet_status
export_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    export_object_list_t *list = data;
    const sis_object_t *object = tapped;
    export_object_entry_t *entry;

    if (lists != NULL && list->get_entry(list->gui_data, 0) == NULL)
        g_hash_table_remove(lists, list); /* its user has deleted the entries */
    if (object->name == NULL && extend(list, object))
        return TAP_PACKET_REDRAW;
    entry = new_entry(pinfo, object);
    list->add_entry(list->gui_data, entry);
    if (object->name == NULL)
        add(find_known(list), entry);
    return TAP_PACKET_REDRAW;
}

void
windows_export_register(void)
{
    register_export_object(proto_sis, export_packet, forget_lists);
}
