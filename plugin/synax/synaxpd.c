/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Process data over UDP (chapter 6, card ETH01): the payload is the data, without any head. What its words
 * are stands in parameters of the PPC only (p. 6-5: C-0-0127, C-0-0188 ...), so the user's table names them.
 */
#include "parts.h"

#include <math.h>

#include <epan/prefs.h>
#include <epan/uat.h>

#include "items.h"
#include "protocol/fields.h"

#define MAX_PORT    65535u
#define MAX_WORDS   32767u
#define WORDS_SHOWN 8u /* in the packet list */

static dissector_handle_t handle;

static range_t *ports_taken;

#define DIRECTION_UNKNOWN 0
typedef unsigned direction_t;

static const value_string widths[] = {{2, "2"}, {4, "4"}, {0, NULL}};

static const value_string signs[] = {{0, "unsigned"}, {1, "signed"}, {0, NULL}};

/* A row of the user's table "SYNAX process data". */
typedef struct {
    unsigned port; /* of the PPC */
    unsigned direction;
    unsigned word;  /* from 1 */
    unsigned width; /* bytes */
    unsigned is_signed;
    char *name;
    char *unit;
    char *factor; /* empty: 1 */
} row_t;

static row_t *rows;
static unsigned row_count;

/* clang-format off */
UAT_DEC_CB_DEF(rows, port, row_t)
UAT_VS_DEF(rows, direction, row_t, unsigned, SYNAXPD_TO_PPC, "to the PPC")
UAT_DEC_CB_DEF(rows, word, row_t)
UAT_VS_DEF(rows, width, row_t, unsigned, 2, "2")
UAT_VS_DEF(rows, is_signed, row_t, unsigned, 0, "unsigned")
UAT_CSTRING_CB_DEF(rows, name, row_t)
UAT_CSTRING_CB_DEF(rows, unit, row_t)
UAT_CSTRING_CB_DEF(rows, factor, row_t)
/* clang-format on */

/* With a point in every locale. */
static bool
parse_factor(const char *text, double *factor)
{
    char *end;

    *factor = 1;
    if (text == NULL || text[0] == '\0')
        return true;
    *factor = g_ascii_strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*factor);
}

static void *
copy_row(void *to, const void *from, size_t size _U_)
{
    const row_t *old = from;
    row_t *copy = to;

    *copy = *old;
    copy->name = g_strdup(old->name);
    copy->unit = g_strdup(old->unit);
    copy->factor = g_strdup(old->factor);
    return copy;
}

static void
free_row(void *data)
{
    row_t *row = data;

    g_free(row->name);
    g_free(row->unit);
    g_free(row->factor);
}

static compat_uat_bool
check_row(void *data, char **error)
{
    const row_t *row = data;
    double factor;

    *error = NULL;
    if (row->port == 0 || row->port > MAX_PORT)
        *error = g_strdup("A port is 1 to 65535");
    else if (row->word == 0 || row->word > MAX_WORDS)
        *error = g_strdup("Words count from 1, and a packet has at most 32767");
    else if (row->name == NULL || row->name[0] == '\0')
        *error = g_strdup("A word needs a name");
    else if (!parse_factor(row->factor, &factor))
        *error = g_strdup("A factor is a number such as 0.0001, or empty");
    return *error == NULL;
}

/* The packet being dissected. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    unsigned count;       /* of whole words */
    const row_t **rows;   /* by word, from 0: that of the value that begins there; NULL: none */
    wmem_strbuf_t *words; /* for the packet list */
} dissection_t;

/* The preference selects the port of the PPC; a packet without ports may have a direction of its
 * own. */
static direction_t
find_direction(const packet_info *pinfo)
{
    bool is_to, is_from;

    if (pinfo->ptype != PT_UDP)
        return pinfo->p2p_dir == P2P_DIR_SENT   ? SYNAXPD_TO_PPC
               : pinfo->p2p_dir == P2P_DIR_RECV ? SYNAXPD_FROM_PPC
                                                : DIRECTION_UNKNOWN;
    is_to = value_is_in_range(pref_synaxpd_ports, pinfo->destport);
    is_from = value_is_in_range(pref_synaxpd_ports, pinfo->srcport);
    return is_to == is_from ? DIRECTION_UNKNOWN : is_to ? SYNAXPD_TO_PPC : SYNAXPD_FROM_PPC;
}

