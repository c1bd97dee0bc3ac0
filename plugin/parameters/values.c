/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The elements of a parameter: attribute bit by bit, values scaled and with their unit, lists element by
 * element. The SIS documents do not describe them; SERCOS, IEC 61491, does. */
#include "parameters/values.h"

#include <math.h>

#include "protocol/fields.h"
#include "protocol/limits.h"

#define ATTRIBUTE_SIZE 4
#define LIST_HEADER    4 /* actual and maximum length, two bytes each */

/* Bits of the attribute. */
#define FACTOR(attribute)      ((attribute)&0xFFFF)
#define LENGTH_CODE(attribute) ((attribute) >> 16 & 7)
#define IS_COMMAND(attribute)  ((attribute) >> 19 & 1)
#define FORMAT(attribute)      ((attribute) >> 20 & 7)
#define DECIMALS(attribute)    ((attribute) >> 24 & 15)
#define UNDEFINED_BITS         0x80800000u

/* How to read the elements of some data; made from an attribute. */
typedef struct {
    unsigned size; /* of one value: 1, 2, 4 or 8 bytes */
    bool is_list;
    bool is_command;
    sis_format_t format;
    unsigned decimals;
    unsigned factor;
    const char *unit;         /* NULL: none or unknown */
    const char *bits;         /* their names; NULL: unknown */
    unsigned encoding;        /* ENC_LITTLE_ENDIAN or ENC_BIG_ENDIAN */
    const sis_place_t *place; /* whose it is; NULL: unknown */
} layout_t;

/* The sizes in bytes, added up, that a value of each format can have. */
static const uint8_t format_sizes[] = {
    [SIS_FORMAT_BINARY] = 1 + 2 + 4 + 8,
    [SIS_FORMAT_UNSIGNED] = 1 + 2 + 4 + 8,
    [SIS_FORMAT_SIGNED] = 1 + 2 + 4 + 8,
    [SIS_FORMAT_HEXADECIMAL] = 1 + 2 + 4 + 8,
    [SIS_FORMAT_TEXT] = 1,
    [SIS_FORMAT_IDENT] = 2 + 4,
    [SIS_FORMAT_FLOATING] = 4 + 8,
    [SIS_FORMAT_TIME] = 8,
};

static bool
is_described(const layout_t *layout)
{
    return layout->size & format_sizes[layout->format];
}

/* False for undefined length codes. */
static bool
read_layout(const sis_known_t *known, const sis_element_data_t *data, layout_t *layout)
{
    static const unsigned sizes[] = {0, 2, 4, 8, 1, 2, 4, 8};
    uint32_t attribute = known->attribute;

    if (known->attribute_from == SIS_FROM_NOWHERE)
        return false;
    layout->size = sizes[LENGTH_CODE(attribute)];
    layout->is_list = LENGTH_CODE(attribute) >= 4;
    layout->is_command = IS_COMMAND(attribute);
    layout->format = FORMAT(attribute);
    layout->decimals = DECIMALS(attribute);
    layout->factor = MAX(FACTOR(attribute), 1u);
    layout->unit = known->unit;
    layout->bits = known->bits;
    layout->encoding = data->encoding;
    layout->place = data->place;
    return layout->size > 0;
}

static uint64_t
get_number(tvbuff_t *tvb, unsigned offset, unsigned size, unsigned encoding)
{
    uint64_t value = 0;

    for (unsigned i = 0; i < size; i++)
        value = value << 8 | compat_get_uint8(tvb, offset + (encoding == ENC_BIG_ENDIAN ? i : size - 1 - i));
    return value;
}

/* With a point in every locale: people filter for this text. */
static const char *
double_text(wmem_allocator_t *scope, int digits, double value)
{
    char format[8], text[G_ASCII_DTOSTR_BUF_SIZE];

    snprintf(format, sizeof format, "%%.%dg", digits);
    return wmem_strdup(scope, g_ascii_formatd(text, sizeof text, format, value));
}

/* Fixed point: exact to the decimal places. */
static const char *
decimal_text(wmem_allocator_t *scope, uint64_t magnitude, bool is_negative, const layout_t *layout)
{
    uint64_t scaled, unit = 1;
    const char *sign = is_negative ? "-" : "";

    for (unsigned i = 0; i < layout->decimals; i++)
        unit *= 10;
    if (!g_uint64_checked_mul(&scaled, magnitude, layout->factor))
        return wmem_strdup_printf(scope, "%s%s", sign,
                                  double_text(scope, 17, (double)magnitude * layout->factor / (double)unit));
    if (layout->decimals == 0)
        return wmem_strdup_printf(scope, "%s%" PRIu64, sign, scaled);
    return wmem_strdup_printf(scope, "%s%" PRIu64 ".%0*" PRIu64, sign, scaled / unit, (int)layout->decimals,
                              scaled % unit);
}

