/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Parameters: how they are written, and what the user's table, the built-in one and Wireshark's say about
 * them. What the bus says about them is learned in learned.c. */
#include "parameters/parameters.h"

#include <errno.h>

#include <epan/prefs.h>
#include <epan/uat.h>

#include "parts.h"
#include "protocol/codes.h"

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

/* Names of set 0, and the unit where it is said. No P parameters: what these are depends on the device. No S
 * parameters: Wireshark has their names. */
static const struct {
    kind_t kind;
    const value_string *names;
    uint16_t with_unit; /* of this parameter */
    const char *unit;
} built_in[] = {{KIND_A, sis_parameters_a, 4, "deg"}, {KIND_C, sis_parameters_c, 1, "ms"}};

/* A row of the user's table "SIS parameters". */
typedef struct {
    unsigned kind;
    char *number; /* "0044", or with its parameter set "2-0012" */
    char *name;
    char *unit;
    unsigned attribute; /* 0: not known; no real attribute is 0 */
    char *minimum;
    char *maximum;
    char *station; /* "3" or "3/2/8"; empty: every station */
    char *bits;    /* "0=Ready, 15=On" */
} row_t;

static row_t *rows;
static unsigned row_count;

/* A parameter of a station; without a station, of every one. */
typedef struct {
    sis_place_t place; /* its device does not count */
    sis_ident_t ident;
} row_key_t;

/* All tables, by row_key_t; the user's rows take precedence over the others. Made when it is first asked: by
 * then, all dissectors have registered their fields. */
static GHashTable *table;
static bool has_stations; /* in the user's rows */

static const char *
plain_text(wmem_allocator_t *scope, sis_ident_t ident)
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

const char *
sis_ident_text(wmem_allocator_t *scope, sis_ident_t ident)
{
    const char *text = plain_text(scope, ident);

    return ident.structure == 0
               ? text
               : wmem_strdup_printf(scope, "%s.%u.%u", text, ident.structure >> 8, ident.structure & 0xFF);
}

static unsigned
hash_key(const void *data)
{
    const row_key_t *key = data;
    unsigned stations = 0;

    for (unsigned i = 0; i < key->place.path_length; i++)
        stations = stations * 31 + key->place.path[i] + 1;
    return (((unsigned)key->ident.structure << 8 ^ key->ident.type) << 16 ^ key->ident.number) +
           stations * 7919;
}

static gboolean
are_keys_equal(const void *a, const void *b)
{
    const row_key_t *one = a, *other = b;

    return one->ident.type == other->ident.type && one->ident.number == other->ident.number &&
           one->ident.structure == other->ident.structure &&
           one->place.path_length == other->place.path_length &&
           memcmp(one->place.path, other->place.path, sizeof one->place.path) == 0;
}

/* An ident with the bits that tell its kind. */
static sis_ident_t
of_kind(kind_t kind, sis_ident_t ident)
{
    static const uint8_t types[] = {0, 0, 1, 2};

    ident.type = types[kind];
    if (kind == KIND_P)
        ident.number |= BIT_15;
    return ident;
}

static bool
take_digits(const char **at, unsigned most, unsigned *value)
{
    char *end;
    unsigned long number;

    if (!g_ascii_isdigit(**at))
        return false;
    number = strtoul(*at, &end, 10);
    *value = (unsigned)number;
    *at = end;
    return number <= most;
}

/* ".0.136": instance and element of a structure. */
static bool
take_structure(const char **at, sis_ident_t *ident)
{
    unsigned instance, element;

    if (*(*at)++ != '.' || !take_digits(at, UINT8_MAX, &instance) || *(*at)++ != '.' ||
        !take_digits(at, UINT8_MAX, &element))
        return false;
    ident->structure = (uint16_t)(instance << 8 | element);
    return true;
}

/* "0044", with its parameter set "2-0012", with a structure "0390.0.136". */
static bool
take_number(const char **at, sis_ident_t *ident)
{
    unsigned set = 0, number;

    *ident = (sis_ident_t){0};
    if (g_ascii_isdigit((*at)[0]) && (*at)[1] == '-') {
        set = (unsigned)((*at)[0] - '0');
        *at += 2;
    }
    if (set > SET_BITS || !take_digits(at, NUMBER_BITS, &number))
        return false;
    ident->number = (uint16_t)(set << SET_SHIFT | number);
    return **at != '.' || take_structure(at, ident);
}

static bool
parse_number(const char *text, sis_ident_t *ident)
{
    return text != NULL && take_number(&text, ident) && *text == '\0';
}

/* "3", or behind routers "3/2/8"; the place behind it. False: it is no path. */
static bool
take_place(const char **text, sis_place_t *place)
{
    unsigned station;

    *place = (sis_place_t){0};
    for (;;) {
        if (place->path_length == array_length(place->path) || !take_digits(text, UINT8_MAX, &station))
            return false;
        place->path[place->path_length++] = (uint8_t)station;
        if (**text != '/')
            return true;
        (*text)++;
    }
}

