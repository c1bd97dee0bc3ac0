/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A row for each packet (`tshark -q -z sis,rows,FIELD,FIELD...`): as `-T fields -E header=y -E
 * aggregator=/x1f` prints it, but only these fields are made, and nothing is put into words. A field that
 * nobody knows is left out. */
#include "parts.h"

#include <stdio.h>

#include <epan/epan_dissect.h>
#include <epan/print.h>
#include <epan/stat_tap_ui.h>
#include <epan/tap.h>

#define NAME  "sis,rows"
#define JOINT '\x1f' /* between several values of a field */

typedef struct {
    GHashTable *columns; /* by field: the number of its column, from 1 */
    GPtrArray *texts;    /* GString of each column, of the present packet */
    GString *row;
    epan_dissect_t *packet;
} rows_t;

static void
free_text(void *text)
{
    g_string_free(text, TRUE);
}

static void
free_rows(void *data)
{
    rows_t *rows = data;

    g_hash_table_destroy(rows->columns);
    g_ptr_array_free(rows->texts, TRUE);
    g_string_free(rows->row, TRUE);
    g_free(rows);
}

static rows_t *
new_rows(void)
{
    rows_t *rows = g_new0(rows_t, 1);

    rows->columns = g_hash_table_new(NULL, NULL);
    rows->texts = g_ptr_array_new_with_free_func(free_text);
    rows->row = g_string_new(NULL);
    return rows;
}

static void
append_control(GString *text, char control)
{
    static const char letters[] = {['\t'] = 't', ['\n'] = 'n', ['\r'] = 'r'};
    size_t code = (unsigned char)control;

    if (code < sizeof letters && letters[code] != '\0')
        g_string_append_printf(text, "\\%c", letters[code]);
    else
        g_string_append_printf(text, "\\x%02zx", code);
}

/* No text of a capture ends a value, a column or a row. */
static void
append_value(GString *text, const char *value)
{
    if (text->len > 0)
        g_string_append_c(text, JOINT);
    while (*value != '\0') {
        const char *end = value;

        while (*end != '\0' && !g_ascii_iscntrl(*end))
            end++;
        g_string_append_len(text, value, end - value);
        if (*end != '\0')
            append_control(text, *end++);
        value = end;
    }
}

static void
add_values(proto_node *node, void *data)
{
    rows_t *rows = data;
    field_info *field = PNODE_FINFO(node);
    unsigned column = 0;

    if (field != NULL)
        column = GPOINTER_TO_UINT(g_hash_table_lookup(rows->columns, GINT_TO_POINTER(field->hfinfo->id)));
    if (column > 0) {
        char *value = get_node_field_value(field, rows->packet);

        append_value(g_ptr_array_index(rows->texts, column - 1), value);
        g_free(value);
    }
    proto_tree_children_foreach(node, add_values, rows);
}

/* Writes the texts of all columns, and empties them. */
static void
write_row(rows_t *rows)
{
    g_string_truncate(rows->row, 0);
    for (unsigned i = 0; i < rows->texts->len; i++) {
        GString *text = g_ptr_array_index(rows->texts, i);

        if (i > 0)
            g_string_append_c(rows->row, '\t');
        g_string_append_len(rows->row, text->str, (gssize)text->len);
        g_string_truncate(text, 0);
    }
    g_string_append_c(rows->row, '\n');
    fwrite(rows->row->str, 1, rows->row->len, stdout);
}

static tap_packet_status
packet(void *data, packet_info *pinfo _U_, epan_dissect_t *edt, const void *tapped _U_, tap_flags_t flags _U_)
{
    rows_t *rows = data;

    rows->packet = edt;
    proto_tree_children_foreach(edt->tree, add_values, rows);
    write_row(rows);
    return TAP_PACKET_DONT_REDRAW;
}

static void
add_column(rows_t *rows, const char *name, GString *filter)
{
    const header_field_info *field = proto_registrar_get_byname(name);

    if (field == NULL)
        return;
    g_ptr_array_add(rows->texts, g_string_new(name));
    g_hash_table_insert(rows->columns, GINT_TO_POINTER(field->id), GUINT_TO_POINTER(rows->texts->len));
    g_string_append_printf(filter, " || %s", name);
}

/* The filter holds for every packet. It names all fields, so that they are made. */
static void
listen(rows_t *rows, char *const *names)
{
    GString *filter = g_string_new("frame");
    GString *error;

    for (; *names != NULL; names++)
        add_column(rows, *names, filter);
    write_row(rows);
    error = register_tap_listener("frame", rows, filter->str, TL_REQUIRES_PROTO_TREE, NULL, packet, NULL,
                                  free_rows);
    g_string_free(filter, TRUE);
    if (error == NULL)
        return;
    fprintf(stderr, "%s: %s\n", NAME, error->str);
    g_string_free(error, TRUE);
    free_rows(rows);
}

static compat_stat_begun
begin(const char *asked, void *data _U_)
{
    char **names = g_strsplit(asked + strlen(NAME), ",", 0);

    listen(new_rows(), names);
    g_strfreev(names);
    COMPAT_STAT_BEGUN(true);
}

static stat_tap_ui ui = {
    .group = REGISTER_PACKET_STAT_GROUP_UNSORTED,
    .title = "SIS rows",
    .cli_string = NAME,
    .tap_init_cb = begin,
};

void
sis_rows_register(void)
{
    register_stat_tap_ui(&ui, NULL);
}