static const char *
signed_text(wmem_allocator_t *scope, uint64_t raw, const layout_t *layout)
{
    uint64_t sign_bit = UINT64_C(1) << (layout->size * 8 - 1);
    uint64_t mask = sign_bit | (sign_bit - 1);

    if (raw & sign_bit)
        return decimal_text(scope, (~raw + 1) & mask, true, layout);
    return decimal_text(scope, raw, false, layout);
}

static const char *
float_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, const layout_t *layout)
{
    double value = layout->size == 8 ? tvb_get_ieee_double(tvb, offset, layout->encoding)
                                     : tvb_get_ieee_float(tvb, offset, layout->encoding);

    return double_text(scope, layout->size == 8 ? 15 : 7, value);
}

static const char *
binary_text(wmem_allocator_t *scope, uint64_t raw, unsigned size)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "0b");

    for (unsigned bit = size * 8; bit-- > 0;) {
        wmem_strbuf_append_c(text, raw >> bit & 1 ? '1' : '0');
        if (bit > 0 && bit % 4 == 0)
            wmem_strbuf_append_c(text, ' ');
    }
    return wmem_strbuf_get_str(text);
}

/* An ident of two bytes, or of four: two of its structure in the upper half. False: it is something else. */
static bool
read_ident(const layout_t *layout, uint64_t raw, sis_ident_t *ident)
{
    *ident = (sis_ident_t){.number = (uint16_t)raw, .structure = (uint16_t)(raw >> 16)};
    return layout->format == SIS_FORMAT_IDENT && is_described(layout);
}

#define NS_IN_SECOND 1000000000u

/* Four bytes of seconds since 1970 (UTC), then four of nanoseconds, as Rexroth's MLPI describes the attribute
 * (mlpiParameterLib.h). NULL: it is no time. */
static const char *
time_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, const layout_t *layout)
{
    uint32_t ns = (uint32_t)get_number(tvb, offset + 4, 4, layout->encoding);
    GDateTime *utc;
    const char *text;

    if (ns >= NS_IN_SECOND)
        return NULL;
    utc = g_date_time_new_from_unix_utc((int64_t)get_number(tvb, offset, 4, layout->encoding));
    text = wmem_strdup_printf(scope, "%04d-%02d-%02d %02d:%02d:%02d.%09u", g_date_time_get_year(utc),
                              g_date_time_get_month(utc), g_date_time_get_day_of_month(utc),
                              g_date_time_get_hour(utc), g_date_time_get_minute(utc),
                              g_date_time_get_second(utc), ns);
    g_date_time_unref(utc);
    return text;
}

/* A number without its unit; in hexadecimal if no document describes how to write it. */
static const char *
number_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, const layout_t *layout)
{
    uint64_t raw = get_number(tvb, offset, layout->size, layout->encoding);
    const char *utc;
    sis_ident_t ident;

    switch (is_described(layout) ? layout->format : SIS_FORMAT_HEXADECIMAL) {
    case SIS_FORMAT_BINARY:
        return binary_text(scope, raw, layout->size);
    case SIS_FORMAT_UNSIGNED:
        return decimal_text(scope, raw, false, layout);
    case SIS_FORMAT_SIGNED:
        return signed_text(scope, raw, layout);
    case SIS_FORMAT_IDENT:
        read_ident(layout, raw, &ident);
        return sis_ident_text(scope, ident);
    case SIS_FORMAT_TIME:
        if ((utc = time_text(scope, tvb, offset, layout)) != NULL)
            return utc;
        break;
    case SIS_FORMAT_FLOATING:
        return float_text(scope, tvb, offset, layout);
    default:
        break;
    }
    return wmem_strdup_printf(scope, "0x%0*" PRIX64, (int)layout->size * 2, raw);
}