const char *
sis_place_text(wmem_allocator_t *scope, const sis_place_t *place)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");

    for (unsigned i = 0; i < place->path_length; i++)
        wmem_strbuf_append_printf(text, "%s%u", i > 0 ? "/" : "", place->path[i]);
    return wmem_strbuf_get_str(text);
}

#define MOST_BIT 63

bool
sis_bit_take(const char **bits, sis_bit_t *bit)
{
    *bits += strspn(*bits, " ");
    if (!take_digits(bits, MOST_BIT, &bit->number) || *(*bits)++ != '=')
        return false;
    bit->name = *bits;
    bit->length = (unsigned)strcspn(*bits, ",");
    *bits += bit->length;
    if (**bits == ',')
        (*bits)++;
    return bit->length > 0;
}

static bool
are_bits(const char *text)
{
    sis_bit_t bit;

    while (text != NULL && *text != '\0') {
        if (!sis_bit_take(&text, &bit))
            return false;
    }
    return true;
}

/* No text: every station. */
static bool
parse_station(const char *text, sis_place_t *place)
{
    *place = (sis_place_t){0};
    return text == NULL || text[0] == '\0' || (take_place(&text, place) && *text == '\0');
}

const char *
sis_ident_parse(const char *text, sis_ident_t *ident)
{
    static const char letters[] = "SPAC"; /* by kind_t */
    const char *letter = text[0] != '\0' ? strchr(letters, text[0]) : NULL;

    if (letter == NULL || text[1] != '-' || !g_ascii_isdigit(text[2]) || text[3] != '-' ||
        strspn(text + 4, "0123456789") != 4)
        return NULL;
    text += 2;
    if (!take_number(&text, ident))
        return NULL;
    *ident = of_kind((kind_t)(letter - letters), *ident);
    return text;
}

static void
insert(const row_key_t *key, const sis_known_t *known)
{
    g_hash_table_replace(table, g_memdup2(key, sizeof *key), g_memdup2(known, sizeof *known));
}

static sis_known_t
find(const row_key_t *key)
{
    static const sis_known_t nothing = {0};
    const sis_known_t *known;

    if (has_stations && key->place.path_length > 0 && (known = g_hash_table_lookup(table, key)) != NULL)
        return *known;
    known = g_hash_table_lookup(table, &(row_key_t){.ident = key->ident});
    return known != NULL ? *known : nothing;
}

/* The text of a number in the table of a field, whichever form this Wireshark has. */
static const char *
field_text(const header_field_info *field, uint32_t number)
{
    bool is_long = field->display & BASE_VAL64_STRING;

    if (field->display & BASE_EXT_STRING)
        return is_long ? try_val64_to_str_ext(number, (val64_string_ext *)(uintptr_t)field->strings)
                       : try_val_to_str_ext(number, (value_string_ext *)(uintptr_t)field->strings);
    return is_long ? try_val64_to_str(number, field->strings) : try_val_to_str(number, field->strings);
}

/* Names of S parameters, if this Wireshark has its dissector for SERCOS III. Not number 0, a dummy. */
static void
add_standard(void)
{
    const header_field_info *field = proto_registrar_get_byname("siii.mdt.svch.idn");

    if (field == NULL || field->strings == NULL || field->type != FT_UINT32 ||
        FIELD_DISPLAY(field->display) == BASE_CUSTOM ||
        (field->display & (BASE_RANGE_STRING | BASE_UNIT_STRING)))
        return; /* names in a form that no version has had */
    for (unsigned number = 1; number <= NUMBER_BITS; number++) {
        sis_known_t known = {.name = field_text(field, number), .name_from = SIS_FROM_STANDARD};

        if (known.name != NULL)
            insert(&(row_key_t){.ident.number = (uint16_t)number}, &known);
    }
}

static void
add_built_in(void)
{
    for (unsigned i = 0; i < array_length(built_in); i++) {
        for (const value_string *name = built_in[i].names; name->strptr != NULL; name++) {
            sis_ident_t ident = of_kind(built_in[i].kind, (sis_ident_t){.number = (uint16_t)name->value});
            sis_known_t known = {.name = name->strptr, .name_from = SIS_BUILT_IN};

            if (name->value == built_in[i].with_unit) {
                known.unit = built_in[i].unit;
                known.unit_from = SIS_BUILT_IN;
            }
            insert(&(row_key_t){.ident = ident}, &known);
        }
    }
}

static void
add_text(const char **known, sis_source_t *from, const char *text)
{
    if (text == NULL || text[0] == '\0')
        return;
    *known = text;
    *from = SIS_FROM_TABLE;
}

