/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The list of parameters (`tshark -z sis,parameters`): reads and writes of each, and its values. The first
 * row is the sum of all. */
#include "parts.h"

#include "kept.h"
#include "protocol/limits.h"
#include "sis/access.h"
#include "sis/address.h"
#include "sis/table.h"

enum {
    LINE,
    STATION,
    DEVICE,
    PARAMETER,
    NAME,
    UNIT,
    READS,
    WRITES,
    ERRORS,
    FIRST,
    LAST,
    LEAST,
    GREATEST,
    RAW,
    WRITTEN_BY,
    WRITTEN_IN,
    COLUMNS
};

/* clang-format off: a value is as wide as its column's name, so that tshark writes columns */
static stat_tap_table_item columns[COLUMNS] = {
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Line", "%-4s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Station", "%-7s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Device", "%-6s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Parameter", "%-9s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Name", "%-4s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Unit", "%-4s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Reads", "%5u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Writes", "%6u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Errors", "%6u"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "First", "%5s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Last", "%4s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Least", "%5s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Greatest", "%8s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Bytes", "%5u"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Written by", "%10s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "In packet", "%9s"},
};
/* clang-format on */

/* The parameter of a row. */
typedef struct {
    sis_place_t place;
    uint8_t type;
    uint8_t zero;
    uint16_t number;
    uint16_t structure;
    uint32_t bus;
} row_key_t;

/* Data of a row beside its columns. */
typedef struct {
    sis_row_t numbers; /* in the first row: those of the other rows, by key */
    row_key_t key;
    bool has_number;
    double least, greatest;
} row_t;

KEPT_KEY(row_key_t, 10 + 2 + 2 + 2 + 4)

static void
name_row(stat_tap_table *table, unsigned row, wmem_allocator_t *pool, const sis_access_t *access)
{
    sis_table_set_text(table, row, LINE, wmem_strdup_printf(pool, "%u", access->bus));
    sis_table_set_text(table, row, STATION, sis_place_text(pool, &access->place));
    sis_table_set_text(table, row, DEVICE, wmem_strdup_printf(pool, "%u", access->place.device));
    sis_table_set_text(table, row, PARAMETER, sis_ident_text(pool, access->ident));
}

/* 0: the table is full. */
static unsigned
find_row(stat_tap_table *table, wmem_allocator_t *pool, const sis_access_t *access)
{
    GHashTable *numbers = ((sis_row_t *)sis_table_row(table, 0))->hash;
    row_key_t key = {.place = access->place,
                     .type = access->ident.type,
                     .number = access->ident.number,
                     .structure = access->ident.structure,
                     .bus = access->bus};
    unsigned row = GPOINTER_TO_UINT(g_hash_table_lookup(numbers, &key));
    row_t *added;

    if (row != 0 || table->num_elements > SIS_MOST_ROWS)
        return row;
    added = g_new0(row_t, 1);
    added->key = key;
    row = sis_table_add_row(table, columns, added);
    g_hash_table_insert(numbers, &added->key, GUINT_TO_POINTER(row));
    name_row(table, row, pool, access);
    return row;
}

static void
count_value(const stat_tap_table *table, unsigned number, const sis_access_t *access)
{
    row_t *row = sis_table_row(table, number);

    if (access->value == NULL)
        return;
    if (stat_tap_get_field_data(table, number, FIRST)->value.string_value[0] == '\0')
        sis_table_set_text(table, number, FIRST, access->value);
    sis_table_set_text(table, number, LAST, access->value);
    sis_table_count(table, number, RAW, access->is_raw);
    if (!access->is_number)
        return;
    if (!row->has_number || access->number < row->least) {
        row->least = access->number;
        sis_table_set_text(table, number, LEAST, access->value);
    }
    if (!row->has_number || access->number > row->greatest) {
        row->greatest = access->number;
        sis_table_set_text(table, number, GREATEST, access->value);
    }
    row->has_number = true;
}

static void
count_access(stat_tap_table *table, packet_info *pinfo, const sis_access_t *access)
{
    unsigned row = find_row(table, pinfo->pool, access);
    unsigned column = access->is_refused ? ERRORS : access->is_write ? WRITES : READS;

    sis_table_count(table, 0, column, 1);
    sis_table_count(table, 0, RAW, access->value != NULL && access->is_raw);
    if (row == 0) {
        sis_table_set_text(table, 0, NAME, "more parameters than rows");
        return;
    }
    sis_table_count(table, row, column, 1);
    sis_table_set_text(table, row, NAME, access->known.name);
    sis_table_set_text(table, row, UNIT, access->known.unit);
    count_value(table, row, access);
    if (column != WRITES)
        return;
    sis_table_set_text(table, row, WRITTEN_BY, access->has_master ? sis_number_text(access->master) : "");
    sis_table_set_text(table, row, WRITTEN_IN, wmem_strdup_printf(pinfo->pool, "%u", pinfo->num));
}

static tap_packet_status
packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    stat_tap_table *table = g_array_index(((stat_data_t *)data)->stat_tap_data->tables, stat_tap_table *, 0);

    count_access(table, pinfo, tapped);
    return TAP_PACKET_REDRAW;
}

static void
init_table(stat_tap_table_ui *ui)
{
    stat_tap_table *table = sis_table_begin(ui, "SIS parameters");
    row_t *first;

    if (table == NULL)
        return;
    first = g_new0(row_t, 1);
    first->numbers.hash = g_hash_table_new(hash_row_key_t, are_equal_row_key_t);
    sis_table_add_row(table, columns, first);
    sis_table_set_text(table, 0, LINE, "All");
}

/* Resets counts and values; the rows stay. */
static void
reset_table(stat_tap_table *table)
{
    for (unsigned number = 0; number < table->num_elements; number++) {
        row_t *row = sis_table_row(table, number);

        row->has_number = false;
        sis_table_reset_row(table, number, NAME);
    }
}

static stat_tap_table_ui table_ui = {
    SIS_TABLE(columns),
    .title = "SIS parameters",
    .tap_name = "sis_access",
    .cli_string = "sis,parameters",
    .stat_tap_init_cb = init_table,
    .packet_func = packet,
    .stat_tap_reset_table_cb = reset_table,
};

void
sis_access_table_register(void)
{
    register_stat_tap_table_ui(&table_ui);
}