static const char *
value_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, const layout_t *layout)
{
    static const value_string requests[] = {{0, "clear"}, {1, "interrupt"}, {3, "set and enable"}, {0, NULL}};
    const char *number = number_text(scope, tvb, offset, layout);
    uint64_t raw = get_number(tvb, offset, layout->size, layout->encoding);
    const char *request = raw <= UINT32_MAX ? try_val_to_str((uint32_t)raw, requests) : NULL;

    if (layout->is_command && request != NULL)
        return wmem_strdup_printf(scope, "%s (%s)", number, request);
    if (layout->unit == NULL || layout->unit[0] == '\0' || layout->format == SIS_FORMAT_BINARY ||
        layout->format == SIS_FORMAT_IDENT || layout->format == SIS_FORMAT_HEXADECIMAL ||
        layout->format == SIS_FORMAT_TIME)
        return number;
    return wmem_strdup_printf(scope, "%s %s", number, layout->unit);
}

static bool
is_number(const layout_t *layout)
{
    return layout->format == SIS_FORMAT_UNSIGNED || layout->format == SIS_FORMAT_SIGNED ||
           layout->format == SIS_FORMAT_HEXADECIMAL ||
           (layout->format == SIS_FORMAT_FLOATING && is_described(layout));
}

/* The number in the text of a value, up to `unit`. Bits, idents and infinity have no number. */
static bool
read_number(const layout_t *layout, const char *value, double *number, char **unit)
{
    if (!is_number(layout))
        return false;
    *number = g_ascii_strtod(value, unit);
    return isfinite(*number);
}

/* The name of the parameter that a value names. Only tables: what the bus says of it comes and goes. */
static void
add_name_of_ident(proto_item *item, tvbuff_t *tvb, unsigned offset, const layout_t *layout)
{
    sis_ident_t ident;
    sis_known_t known;

    if (!read_ident(layout, get_number(tvb, offset, layout->size, layout->encoding), &ident))
        return;
    known = sis_known_from_tables(layout->place, ident);
    if (known.name != NULL)
        proto_item_append_text(item, " (%s)", known.name);
}

void
sis_add_named_bits(proto_item *item, tvbuff_t *tvb, unsigned offset, unsigned length, uint64_t raw,
                   const char *bits)
{
    proto_tree *tree;
    sis_bit_t bit;

    if (bits == NULL || item == NULL)
        return;
    tree = proto_item_add_subtree(item, ett_sis_value);
    while (sis_bit_take(&bits, &bit)) {
        if (raw >> bit.number & 1)
            proto_tree_add_string_format(tree, hf_sis_value_bit, tvb, offset, length,
                                         wmem_strndup(PNODE_POOL(tree), bit.name, bit.length), "Bit %u: %.*s",
                                         bit.number, (int)bit.length, bit.name);
    }
}

/* A value as text, and the number in this text: a filter compares what a person reads. */
static void
add_value_item(proto_tree *tree, tvbuff_t *tvb, unsigned offset, const layout_t *layout, const char *value,
               const char *label)
{
    proto_item *item = proto_tree_add_string(tree, hf_sis_value, tvb, offset, layout->size, value);
    double number;
    char *unit;

    if (label != NULL)
        proto_item_set_text(item, "%s", label);
    add_name_of_ident(item, tvb, offset, layout);
    sis_add_named_bits(item, tvb, offset, layout->size,
                       get_number(tvb, offset, layout->size, layout->encoding), layout->bits);
    if (!proto_field_is_referenced(tree, hf_sis_value_number) || !read_number(layout, value, &number, &unit))
        return;
    /* With the digits of the value: Wireshark 4.0 writes a comma in some locales. */
    item = proto_tree_add_double_format_value(proto_item_add_subtree(item, ett_sis_value),
                                              hf_sis_value_number, tvb, offset, layout->size, number, "%.*s",
                                              (int)(unit - value), value);
    proto_item_set_generated(item);
}

/* The two length words of a SERCOS list, if they are there: SIS may not carry them. */
static unsigned
list_header_size(const sis_element_data_t *data)
{
    unsigned length = tvb_captured_length(data->tvb);
    uint64_t actual;

    if (length < LIST_HEADER)
        return 0;
    actual = get_number(data->tvb, 0, 2, data->encoding);
    if (actual + LIST_HEADER != length || actual > get_number(data->tvb, 2, 2, data->encoding))
        return 0;
    return LIST_HEADER;
}

const char *
sis_element_text(wmem_allocator_t *scope, tvbuff_t *tvb)
{
    unsigned header = list_header_size(&(sis_element_data_t){tvb, ENC_LITTLE_ENDIAN, true, NULL});

    return sis_text(scope, tvb, header, tvb_captured_length(tvb) - header);
}

