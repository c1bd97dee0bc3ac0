/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Parameters: how they are written, and what the user's table and the built-in one say about them. What
 * the bus says about them is learned in learned.c. */

#include "parameters/parameters.h"

#include <epan/uat.h>
#include <errno.h>

#define NUMBER_BITS 0x0FFF
#define SET_SHIFT   12
#define SET_BITS    7
#define BIT_15      0x8000

/* Only parameters of drives have it (fig. 8-3); two idents never have the same text. */
#define BIT_15_TEXT " with bit 15"

typedef enum { KIND_S, KIND_P, KIND_A, KIND_C } kind_t;

static const value_string kinds[] = {
    {KIND_S, "S"}, {KIND_P, "P"}, {KIND_A, "A"}, {KIND_C, "C"}, {0, NULL},
};

/* Kind and set 0; names, and the unit where it is said, from the SIS definition and SYNAX' interface manual.
 */
static const struct {
    kind_t kind;
    uint16_t number;
    const char *name;
    const char *unit;
} built_in[] = {
    {KIND_S, 44, "Velocity data scaling type", NULL},
    {KIND_S, 103, "Modulo value", NULL},
    {KIND_P, 12, "C300 Command set absolute measuring", NULL},
    {KIND_P, 40, "Scaling of velocities, analog output channel 1", NULL},
    {KIND_P, 72, "Cam shaft profile", NULL},
    {KIND_A, 4, "Additive position command value", "deg"},
    {KIND_A, 56, "Set-up position 0", NULL},
    {KIND_A, 60, "Fine adjustment", NULL},
    {KIND_C, 1, "Switch-on delay time", "ms"},
    {KIND_C, 29, "Jogging time constant", NULL},
    {KIND_C, 33, "Host communication, control word", NULL},
    {KIND_C, 46, "General diagnostic flag", NULL},
    {KIND_C, 57, "Error number of the serial interface", NULL},
    {KIND_C, 58, "Configuration list of data block 101", NULL},
    {KIND_C, 65, "Configuration list of data block 108", NULL},
    {KIND_C, 66, "Master axis, position feedback value", NULL},
    {KIND_C, 124, "Timeout of the service channel", NULL},
    {KIND_C, 125, "Fieldbus address", NULL},
    {KIND_C, 127, "Fieldbus/Ethernet 1, configuration list of the process input data", NULL},
    {KIND_C, 129, "Fieldbus control bits", NULL},
    {KIND_C, 157, "Data blocks, ident numbers of the configurable S and P parameters", NULL},
    {KIND_C, 193, "PPC, standard gateway", NULL},
    {KIND_C, 194, "PPC, UDP ports", NULL},
};

/* A row of the user's table "SIS parameters". */
typedef struct {
    unsigned kind;
    char *number; /* "0044", or with its parameter set "2-0012" */
    char *name;
    char *unit;
    unsigned attribute; /* 0: not known; no real attribute is 0 */
} row_t;

static row_t *rows;
static unsigned row_count;

/* Both tables, by type and number; the user's rows take precedence over the built-in ones. */
static GHashTable *table;

const char *
sis_ident_text(wmem_allocator_t *scope, sis_ident_t ident)
{
    static const char letters[] = {'S', 'A', 'C'};
    char text[] = "S-0-0000";
    unsigned set = ident.number >> SET_SHIFT & SET_BITS, number = ident.number & NUMBER_BITS;

    if (ident.type >= sizeof letters)
        return wmem_strdup_printf(scope, "type%u-%u-%04u%s", ident.type, set, number,
                                  ident.number & BIT_15 ? BIT_15_TEXT : "");
    text[0] = ident.type == 0 && ident.number & BIT_15 ? 'P' : letters[ident.type];
    text[2] = (char)('0' + set);
    for (unsigned place = 7; place > 3; place--, number /= 10)
        text[place] = (char)('0' + number % 10);
    return ident.type > 0 && ident.number & BIT_15 ? wmem_strconcat(scope, text, BIT_15_TEXT, NULL)
                                                   : wmem_strdup(scope, text);
}

static void *
table_key(sis_ident_t ident)
{
    return GUINT_TO_POINTER((unsigned)ident.type << 16 | ident.number);
}

static sis_ident_t
make_ident(kind_t kind, unsigned set, unsigned number)
{
    static const uint8_t types[] = {0, 0, 1, 2};
    sis_ident_t ident = {types[kind], (uint16_t)(set << SET_SHIFT | number)};

    if (kind == KIND_P)
        ident.number |= BIT_15;
    return ident;
}

