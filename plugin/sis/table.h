/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Tables of Wireshark's statistics. The first row is the sum of all. */

#ifndef SIS_TABLE_H
#define SIS_TABLE_H

#include "compat.h"

#include <epan/stat_tap_ui.h>
#include <epan/tap.h>

/* The first member of what a row has beside its columns. */
typedef struct {
    GHashTable *hash; /* freed with the row; NULL: none */
} sis_row_t;

stat_tap_table *sis_table_of(void *data);

void *sis_table_row(const stat_tap_table *table, unsigned number);

/* Adds a row, which belongs to the table from then on. Its texts are empty. Returns its number. */
unsigned sis_table_add_row(stat_tap_table *table, const stat_tap_table_item *columns, void *row);

void sis_table_count(const stat_tap_table *table, unsigned row, unsigned column, unsigned by);

/* NULL: the text stays. */
void sis_table_set_text(const stat_tap_table *table, unsigned row, unsigned column, const char *text);

/* A new table without rows; NULL: it was there, and is reset. */
stat_tap_table *sis_table_begin(stat_tap_table_ui *ui, const char *title);

/* Empties the columns of a row from this one on. */
void sis_table_reset_row(const stat_tap_table *table, unsigned row, unsigned column);

void
sis_table_free_item(stat_tap_table *table, unsigned row, unsigned column, stat_tap_table_item_type *item);

extern tap_param sis_table_parameters[1];

/* The members of a stat_tap_table_ui that are the same in each. The group is that of a program that shows
 * logs: in Wireshark, the entry of menu.c is the only one. */
#define SIS_TABLE(columns)                                                                                   \
    .group = REGISTER_LOG_STAT_GROUP_UNSORTED, .stat_tap_free_table_item_cb = sis_table_free_item,           \
    .nfields = array_length(columns), .fields = columns, .nparams = 1, .params = sis_table_parameters

#endif
