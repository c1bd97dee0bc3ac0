/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Tables of Wireshark's statistics. The first column of a row points to the row's own data. */
#include "sis/table.h"

tap_param sis_table_parameters[1] = {{PARAM_FILTER, "filter", "Filter", NULL, TRUE}};

stat_tap_table *
sis_table_of(void *data)
{
    return g_array_index(((stat_data_t *)data)->stat_tap_data->tables, stat_tap_table *, 0);
}

void *
sis_table_row(const stat_tap_table *table, unsigned number)
{
    return stat_tap_get_field_data(table, number, 0)->user_data.ptr_value;
}

unsigned
sis_table_add_row(stat_tap_table *table, const stat_tap_table_item *columns, void *row)
{
    stat_tap_table_item_type *items = g_new0(stat_tap_table_item_type, table->num_fields);
    unsigned number = table->num_elements;

    for (unsigned i = 0; i < table->num_fields; i++) {
        items[i].type = columns[i].type;
        if (columns[i].type == TABLE_ITEM_STRING)
            items[i].value.string_value = g_strdup("");
    }
    items[0].user_data.ptr_value = row;
    stat_tap_init_table_row(table, number, table->num_fields, items);
    g_free(items);
    return number;
}

void
sis_table_count(const stat_tap_table *table, unsigned row, unsigned column, unsigned by)
{
    stat_tap_get_field_data(table, row, column)->value.uint_value += by;
}

void
sis_table_set_text(const stat_tap_table *table, unsigned row, unsigned column, const char *text)
{
    stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);

    if (text == NULL || strcmp(item->value.string_value, text) == 0)
        return;
    g_free((char *)item->value.string_value);
    item->value.string_value = g_strdup(text);
}

stat_tap_table *
sis_table_begin(stat_tap_table_ui *ui, const char *title)
{
    stat_tap_table *table = stat_tap_find_table(ui, title);

    if (table != NULL) {
        if (ui->stat_tap_reset_table_cb != NULL)
            ui->stat_tap_reset_table_cb(table);
        return NULL;
    }
    table = stat_tap_init_table(title, (int)ui->nfields, 0, NULL);
    stat_tap_add_table(ui, table);
    return table;
}

void
sis_table_reset_row(const stat_tap_table *table, unsigned row, unsigned column)
{
    for (; column < table->num_fields; column++) {
        stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);

        if (item->type == TABLE_ITEM_STRING) {
            sis_table_set_text(table, row, column, "");
            item->user_data.float_value = 0;
        } else {
            memset(&item->value, 0, sizeof item->value);
        }
    }
}

void
sis_table_free_item(stat_tap_table *table _U_, unsigned row _U_, unsigned column,
                    stat_tap_table_item_type *item)
{
    sis_row_t *kept = item->user_data.ptr_value;

    if (item->type == TABLE_ITEM_STRING)
        g_free((char *)item->value.string_value);
    if (column != 0)
        return;
    if (kept->hash != NULL)
        g_hash_table_destroy(kept->hash);
    g_free(kept);
}