/* Returns the size of the length words, 0 if there are none. */
static unsigned
add_list_header(proto_tree *tree, const sis_element_data_t *data)
{
    unsigned size = data->is_whole ? list_header_size(data) : 0;

    if (size > 0) {
        proto_tree_add_item(tree, hf_sis_list_actual, data->tvb, 0, 2, data->encoding);
        proto_tree_add_item(tree, hf_sis_list_maximum, data->tvb, 2, 2, data->encoding);
    }
    return size;
}

static const char *
add_text(proto_tree *tree, packet_info *pinfo, int hf, const sis_element_data_t *data)
{
    unsigned header = add_list_header(tree, data), length = tvb_captured_length(data->tvb) - header;
    const char *text = sis_text(pinfo->pool, data->tvb, header, length);

    proto_tree_add_string(tree, hf, data->tvb, header, length, text);
    return wmem_strdup_printf(pinfo->pool, "\"%s\"", text);
}

static const char *
add_attribute(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data)
{
    static int *const bits[] = {
        &hf_sis_attribute_protected_4, &hf_sis_attribute_protected_3, &hf_sis_attribute_protected_2,
        &hf_sis_attribute_decimals,    &hf_sis_attribute_format,      &hf_sis_attribute_command,
        &hf_sis_attribute_length,      &hf_sis_attribute_factor,      NULL};

    if (tvb_captured_length(data->tvb) != ATTRIBUTE_SIZE)
        return NULL;
    proto_tree_add_bitmask(tree, data->tvb, 0, hf_sis_attribute, ett_sis_attribute, bits, data->encoding);
    return wmem_strdup_printf(pinfo->pool, "0x%08x",
                              (unsigned)get_number(data->tvb, 0, ATTRIBUTE_SIZE, data->encoding));
}

/* All elements into the tree, the first few into the text. The position of a segment's first element in
 * its list is unknown. */
static const char *
add_list(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data, const layout_t *layout)
{
    wmem_strbuf_t *text = wmem_strbuf_new(pinfo->pool, "");
    tvbuff_t *tvb = data->tvb;
    unsigned offset = add_list_header(tree, data), length = tvb_captured_length(tvb) - offset;
    unsigned count = length / layout->size, rest = length % layout->size;
    bool is_wanted = tree != NULL && (proto_field_is_referenced(tree, hf_sis_value) ||
                                      proto_field_is_referenced(tree, hf_sis_value_number) ||
                                      proto_field_is_referenced(tree, hf_sis_value_bit) ||
                                      proto_field_is_referenced(tree, hf_sis_raw));
    proto_tree *subtree = NULL;

    if (is_wanted)
        subtree = proto_tree_add_subtree_format(tree, tvb, offset, length, ett_sis_list, NULL, "%u element%s",
                                                count, plurality(count, "", "s"));
    for (unsigned i = 0; i < MIN(count, is_wanted ? SIS_SHOWN_IN_TREE : SIS_SHOWN_IN_LIST); i++) {
        unsigned at = offset + i * layout->size;
        const char *value = value_text(pinfo->pool, tvb, at, layout);

        if (is_wanted)
            add_value_item(subtree, tvb, at, layout, value,
                           data->is_whole ? wmem_strdup_printf(pinfo->pool, "Element %u: %s", i + 1, value)
                                          : NULL);
        if (i < SIS_SHOWN_IN_LIST)
            wmem_strbuf_append_printf(text, "%s%s", i > 0 ? ", " : "", value);
    }
    if (rest > 0 && is_wanted)
        proto_tree_add_item(subtree, hf_sis_raw, tvb, offset + length - rest, rest, ENC_NA);
    if (count > SIS_SHOWN_IN_LIST)
        wmem_strbuf_append_printf(text, ", ... (%u elements)", count);
    return count > 0 ? wmem_strbuf_get_str(text) : "empty";
}

/* Operating data, minimum or maximum; the limits of a list have the length of one element. */
static const char *
add_value(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data, sis_element_t element,
          const sis_known_t *known)
{
    unsigned length = tvb_captured_length(data->tvb);
    layout_t layout;
    const char *text;

    if (known == NULL || !read_layout(known, data, &layout))
        return NULL;
    if (element != SIS_ELEMENT_DATA && length == layout.size)
        layout.is_list = false;
    if (layout.is_list && layout.format == SIS_FORMAT_TEXT)
        return add_text(tree, pinfo, hf_sis_value, data);
    if (layout.is_list)
        return add_list(tree, pinfo, data, &layout);
    if (length != layout.size)
        return NULL;
    text = value_text(pinfo->pool, data->tvb, 0, &layout);
    add_value_item(tree, data->tvb, 0, &layout, text, NULL);
    return text;
}