static void
add_row(const row_t *row, const row_key_t *key)
{
    sis_known_t known = find(key);

    add_text(&known.name, &known.name_from, row->name);
    add_text(&known.unit, &known.unit_from, row->unit);
    add_text(&known.minimum, &known.minimum_from, row->minimum);
    add_text(&known.maximum, &known.maximum_from, row->maximum);
    if (row->bits != NULL && row->bits[0] != '\0')
        known.bits = row->bits;
    if (row->attribute != 0) {
        known.attribute = row->attribute;
        known.attribute_from = SIS_FROM_TABLE;
    }
    insert(key, &known);
}

/* The rows of every station, or those of one. The latter complete the former. */
static void
add_rows(bool of_one)
{
    for (unsigned i = 0; i < row_count; i++) {
        row_key_t key;

        if (!parse_number(rows[i].number, &key.ident) || !parse_station(rows[i].station, &key.place) ||
            (key.place.path_length > 0) != of_one)
            continue;
        key.ident = of_kind((kind_t)rows[i].kind, key.ident);
        has_stations |= of_one;
        add_row(&rows[i], &key);
    }
}

static void
make_table(void)
{
    table = g_hash_table_new_full(hash_key, are_keys_equal, g_free, g_free);
    has_stations = false;
    add_standard();
    add_built_in();
    add_rows(false);
    add_rows(true);
}

static void
forget_table(void)
{
    g_clear_pointer(&table, g_hash_table_destroy);
}

sis_known_t
sis_known_from_tables(const sis_place_t *place, sis_ident_t ident)
{
    row_key_t key = {.ident = ident};

    if (table == NULL)
        make_table();
    if (place != NULL)
        key.place = *place;
    return find(&key);
}

/* clang-format off */
UAT_VS_DEF(rows, kind, row_t, unsigned, KIND_S, "S")
UAT_CSTRING_CB_DEF(rows, number, row_t)
UAT_CSTRING_CB_DEF(rows, name, row_t)
UAT_CSTRING_CB_DEF(rows, unit, row_t)
UAT_HEX_CB_DEF(rows, attribute, row_t)
UAT_CSTRING_CB_DEF(rows, minimum, row_t)
UAT_CSTRING_CB_DEF(rows, maximum, row_t)
UAT_CSTRING_CB_DEF(rows, station, row_t)
UAT_CSTRING_CB_DEF(rows, bits, row_t)
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
    copy->minimum = g_strdup(old->minimum);
    copy->maximum = g_strdup(old->maximum);
    copy->station = g_strdup(old->station);
    copy->bits = g_strdup(old->bits);
    return copy;
}

static void
free_row(void *data)
{
    row_t *row = data;

    g_free(row->number);
    g_free(row->name);
    g_free(row->unit);
    g_free(row->minimum);
    g_free(row->maximum);
    g_free(row->station);
    g_free(row->bits);
}

static compat_uat_bool
check_row(void *data, char **error)
{
    const row_t *row = data;
    sis_ident_t ident;
    sis_place_t place;

    *error = NULL;
    if (!parse_number(row->number, &ident))
        *error = g_strdup(
            "A number is 0 to 4095, with or without parameter set and structure: 0044, 2-0012, 0390.0.136");
    else if (!parse_station(row->station, &place))
        *error = g_strdup("A station is an address, with or without the routers before it: 3, 3/2/8");
    else if (!are_bits(row->bits))
        *error = g_strdup("Names of bits are written 0=Ready, 15=On");
    return *error == NULL;
}

void
sis_parameters_register(void)
{
    static uat_field_t columns[] = {
        UAT_FLD_VS(rows, kind, "Kind", kinds, "S, P (of drives), A or C (of controls)"),
        UAT_FLD_CSTRING(rows, number, "Number",
                        "0044; with its parameter set 2-0012; with a structure 0390.0.136"),
        UAT_FLD_CSTRING(rows, name, "Name", "What the parameter is called"),
        UAT_FLD_CSTRING(rows, unit, "Unit", "Unit of its operating data"),
        UAT_FLD_HEX(rows, attribute, "Attribute",
                    "Length, format and decimal places (element 3), 0: not known"),
        UAT_FLD_CSTRING(rows, minimum, "Minimum", "Least value, with its unit"),
        UAT_FLD_CSTRING(rows, maximum, "Maximum", "Greatest value, with its unit"),
        UAT_FLD_CSTRING(rows, station, "Station", "3, behind routers 3/2/8; empty: every station"),
        UAT_FLD_CSTRING(rows, bits, "Bits", "Names of bits: 0=Ready, 15=On"),
        UAT_END_FIELDS};
    /* Older files have five columns. */
    static const char *defaults[] = {NULL, NULL, NULL, NULL, NULL, "", "", "", "", NULL};
    uat_t *uat = uat_new("SIS parameters", sizeof(row_t), "sis_parameters", TRUE, &rows, &row_count,
                         UAT_AFFECTS_DISSECTION, NULL, copy_row, check_row, free_row, forget_table,
                         forget_table, columns);

    uat_set_default_values(uat, defaults);
    prefs_register_uat_preference(
        prefs_find_module("sis"), "parameters", "Parameters",
        "Names, units and attributes of parameters; what the bus itself says goes first", uat);
}