/* "0044" or "2-0012". */
static bool
parse_number(const char *text, unsigned *set, unsigned *number)
{
    char *end;
    unsigned long value;

    *set = 0;
    if (text == NULL || !g_ascii_isdigit(text[0]))
        return false;
    if (text[1] == '-') {
        *set = (unsigned)(text[0] - '0');
        text += 2;
    }
    value = strtoul(text, &end, 10);
    *number = (unsigned)value;
    return g_ascii_isdigit(text[0]) && *end == '\0' && *set <= SET_BITS && value <= NUMBER_BITS;
}

sis_known_t
sis_known_from_tables(sis_ident_t ident)
{
    static const sis_known_t nothing = {0};
    const sis_known_t *known = table != NULL ? g_hash_table_lookup(table, table_key(ident)) : NULL;

    return known != NULL ? *known : nothing;
}

static void
add_built_in(void)
{
    for (unsigned i = 0; i < array_length(built_in); i++) {
        sis_known_t *known = g_new0(sis_known_t, 1);

        known->name = built_in[i].name;
        known->name_from = SIS_BUILT_IN;
        known->unit = built_in[i].unit;
        known->unit_from = built_in[i].unit != NULL ? SIS_BUILT_IN : SIS_FROM_NOWHERE;
        g_hash_table_insert(table, table_key(make_ident(built_in[i].kind, 0, built_in[i].number)), known);
    }
}

static void
add_row(const row_t *row)
{
    unsigned set, number;
    sis_known_t *known;
    sis_ident_t ident;

    if (!parse_number(row->number, &set, &number))
        return;
    ident = make_ident((kind_t)row->kind, set, number);
    known = g_new0(sis_known_t, 1);
    *known = sis_known_from_tables(ident);
    if (row->name != NULL && row->name[0] != '\0') {
        known->name = row->name;
        known->name_from = SIS_FROM_TABLE;
    }
    if (row->unit != NULL && row->unit[0] != '\0') {
        known->unit = row->unit;
        known->unit_from = SIS_FROM_TABLE;
    }
    if (row->attribute != 0) {
        known->attribute = row->attribute;
        known->attribute_from = SIS_FROM_TABLE;
    }
    g_hash_table_replace(table, table_key(ident), known);
}

static void
make_table(void)
{
    if (table != NULL)
        g_hash_table_destroy(table);
    table = g_hash_table_new_full(NULL, NULL, NULL, g_free);
    add_built_in();
    for (unsigned i = 0; i < row_count; i++)
        add_row(&rows[i]);
}

/* clang-format off */
UAT_VS_DEF(rows, kind, row_t, unsigned, KIND_S, "S")
UAT_CSTRING_CB_DEF(rows, number, row_t)
UAT_CSTRING_CB_DEF(rows, name, row_t)
UAT_CSTRING_CB_DEF(rows, unit, row_t)
UAT_HEX_CB_DEF(rows, attribute, row_t)
/* clang-format on */

static void *
copy_row(void *to, const void *from, size_t size _U_)
{
    const row_t *old = from;
    row_t *copy = to;

    *copy = *old;
    copy->number = g_strdup(old->number);
    copy->name = g_strdup(old->name);
    copy->unit = g_strdup(old->unit);
    return copy;
}

static void
free_row(void *data)
{
    row_t *row = data;

    g_free(row->number);
    g_free(row->name);
    g_free(row->unit);
}

static compat_uat_bool
check_row(void *data, char **error)
{
    const row_t *row = data;
    unsigned set, number;

    *error = NULL;
    if (parse_number(row->number, &set, &number))
        return true;
    *error = g_strdup("A number is 0 to 4095, with or without its parameter set: 0044, 2-0012");
    return false;
}

void
sis_parameters_register(module_t *module)
{
    static uat_field_t columns[] = {
        UAT_FLD_VS(rows, kind, "Kind", kinds, "S, P (of drives), A or C (of controls)"),
        UAT_FLD_CSTRING(rows, number, "Number", "0044, or with its parameter set 2-0012"),
        UAT_FLD_CSTRING(rows, name, "Name", "What the parameter is called"),
        UAT_FLD_CSTRING(rows, unit, "Unit", "Unit of its operating data"),
        UAT_FLD_HEX(rows, attribute, "Attribute",
                    "Length, format and decimal places (element 3), 0: not known"),
        UAT_END_FIELDS};
    uat_t *uat =
        uat_new("SIS parameters", sizeof(row_t), "sis_parameters", TRUE, &rows, &row_count,
                UAT_AFFECTS_DISSECTION, NULL, copy_row, check_row, free_row, make_table, make_table, columns);

    prefs_register_uat_preference(
        module, "parameters", "Parameters",
        "Names, units and attributes of parameters; what the bus itself says goes first", uat);
    make_table();
}
