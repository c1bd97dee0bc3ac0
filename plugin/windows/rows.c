/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A row for each packet (`tshark -q -z sis,rows,FIELD,FIELD...`): as `-T fields -E header=y -E
 * aggregator=/x1f` prints it, but only these fields are made, and nothing is put into words. A field that
 * nobody knows, or that is named again, is left out. */
#include "parts.h"

#include <errno.h>
#include <stdio.h>

#include <epan/epan_dissect.h>
#include <epan/print.h>
#include <epan/stat_tap_ui.h>
#include <epan/tap.h>
#include <epan/to_str.h>

#include "sertap/record.h"

#define NAME  "sis,rows"
#define JOINT '\x1f' /* between several values of a field */

/* Appends the values that a field has in a packet. */
typedef void (*say_t)(GString *text, packet_info *pinfo);

typedef struct {
    say_t say;     /* NULL: its values come from the tree */
    GString *text; /* of the present packet */
} column_t;

typedef struct {
    GHashTable *columns; /* by field */
    GPtrArray *row;      /* the same, in their order */
    GString *line;       /* as it is printed, at once: each call of stdio takes a lock */
    epan_dissect_t *packet;
} rows_t;

static void
free_column(void *data)
{
    column_t *column = data;

    g_string_free(column->text, TRUE);
    g_free(column);
}

static void
free_rows(void *data)
{
    rows_t *rows = data;

    g_hash_table_destroy(rows->columns);
    g_ptr_array_free(rows->row, TRUE);
    g_string_free(rows->line, TRUE);
    g_free(rows);
}

static rows_t *
new_rows(void)
{
    rows_t *rows = g_new0(rows_t, 1);

    rows->columns = g_hash_table_new(NULL, NULL);
    rows->row = g_ptr_array_new_with_free_func(free_column);
    rows->line = g_string_new(NULL);
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

static void
append_joint(GString *text)
{
    if (text->len > 0)
        g_string_append_c(text, JOINT);
}

/* No text of a capture ends a value, a column or a row. */
static void
append_value(GString *text, const char *value)
{
    append_joint(text);
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
say_number(GString *text, packet_info *pinfo)
{
    g_string_append_printf(text, "%u", pinfo->num);
}

static void
say_time(GString *text, packet_info *pinfo, const nstime_t *elapsed)
{
    if (pinfo->presence_flags & PINFO_HAS_TS)
        g_string_append(text, rel_time_to_secs_str(pinfo->pool, elapsed));
}

static void
say_epoch(GString *text, packet_info *pinfo)
{
    say_time(text, pinfo, &pinfo->abs_ts);
}

static void
say_relative(GString *text, packet_info *pinfo)
{
    say_time(text, pinfo, &pinfo->rel_ts);
}

static void
say_interface(GString *text, packet_info *pinfo)
{
    const char *name = compat_interface_name(pinfo);

    if (name != NULL)
        append_value(text, name);
}

static void
say_characters(GString *text, packet_info *pinfo)
{
    const sertap_record_t *record = sertap_record(pinfo);

    for (unsigned i = 0; record != NULL && i < record->timed; i++) {
        append_joint(text);
        g_string_append_printf(text, "0x%02x", compat_get_uint8(record->tvb, record->data_offset + i));
    }
}

static void
say_intervals(GString *text, packet_info *pinfo)
{
    const sertap_record_t *record = sertap_record(pinfo);

    for (unsigned i = 0; record != NULL && i < record->timed; i++) {
        if (sertap_flags(record, i) & SERTAP_INTERVAL_UNKNOWN)
            continue;
        append_joint(text);
        g_string_append(text, sertap_decimal_text(pinfo->pool, sertap_interval(record, i), 1, 9, ""));
    }
}

/* Fields that need no tree. For the others of the packet and of its characters, Wireshark would make many
 * items. */
static const struct {
    const char *name;
    say_t say;
} plain[] = {
    {"frame.number", say_number},          {"frame.time_epoch", say_epoch},
    {"frame.time_relative", say_relative}, {"frame.interface_name", say_interface},
    {"sertap.character", say_characters},  {"sertap.interval", say_intervals},
};

static say_t
find_plain(const char *name)
{
    for (unsigned i = 0; i < array_length(plain); i++) {
        if (strcmp(plain[i].name, name) == 0)
            return plain[i].say;
    }
    return NULL;
}

static void
add_values(proto_node *node, void *data)
{
    rows_t *rows = data;
    field_info *field = PNODE_FINFO(node);
    column_t *column = NULL;

    if (field != NULL)
        column = g_hash_table_lookup(rows->columns, GINT_TO_POINTER(field->hfinfo->id));
    if (column != NULL && column->say == NULL) {
        char *value = get_node_field_value(field, rows->packet);

        if (value != NULL) /* Wireshark has none for a text that stands for no bytes */
            append_value(column->text, value);
        g_free(value);
    }
    proto_tree_children_foreach(node, add_values, rows);
}

/* Writes the texts of all columns, and empties them. */
static void
write_row(rows_t *rows)
{
    for (unsigned i = 0; i < rows->row->len; i++) {
        GString *text = ((column_t *)g_ptr_array_index(rows->row, i))->text;

        if (i > 0)
            g_string_append_c(rows->line, '\t');
        g_string_append_len(rows->line, text->str, (gssize)text->len);
        g_string_truncate(text, 0);
    }
    g_string_append_c(rows->line, '\n');
    fwrite(rows->line->str, 1, rows->line->len, stdout);
    g_string_truncate(rows->line, 0);
}

static tap_packet_status
packet(void *data, packet_info *pinfo, epan_dissect_t *edt, const void *tapped _U_, tap_flags_t flags _U_)
{
    rows_t *rows = data;

    rows->packet = edt;
    proto_tree_children_foreach(edt->tree, add_values, rows);
    for (unsigned i = 0; i < rows->row->len; i++) {
        column_t *column = g_ptr_array_index(rows->row, i);

        if (column->say != NULL)
            column->say(column->text, pinfo);
    }
    write_row(rows);
    return TAP_PACKET_DONT_REDRAW;
}

static void
finish(void *data _U_)
{
    if (fflush(stdout) != 0 || ferror(stdout))
        fprintf(stderr, NAME ": rows are missing in standard output: %s\n", g_strerror(errno));
}

/* The filter holds for every packet. It names the fields that the tree must have, so that they are made. */
static void
add_column(rows_t *rows, const char *name, GString *filter)
{
    const header_field_info *field = proto_registrar_get_byname(name);
    column_t *column;

    if (field == NULL || g_hash_table_contains(rows->columns, GINT_TO_POINTER(field->id)))
        return;
    column = g_new(column_t, 1);
    *column = (column_t){find_plain(name), g_string_new(name)};
    g_ptr_array_add(rows->row, column);
    g_hash_table_insert(rows->columns, GINT_TO_POINTER(field->id), column);
    if (column->say != NULL)
        return;
    if (filter->len == 0)
        g_string_printf(filter, "!%s", name);
    g_string_append_printf(filter, " || %s", name);
}

static void
listen(rows_t *rows, char *const *names)
{
    GString *filter = g_string_new(NULL);
    GString *error;

    for (; *names != NULL; names++)
        add_column(rows, *names, filter);
    write_row(rows);
    error = register_tap_listener("frame", rows, filter->len > 0 ? filter->str : NULL, TL_REQUIRES_PROTO_TREE,
                                  NULL, packet, finish, free_rows);
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
windows_rows_register(void)
{
    register_stat_tap_ui(&ui, NULL);
}