bool
sis_element_number(const sis_element_data_t *data, const sis_known_t *known, const char *text, double *number)
{
    layout_t layout;
    char *unit;

    return read_layout(known, data, &layout) && !layout.is_list &&
           tvb_captured_length(data->tvb) == layout.size && read_number(&layout, text, number, &unit);
}

/* The number word alone does not tell the kind of a control parameter. */
static const char *
add_ident(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data, const sis_ident_t *asked)
{
    unsigned length = tvb_captured_length(data->tvb);
    sis_ident_t ident;
    const char *text;

    if (length != 2 || asked == NULL)
        return NULL;
    ident =
        (sis_ident_t){.type = asked->type, .number = (uint16_t)get_number(data->tvb, 0, 2, data->encoding)};
    text = sis_ident_text(pinfo->pool, ident);
    proto_tree_add_string(tree, hf_sis_value, data->tvb, 0, length, text);
    return text;
}

static const char *
attribute_misfit(const sis_element_data_t *data)
{
    if (tvb_captured_length(data->tvb) != ATTRIBUTE_SIZE)
        return data->is_whole ? "an attribute has 4 bytes" : NULL;
    return get_number(data->tvb, 0, ATTRIBUTE_SIZE, data->encoding) & UNDEFINED_BITS
               ? "undefined bits of the attribute"
               : NULL;
}

const char *
sis_element_misfit(const sis_element_data_t *data, sis_element_t element, const sis_known_t *known)
{
    unsigned length = tvb_captured_length(data->tvb), rest;
    layout_t layout;

    if (element == SIS_ELEMENT_ATTRIBUTE)
        return attribute_misfit(data);
    if (element < SIS_ELEMENT_MINIMUM || length == 0 || !read_layout(known, data, &layout))
        return NULL;
    if (!layout.is_list && length != layout.size)
        return "another length than its attribute says";
    rest = (length - (data->is_whole ? list_header_size(data) : 0)) % layout.size;
    if (length != layout.size && rest > 0)
        return "the last element is incomplete";
    return is_described(&layout) ? NULL : "no document describes a value of this format and length";
}

const char *
sis_add_element(proto_tree *tree, packet_info *pinfo, const sis_element_data_t *data, sis_element_t element,
                const sis_ident_t *ident, const sis_known_t *known)
{
    unsigned length = tvb_captured_length(data->tvb);

    if (length == 0)
        return NULL;
    proto_tree_add_item(tree, hf_sis_data, data->tvb, 0, length, ENC_NA);
    switch (element) {
    case SIS_ELEMENT_IDENT:
        return add_ident(tree, pinfo, data, ident);
    case SIS_ELEMENT_NAME:
        return add_text(tree, pinfo, hf_sis_element_name, data);
    case SIS_ELEMENT_ATTRIBUTE:
        return add_attribute(tree, pinfo, data);
    case SIS_ELEMENT_UNIT:
        return add_text(tree, pinfo, hf_sis_element_unit, data);
    case SIS_ELEMENT_MINIMUM:
    case SIS_ELEMENT_MAXIMUM:
    case SIS_ELEMENT_DATA:
        return add_value(tree, pinfo, data, element, known);
    default:
        return NULL;
    }
}

/* Latin-1, because drives are older than UTF-8. Control characters are shown as their pictures (U+2400 and
 * following). The control characters of Latin-1, and the soft hyphen, are shown as codes: "<9b>". */
static void
append_readable(wmem_strbuf_t *text, uint8_t c)
{
    if ((c >= 0x80 && c < 0xA0) || c == 0xAD)
        wmem_strbuf_append_printf(text, "<%02x>", c);
    else
        wmem_strbuf_append_unichar(text, c < 0x20 ? 0x2400 + c : c == 0x7F ? 0x2421 : c);
}

/* Does not end at a NUL. */
const char *
sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");

    for (unsigned i = 0; i < length; i++)
        append_readable(text, compat_get_uint8(tvb, offset + i));
    return wmem_strbuf_get_str(text);
}

const char *
sis_text_shortened(wmem_allocator_t *scope, const char *text, unsigned most)
{
    if (g_utf8_strlen(text, -1) <= (glong)most)
        return text;
    return wmem_strdup_printf(scope, "%.*s...", (int)(g_utf8_offset_to_pointer(text, most) - text), text);
}