/* The rows of this packet, by word. Of several rows for a word, the first counts. */
static const row_t **
find_rows(const packet_info *pinfo, unsigned count)
{
    const row_t **found = wmem_alloc0_array(pinfo->pool, const row_t *, count);

    for (unsigned i = 0; pinfo->ptype == PT_UDP && i < row_count; i++) {
        unsigned port = rows[i].direction == SYNAXPD_TO_PPC ? pinfo->destport : pinfo->srcport;
        unsigned word = rows[i].word - 1;

        if (rows[i].port == port && word < count && found[word] == NULL)
            found[word] = &rows[i];
    }
    return found;
}

/* High byte first, unless C-0-0129 says otherwise (p. 6-4). */
static uint16_t
word_at(const dissection_t *d, unsigned word)
{
    return compat_get_uint16(d->tvb, 2 * word, pref_synaxpd_swap_bytes ? ENC_LITTLE_ENDIAN : ENC_BIG_ENDIAN);
}

static double
number_at(const dissection_t *d, unsigned word, const row_t *row)
{
    uint32_t bits = word_at(d, word), next;

    if (row->width == 2)
        return row->is_signed ? (double)(int16_t)bits : (double)bits;
    next = word_at(d, word + 1);
    bits = pref_synaxpd_swap_words ? next << 16 | bits : bits << 16 | next;
    return row->is_signed ? (double)(int32_t)bits : (double)bits;
}

static void
add_word(proto_tree *tree, const dissection_t *d, unsigned word)
{
    uint16_t value = word_at(d, word);

    proto_tree_add_uint_format(tree, hf_synaxpd_word, d->tvb, 2 * word, 2, value, "Word %u: 0x%04x (%u)",
                               word + 1, value, value);
}

static void
add_value(const dissection_t *d, unsigned word, const row_t *row)
{
    char digits[G_ASCII_DTOSTR_BUF_SIZE];
    double factor, number = number_at(d, word, row);
    bool has_unit = row->unit != NULL && row->unit[0] != '\0';
    const char *text;
    proto_tree *tree;

    parse_factor(row->factor, &factor);
    number *= factor;
    g_ascii_formatd(digits, sizeof digits, "%.10g", number);
    text = wmem_strdup_printf(d->pinfo->pool, "%s = %s%s%s", row->name, digits, has_unit ? " " : "",
                              has_unit ? row->unit : "");
    tree = proto_item_add_subtree(
        proto_tree_add_string(d->tree, hf_synaxpd_value, d->tvb, 2 * word, row->width, text),
        ett_synaxpd_value);
    proto_item_set_generated(proto_tree_add_double_format_value(tree, hf_sis_value_number, d->tvb, 2 * word,
                                                                row->width, number, "%s", digits));
    for (unsigned i = 0; i < row->width / 2; i++)
        add_word(tree, d, word + i);
    wmem_strbuf_append_printf(d->words, "%s%s", wmem_strbuf_get_len(d->words) > 0 ? ", " : "", text);
}

/* A value from the table, or a raw word. Returns its number of words. */
static unsigned
dissect_word(const dissection_t *d, unsigned word)
{
    const row_t *row = d->rows[word];

    if (row != NULL && word + row->width / 2 <= d->count) {
        add_value(d, word, row);
        return row->width / 2;
    }
    add_word(d->tree, d, word);
    if (row != NULL)
        expert_add_info_format(d->pinfo, proto_tree_get_parent(d->tree), &ei_synax_short,
                               "%s has two words, only the first is there", row->name);
    return 1;
}

