/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The list of parameters (`tshark -z sis,parameters`): reads and writes of each, and its values. The first
 * row is the sum of all. */

#include "sis/access-table.h"

#include <epan/stat_tap_ui.h>
#include <epan/tap.h>

#include "sis/access.h"
#include "sis/address.h"

/* Rows below the first. Accesses without a row are still counted in the first. */
#define MOST_ROWS 10000u

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
    uint16_t zeros;
    uint32_t bus;
} row_key_t;

/* Data of a row beside its columns. */
typedef struct {
    row_key_t key;
    GHashTable *numbers; /* in the first row: those of the other rows, by key */
    bool has_number;
    double least, greatest;
} row_t;

_Static_assert(sizeof(row_key_t) == 10 + 2 + 2 + 2 + 4, "the key is hashed byte by byte, so it has no gaps");

static unsigned
hash_key(const void *key)
{
    return wmem_strong_hash(key, sizeof(row_key_t));
}

static gboolean
are_keys_equal(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(row_key_t)) == 0;
}

static row_t *
row_at(const stat_tap_table *table, unsigned number)
{
    return stat_tap_get_field_data(table, number, 0)->user_data.ptr_value;
}

static void
count(const stat_tap_table *table, unsigned row, unsigned column)
{
    stat_tap_get_field_data(table, row, column)->value.uint_value++;
}

static void
set_text(const stat_tap_table *table, unsigned row, unsigned column, const char *text)
{
    stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);

    if (text == NULL || strcmp(item->value.string_value, text) == 0)
        return;
    g_free((char *)item->value.string_value);
    item->value.string_value = g_strdup(text);
}

static unsigned
add_row(stat_tap_table *table)
{
    stat_tap_table_item_type items[COLUMNS] = {0};
    unsigned number = table->num_elements;

    for (unsigned i = 0; i < COLUMNS; i++) {
        items[i].type = columns[i].type;
        if (columns[i].type == TABLE_ITEM_STRING)
            items[i].value.string_value = g_strdup("");
    }
    items[0].user_data.ptr_value = g_new0(row_t, 1);
    stat_tap_init_table_row(table, number, COLUMNS, items);
    return number;
}

static void
name_row(stat_tap_table *table, unsigned row, wmem_allocator_t *pool, const sis_access_t *access)
{
    set_text(table, row, LINE, wmem_strdup_printf(pool, "%u", access->bus));
    set_text(table, row, STATION, sis_place_text(pool, &access->place));
    set_text(table, row, DEVICE, wmem_strdup_printf(pool, "%u", access->place.device));
    set_text(table, row, PARAMETER, sis_ident_text(pool, access->ident));
}

/* 0: the table is full. */
static unsigned
find_row(stat_tap_table *table, wmem_allocator_t *pool, const sis_access_t *access)
{
    GHashTable *numbers = row_at(table, 0)->numbers;
    row_key_t key = {.place = access->place,
                     .type = access->ident.type,
                     .number = access->ident.number,
                     .bus = access->bus};
    unsigned row = GPOINTER_TO_UINT(g_hash_table_lookup(numbers, &key));

    if (row != 0 || table->num_elements > MOST_ROWS)
        return row;
    row = add_row(table);
    row_at(table, row)->key = key;
    g_hash_table_insert(numbers, &row_at(table, row)->key, GUINT_TO_POINTER(row));
    name_row(table, row, pool, access);
    return row;
}

static void
count_value(const stat_tap_table *table, unsigned number, const sis_access_t *access)
{
    row_t *row = row_at(table, number);

    if (access->value == NULL)
        return;
    if (stat_tap_get_field_data(table, number, FIRST)->value.string_value[0] == '\0')
        set_text(table, number, FIRST, access->value);
    set_text(table, number, LAST, access->value);
    if (!access->is_number)
        return;
    if (!row->has_number || access->number < row->least) {
        row->least = access->number;
        set_text(table, number, LEAST, access->value);
    }
    if (!row->has_number || access->number > row->greatest) {
        row->greatest = access->number;
        set_text(table, number, GREATEST, access->value);
    }
    row->has_number = true;
}