/* The first raw words, if the table has none. */
static void
list_words(const dissection_t *d)
{
    for (unsigned word = 0; word < MIN(d->count, WORDS_SHOWN); word++)
        wmem_strbuf_append_printf(d->words, "%s%04x", word > 0 ? " " : "", word_at(d, word));
    if (d->count > WORDS_SHOWN)
        wmem_strbuf_append(d->words, " ...");
}

static void
write_info(const dissection_t *d, direction_t direction)
{
    if (wmem_strbuf_get_len(d->words) == 0)
        list_words(d);
    col_add_fstr(d->pinfo->cinfo, COL_INFO, "Process data%s%s, %u word%s%s%s", direction ? " " : "",
                 direction ? val_to_str_const(direction, sis_synaxpd_directions, "") : "", d->count,
                 plurality(d->count, "", "s"), d->count > 0 ? ": " : "", wmem_strbuf_get_str(d->words));
}

static int
dissect_synaxpd(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    unsigned there = tvb_captured_length(tvb);
    direction_t direction = find_direction(pinfo);
    dissection_t d = {.tvb = tvb,
                      .pinfo = pinfo,
                      .count = there / 2,
                      .rows = find_rows(pinfo, there / 2),
                      .words = wmem_strbuf_new(pinfo->pool, "")};
    proto_item *root;

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SYNAXPD");
    root = proto_tree_add_item(parent, proto_synaxpd, tvb, 0, there, ENC_NA);
    d.tree = proto_item_add_subtree(root, ett_synaxpd);
    if (direction != DIRECTION_UNKNOWN)
        add_generated(d.tree, hf_synaxpd_direction, tvb, direction);
    for (unsigned word = 0; word < d.count;)
        word += dissect_word(&d, word);
    if (there % 2 == 1) {
        proto_tree_add_item(d.tree, hf_synaxpd_raw, tvb, there - 1, 1, ENC_NA);
        if (there == tvb_reported_length(tvb))
            expert_add_info_format(pinfo, root, &ei_synax_unexpected, "Half a word at the end");
    }
    write_info(&d, direction);
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb));
    return (int)there;
}

static void
register_table(void)
{
    static uat_field_t columns[] = {
        UAT_FLD_DEC(rows, port, "Port", "UDP port of the PPC for this client (C-0-0194)"),
        UAT_FLD_VS(rows, direction, "Direction", sis_synaxpd_directions, "To or from the PPC"),
        UAT_FLD_DEC(rows, word, "Word", "Where the value begins, from 1"),
        UAT_FLD_VS(rows, width, "Width", widths, "Bytes: 2 or 4"),
        UAT_FLD_VS(rows, is_signed, "Sign", signs, "Whether it can be negative"),
        UAT_FLD_CSTRING(rows, name, "Name", "What it is called"),
        UAT_FLD_CSTRING(rows, unit, "Unit", "Of the value, may be empty"),
        UAT_FLD_CSTRING(rows, factor, "Factor", "The value is this times the number that is sent; empty: 1"),
        UAT_END_FIELDS};
    uat_t *uat = uat_new("SYNAX process data", sizeof(row_t), "synax_process_data", TRUE, &rows, &row_count,
                         UAT_AFFECTS_DISSECTION, NULL, copy_row, check_row, free_row, NULL, NULL, columns);

    prefs_register_uat_preference(prefs_find_module("synaxpd"), "process_data", "Process data",
                                  "Names the words of each client's configuration", uat);
}

/* For each file, and not when preferences are applied: a change of profile resets them without that. */
static void
apply_ports(void)
{
    if (ports_taken != NULL) {
        dissector_delete_uint_range("udp.port", ports_taken, handle);
        wmem_free(wmem_epan_scope(), ports_taken);
    }
    ports_taken = range_copy(wmem_epan_scope(), pref_synaxpd_ports);
    dissector_add_uint_range("udp.port", ports_taken, handle);
}

void
synax_synaxpd_register(void)
{
    register_table();
    handle = register_dissector("synaxpd", dissect_synaxpd, proto_synaxpd);
}

void
synax_synaxpd_handoff(void)
{
    dissector_add_for_decode_as("udp.port", handle);
    register_init_routine(apply_ports);
}