static void
count_access(stat_tap_table *table, packet_info *pinfo, const sis_access_t *access)
{
    unsigned row = find_row(table, pinfo->pool, access);
    unsigned column = access->is_refused ? ERRORS : access->is_write ? WRITES : READS;

    count(table, 0, column);
    if (row == 0) {
        set_text(table, 0, NAME, "more parameters than rows");
        return;
    }
    count(table, row, column);
    set_text(table, row, NAME, access->known.name);
    set_text(table, row, UNIT, access->known.unit);
    count_value(table, row, access);
    if (column != WRITES)
        return;
    set_text(table, row, WRITTEN_BY, sis_number_text(access->master));
    set_text(table, row, WRITTEN_IN, wmem_strdup_printf(pinfo->pool, "%u", pinfo->num));
}

static tap_packet_status
packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    stat_tap_table *table = g_array_index(((stat_data_t *)data)->stat_tap_data->tables, stat_tap_table *, 0);
    const sis_telegram_t *telegram = tapped;

    if (telegram->accesses == NULL || wmem_list_count(telegram->accesses) == 0)
        return TAP_PACKET_DONT_REDRAW;
    for (wmem_list_frame_t *frame = wmem_list_head(telegram->accesses); frame != NULL;
         frame = wmem_list_frame_next(frame))
        count_access(table, pinfo, wmem_list_frame_data(frame));
    return TAP_PACKET_REDRAW;
}

static void
init_table(stat_tap_table_ui *ui)
{
    const char *title = "SIS parameters";
    stat_tap_table *table = stat_tap_find_table(ui, title);

    if (table != NULL) {
        if (ui->stat_tap_reset_table_cb != NULL)
            ui->stat_tap_reset_table_cb(table);
        return;
    }
    table = stat_tap_init_table(title, COLUMNS, 0, NULL);
    stat_tap_add_table(ui, table);
    add_row(table);
    row_at(table, 0)->numbers = g_hash_table_new(hash_key, are_keys_equal);
    set_text(table, 0, LINE, "All");
}

/* Resets counts and values; the rows stay. */
static void
reset_table(stat_tap_table *table)
{
    for (unsigned row = 0; row < table->num_elements; row++) {
        row_at(table, row)->has_number = false;
        for (unsigned column = NAME; column < COLUMNS; column++) {
            if (columns[column].type == TABLE_ITEM_STRING)
                set_text(table, row, column, "");
            else
                stat_tap_get_field_data(table, row, column)->value.uint_value = 0;
        }
    }
}

static void
free_item(stat_tap_table *table _U_, unsigned row _U_, unsigned column, stat_tap_table_item_type *item)
{
    row_t *kept = item->user_data.ptr_value;

    if (item->type == TABLE_ITEM_STRING)
        g_free((char *)item->value.string_value);
    if (column != LINE)
        return;
    if (kept->numbers != NULL)
        g_hash_table_destroy(kept->numbers);
    g_free(kept);
}

static tap_param parameters[] = {{PARAM_FILTER, "filter", "Filter", NULL, TRUE}};

static stat_tap_table_ui table_ui = {
    .group = REGISTER_PACKET_STAT_GROUP_UNSORTED,
    .title = "SIS parameters",
    .tap_name = "sis",
    .cli_string = "sis,parameters",
    .stat_tap_init_cb = init_table,
    .packet_func = packet,
    .stat_tap_reset_table_cb = reset_table,
    .stat_tap_free_table_item_cb = free_item,
    .nfields = COLUMNS,
    .fields = columns,
    .nparams = array_length(parameters),
    .params = parameters,
};

void
sis_access_table_register(void)
{
    register_stat_tap_table_ui(&table_ui);
}
