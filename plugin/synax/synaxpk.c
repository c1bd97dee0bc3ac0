/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The parameter channel in the cyclic data of Profibus: six words, the first of which is the control word
 * FBSteuer or the status word FBStatus (chapter 3 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P, "SYNAX"). That
 * manual's digest names the bits of the word without their numbers; they are those of the same channel in a
 * sister product, the OptiFeed-FS of ECODRIVE03 (FLP-04VRS, chapter 11, "FLP"), and fit every word that SYNAX
 * prints.
 *
 * The channel of IndraDrive (HDx-19, page 94) has another word: a preference chooses, nothing is mixed. */

#include "synax/synaxpk.h"

#include <epan/prefs.h>
#include <epan/proto_data.h>

#include "parameters/fields.h"
#include "parameters/ident.h"
#include "sis/fields.h"
#include "sis/names.h"
#include "synax/fields.h"
#include "synax/pieces.h"
#include "synax/ways.h"

#define CHANNEL_SIZE 12u /* six words (SYNAX, page 3-3) */
#define WORD_SIZE    2u
#define MOST_DATA    10u

#define BASIC_STATE 0x000F

/* Bits of the word. 9 to 11 have no certain meaning, and are not checked. */
#define OPEN_BITS  0xC000
#define ERROR_BIT  0x2000
#define READ_BIT   0x1000
#define BUSY_BIT   0x0800
#define LAST_BIT   0x0400
#define BIT_9      0x0200
#define TOGGLE_BIT 0x0100
#define COUNT      0x00F0
#define FORMAT     0x000F

#define DRIVE_SHORT_1 0x0 /* page 3-6 */
#define A_SHORT_1     0x1
#define SIS_FORMAT    0xB

#define BUSY_CODE 0x0008 /* page 3-9 */

/* The channel's own codes that are a number beside a fixed byte (FLP, page 11-15). */
#define SERIAL_ERRORS 0x0100

#define TELEGRAM_START 0x02

/* IndraDrive. */
#define DRIVE_ERROR_BIT 0x4000
#define DRIVE_LAST_BIT  0x2000
#define DRIVE_FRAGMENT  0x0F00
#define DRIVE_LENGTH    0x00FF
#define FIRST_S_INDEX   0x2000
#define S_INDEX_END     0x3000

typedef enum { SYNAX, INDRADRIVE } layout_t;
typedef enum { GUESS, MASTER, SLAVE } sender_t;

static int proto_synaxpk = -1;

static int hf_word = -1;
static int hf_open = -1;
static int hf_error = -1;
static int hf_read = -1;
static int hf_busy = -1;
static int hf_last = -1;
static int hf_bit_9 = -1;
static int hf_toggle = -1;
static int hf_count = -1;
static int hf_format = -1;
static int hf_sender = -1;
static int hf_payload = -1;
static int hf_beyond = -1;
static int hf_byte = -1;
static int hf_class = -1;
static int hf_class_code = -1;
static int hf_code = -1;
static int hf_sis_length = -1;
static int hf_sis_length_again = -1;
static int hf_sis_control = -1;
static int hf_sis_service_code = -1;
static int hf_drive_word = -1;
static int hf_drive_format = -1;
static int hf_drive_error = -1;
static int hf_drive_last = -1;
static int hf_drive_toggle = -1;
static int hf_drive_fragment = -1;
static int hf_drive_length = -1;
static int hf_index = -1;
static int hf_subindex = -1;

static int ett_synaxpk = -1;
static int ett_word = -1;
static int ett_raw = -1;

static int layout = SYNAX;
static int direction = GUESS;
static dissector_handle_t sis_telegram;

/* Data under way in one direction. */
typedef struct {
    synax_way_t key;
    uint8_t image[CHANNEL_SIZE]; /* of the channel, the last time it had data */
    unsigned image_size;
    uint32_t transfer; /* 0: none */
} way_t;

/* The kept data of a packet. */
typedef struct {
    uint32_t transfer; /* the transfer of its fragment; 0: none */
    bool is_repeated;  /* the cyclic data repeat it */
} kept_t;

static wmem_map_t *ways; /* of the file */

/* The channel of one packet. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root;
    wmem_strbuf_t *words; /* for the packet list */
    uint16_t word;
    sender_t sender; /* GUESS: unknown */
    unsigned there;  /* bytes of the channel */
    unsigned end;    /* of the valid data */
    bool is_short;   /* not all of them are there */
} channel_t;

/* clang-format off */
static const value_string channel_formats[] = {
    {DRIVE_SHORT_1, "S/P parameter, short format 1"},
    {A_SHORT_1, "A parameter, short format 1"},
    {SIS_FORMAT, "Indramat SIS"},
    {0xF, "Basic state"},
    {0, NULL},
};

static const value_string channel_senders[] = {
    {MASTER, "Master"},
    {SLAVE, "Slave"},
    {0, NULL},
};

static const value_string channel_codes[] = {
    {0x0085, "Sum of the fragments too large"},
    {0x0088, "Internal error between card and drive"},
    {0x008A, "Index not present"},
    {0x008B, "Format unknown"},
    {0x008C, "Length longer than the channel"},
    {0x008D, "The channel has only one word"},
    {0x0090, "Format changed between fragments"},
    {0x0095, "Read request with more than index and subindex"},
    {0x0096, "Internal SIS communication error"},
    {0x009A, "Not implemented"},
    {0x009B, "Change between old and new channel"},
    {0x009C, "Subindex does not exist"},
    {0x009D, "Subindex write-protected"},
    {0x00F0, "Timeout between card and drive"},
    {0x01FF, "Length wrong: more than 128 bytes"},
    {0, NULL},
};
/* clang-format on */

static void
mark(channel_t *c, proto_item *item, expert_field *ei, const char *text)
{
    expert_add_info_format(c->pinfo, item != NULL ? item : c->root, ei, "%s", text);
}

static void
say(channel_t *c, const char *text)
{
    wmem_strbuf_append_printf(c->words, "%s%s", wmem_strbuf_get_len(c->words) > 0 ? ", " : "", text);
}

static void
say_bytes(channel_t *c, unsigned count)
{
    say(c, wmem_strdup_printf(c->pinfo->pool, "%u byte%s", count, plurality(count, "", "s")));
}

/* Bytes without a documented meaning: each with its number, counted from byte 0 of `tvb`. */
static void
add_open_bytes(channel_t *c, tvbuff_t *tvb, unsigned offset, unsigned end, const char *why)
{
    proto_item *item;
    proto_tree *tree;

    if (offset >= end)
        return;
    item = proto_tree_add_item(c->tree, hf_sis_raw, tvb, offset, end - offset, ENC_NA);
    tree = proto_item_add_subtree(item, ett_raw);
    for (unsigned at = offset; at < end; at++)
        proto_tree_add_uint_format(tree, hf_byte, tvb, at, 1, compat_get_uint8(tvb, at), "Byte %u: 0x%02x",
                                   at, compat_get_uint8(tvb, at));
    if (why != NULL)
        mark(c, item, &ei_synax_note, why);
}

static sender_t
sender_of(const packet_info *pinfo)
{
    if (direction != GUESS)
        return direction;
    if (pinfo->p2p_dir == P2P_DIR_SENT)
        return MASTER;
    return pinfo->p2p_dir == P2P_DIR_RECV ? SLAVE : GUESS;
}

static void
add_sender(channel_t *c)
{
    c->sender = sender_of(c->pinfo);
    if (c->sender == GUESS)
        return;
    proto_item_set_generated(proto_tree_add_uint(c->tree, hf_sender, c->tvb, 0, 0, c->sender));
    wmem_strbuf_append_printf(c->words, "%s", val_to_str_const(c->sender, channel_senders, ""));
}

/* FLP does not count the control word. SYNAX may count it, so two bytes fewer than counted bring no note: its
 * printed error answers can be read both ways. */
static void
read_extent(channel_t *c)
{
    unsigned count = (c->word & COUNT) >> 4, there = c->there - WORD_SIZE;

    c->end = WORD_SIZE + MIN(count, there);
    if (count > MOST_DATA)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_note,
                               "The channel has 10 bytes of data, its word says %u", count);
    c->is_short = count <= MOST_DATA && there + WORD_SIZE < count;
    if (c->is_short)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_short, "%u of %u bytes of data are there", there,
                               count);
}

/* Of a sender; if that is unknown, of the access: read data come from the slave, written data from the
 * master (FLP, page 11-12). */
static way_t *
find_way(const channel_t *c, unsigned whose)
{
    const packet_info *pinfo = c->pinfo;

    return synax_find_way(ways, pinfo, &pinfo->src, &pinfo->dst, whose, sizeof(way_t));
}

static unsigned
whose_data(const channel_t *c)
{
    return c->sender != GUESS ? c->sender : c->word & READ_BIT;
}

static void
keep_image(const channel_t *c, way_t *way)
{
    way->image_size = MIN(c->there, CHANNEL_SIZE);
    tvb_memcpy(c->tvb, way->image, 0, way->image_size);
}

/* First pass: cyclic data stay as they are until they change, and the toggle bit changes with every fragment.
 */
static void
follow(const channel_t *c, kept_t *kept)
{
    way_t *way = find_way(c, whose_data(c));
    bool is_last = c->word & LAST_BIT;

    kept->is_repeated = way->image_size == MIN(c->there, CHANNEL_SIZE) &&
                        tvb_memeql(c->tvb, 0, way->image, way->image_size) == 0;
    keep_image(c, way);
    if (kept->is_repeated)
        return;
    if (c->is_short) {
        way->transfer = 0;
        return;
    }
    if (!is_last && way->transfer == 0)
        way->transfer = synax_next_transfer();
    kept->transfer = way->transfer;
    if (is_last)
        way->transfer = 0;
}

static void
begin_anew(const channel_t *c, unsigned whose)
{
    way_t *way = find_way(c, whose);

    way->image_size = 0;
    way->transfer = 0;
}

/* First pass: data are repeated only if their sender has sent nothing else since. If the sender is
 * unknown, only the basic state shows that they are new. */
static void
follow_word(const channel_t *c)
{
    if (c->sender != GUESS) {
        if (c->word == BASIC_STATE)
            begin_anew(c, c->sender);
        keep_image(c, find_way(c, c->sender));
    } else if (c->word == BASIC_STATE) {
        begin_anew(c, 0);
        begin_anew(c, READ_BIT);
    }
}

/* What was under way when the capture cut a packet. */
static void
forget(const channel_t *c)
{
    if (c->sender != GUESS) {
        begin_anew(c, c->sender);
    } else {
        begin_anew(c, 0);
        begin_anew(c, READ_BIT);
    }
}

static kept_t *
kept_of(packet_info *pinfo)
{
    kept_t *kept = p_get_proto_data(wmem_file_scope(), pinfo, proto_synaxpk, 0);

    if (kept == NULL) {
        kept = wmem_new0(wmem_file_scope(), kept_t);
        p_add_proto_data(wmem_file_scope(), pinfo, proto_synaxpk, 0, kept);
    }
    return kept;
}

/* The number word of a parameter; the format tells its type. */
static void
add_parameter(channel_t *c)
{
    sis_ident_t ident = {(c->word & FORMAT) == A_SHORT_1, tvb_get_ntohs(c->tvb, WORD_SIZE)};
    sis_ident_place_t place = {WORD_SIZE, 2, SIS_NO_TYPE_BYTE, WORD_SIZE, ENC_BIG_ENDIAN};
    sis_known_t known = sis_known_from_tables(ident);

    sis_add_ident(c->tree, c->pinfo->pool, c->tvb, &place, ident, &known);
    say(c, sis_ident_text(c->pinfo->pool, ident));
    if (known.name != NULL)
        wmem_strbuf_append_printf(c->words, " (%s)", known.name);
}

/* Class and code together are the error code of SIS, and 00, 08 means busy (pages 3-8 and 3-9). */
static void
add_class_and_code(channel_t *c)
{
    unsigned code = tvb_get_ntohs(c->tvb, 4);
    const char *text = val_to_str_const(code, sis_errors_parameter, "Not defined");
    proto_item *item;

    proto_tree_add_item(c->tree, hf_class, c->tvb, 4, 1, ENC_NA);
    item = proto_tree_add_item(c->tree, hf_class_code, c->tvb, 5, 1, ENC_NA);
    if (!(c->word & ERROR_BIT)) {
        proto_item_append_text(item, " (busy)");
        return;
    }
    item = proto_tree_add_uint_format_value(c->tree, hf_sis_error, c->tvb, 4, 2, code, "%s (0x%04x)", text,
                                            code);
    expert_add_info_format(c->pinfo, item, &ei_synax_error, "error 0x%04x: %s", code, text);
    say(c, wmem_strdup_printf(c->pinfo->pool, "error 0x%04x: %s", code, text));
}

static bool
is_busy(const channel_t *c)
{
    return !(c->word & ERROR_BIT) && c->word & BUSY_BIT && c->end >= 6 &&
           tvb_get_ntohs(c->tvb, 4) == BUSY_CODE;
}

/* Word 1 parameter, then class and code; the columns "Ctrl" and "Status" have no content in print. */
static void
add_short_answer(channel_t *c)
{
    say(c, c->word & ERROR_BIT ? "error" : "busy");
    if (c->end < 4) {
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, NULL);
        mark(c, NULL, &ei_synax_short, "Parameter number missing");
        return;
    }
    add_parameter(c);
    if (c->end < 6) {
        add_open_bytes(c, c->tvb, 4, c->end, NULL);
        mark(c, NULL, &ei_synax_short, "Error code missing");
        return;
    }
    add_class_and_code(c);
    add_open_bytes(c, c->tvb, 6, c->end, "What follows the error code is not defined");
}

/* A good answer begins with word 2 (page 3-7); the layout of a request is not in the digest. */
static void
add_short_1(channel_t *c)
{
    if (c->word & ERROR_BIT || is_busy(c)) {
        add_short_answer(c);
        return;
    }
    say_bytes(c, c->end - WORD_SIZE);
    if (c->sender == SLAVE && c->end > 4) {
        add_open_bytes(c, c->tvb, WORD_SIZE, 4, "The first word of a good answer is not defined");
        proto_tree_add_item(c->tree, hf_sis_data, c->tvb, 4, c->end - 4, ENC_NA);
        return;
    }
    add_open_bytes(c, c->tvb, WORD_SIZE, c->end, "Requests and lists of the short format 1 are not defined");
}

/* Code of the channel itself, in the first word of the data (FLP, page 11-15). */
static void
add_channel_error(channel_t *c)
{
    unsigned code;
    const char *text;
    proto_item *item;

    say(c, "error");
    if (c->end < 4) {
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, NULL);
        mark(c, NULL, &ei_synax_short, "Error code missing");
        return;
    }
    code = tvb_get_ntohs(c->tvb, WORD_SIZE);
    text = try_val_to_str(code, channel_codes);
    if (text == NULL && (code & 0xFF00) == SERIAL_ERRORS)
        text = wmem_strdup_printf(c->pinfo->pool, "Serial error %u", code & 0xFF);
    if (text == NULL) {
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, "The place of the error code is not defined");
        return;
    }
    item = proto_tree_add_uint_format_value(c->tree, hf_code, c->tvb, WORD_SIZE, 2, code, "%s (0x%04x)", text,
                                            code);
    expert_add_info_format(c->pinfo, item, &ei_synax_error, "error 0x%04x: %s", code, text);
    wmem_strbuf_append_printf(c->words, " 0x%04x: %s", code, text);
    add_open_bytes(c, c->tvb, 4, c->end, "What follows the error code is not defined");
}

/* Without start character and sum; the documents do not say whether the addresses are there. */
static void
add_sis_part(channel_t *c, tvbuff_t *data)
{
    static int *const parts[] = {&hf_sis_length, &hf_sis_length_again, &hf_sis_control, &hf_sis_service_code};
    unsigned length = tvb_captured_length(data), known = MIN(length, array_length(parts));

    for (unsigned at = 0; at < known; at++) {
        proto_item *item = proto_tree_add_item(c->tree, *parts[at], data, at, 1, ENC_NA);

        if (parts[at] == &hf_sis_service_code) {
            const char *name = sis_service_name(c->pinfo->pool, compat_get_uint8(data, at));

            proto_item_append_text(item, " (%s)", name);
            say(c, name);
        }
    }
    add_open_bytes(c, data, known, length, "Whether addresses stand before the data is not defined");
}

static bool
is_whole_telegram(tvbuff_t *data)
{
    return tvb_captured_length(data) >= 4 && compat_get_uint8(data, 0) == TELEGRAM_START &&
           compat_get_uint8(data, 2) == compat_get_uint8(data, 3);
}

/* The common part of two contradictory documents: a telegram begins with its start character and has equal
 * lengths; without that head it begins with the lengths. */
static tvbuff_t *
add_sis_data(channel_t *c, tvbuff_t *data)
{
    unsigned length = tvb_captured_length(data);

    if (is_whole_telegram(data))
        return data;
    if (length >= 2 && compat_get_uint8(data, 0) == compat_get_uint8(data, 1))
        add_sis_part(c, data);
    else
        add_open_bytes(c, data, 0, length, "Neither a telegram nor one without start character and sum");
    return NULL;
}

/* Returns the telegram for another dissector, if there is one. */
static tvbuff_t *
add_sis_format(channel_t *c)
{
    kept_t *kept = kept_of(c->pinfo);
    tvbuff_t *piece = tvb_new_subset_length(c->tvb, WORD_SIZE, c->end - WORD_SIZE), *whole = piece;
    bool is_last = c->word & LAST_BIT;

    if (!c->pinfo->fd->visited)
        follow(c, kept);
    say_bytes(c, c->end - WORD_SIZE);
    if (kept->is_repeated || kept->transfer != 0 || c->is_short)
        proto_tree_add_item(c->tree, hf_payload, c->tvb, WORD_SIZE, c->end - WORD_SIZE, ENC_NA);
    if (kept->is_repeated) {
        say(c, "as before");
        return NULL;
    }
    if (!is_last)
        say(c, "more follows");
    if (c->is_short)
        return NULL;
    if (kept->transfer != 0)
        whole = synax_put_together(c->tree, c->pinfo, piece, kept->transfer, is_last);
    return whole != NULL ? add_sis_data(c, whole) : NULL;
}

static bool
is_clear_error(const channel_t *c)
{
    return c->word & ERROR_BIT && c->sender == MASTER;
}

static tvbuff_t *
add_content(channel_t *c)
{
    unsigned format = c->word & FORMAT;

    say(c, val_to_str_const(format, channel_formats, "format not defined"));
    if (c->word & ERROR_BIT && c->end == WORD_SIZE) {
        say(c, "error bit");
        return NULL;
    }
    if (format == SIS_FORMAT && c->word & ERROR_BIT) {
        add_channel_error(c);
        return NULL;
    }
    say(c, c->word & READ_BIT ? "channel read" : "channel write");
    if (c->end == WORD_SIZE)
        say(c, "no data");
    else if (format == SIS_FORMAT)
        return add_sis_format(c);
    else if (format == DRIVE_SHORT_1 || format == A_SHORT_1)
        add_short_1(c);
    else
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, "This format is not defined");
    return NULL;
}

static void
add_word(channel_t *c)
{
    static int *const bits[] = {&hf_open,  &hf_error,  &hf_read,  &hf_busy,   &hf_last,
                                &hf_bit_9, &hf_toggle, &hf_count, &hf_format, NULL};
    proto_item *item;

    c->word = tvb_get_ntohs(c->tvb, 0);
    item = proto_tree_add_bitmask_with_flags(c->tree, c->tvb, 0, hf_word, ett_word, bits, ENC_BIG_ENDIAN,
                                             BMT_NO_APPEND);
    if (c->word & OPEN_BITS)
        mark(c, item, &ei_synax_note, "Bits 14 and 15 are not defined");
}

/* The word of SYNAX, and what follows it. */
static tvbuff_t *
add_synax(channel_t *c)
{
    tvbuff_t *telegram = NULL;

    add_word(c);
    c->end = WORD_SIZE;
    if (c->word == BASIC_STATE) {
        say(c, "basic state");
    } else if (is_clear_error(c)) {
        say(c, "clear error");
    } else {
        read_extent(c);
        telegram = add_content(c);
    }
    if (c->there > c->end)
        proto_tree_add_item(c->tree, hf_beyond, c->tvb, c->end, c->there - c->end, ENC_NA);
    return telegram;
}

/* Index 0x2000 and above: an S parameter; the subindex is its element (IndraDrive MPH-02, page 4-48). */
static void
add_index(channel_t *c)
{
    static const sis_ident_place_t nowhere = {0};
    unsigned number = tvb_get_ntohs(c->tvb, WORD_SIZE), element = tvb_get_ntohs(c->tvb, 4);
    sis_ident_t ident = {0, (uint16_t)(number - FIRST_S_INDEX)};
    sis_known_t known = sis_known_from_tables(ident);

    proto_tree_add_item(c->tree, hf_index, c->tvb, WORD_SIZE, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(c->tree, hf_subindex, c->tvb, 4, 2, ENC_BIG_ENDIAN);
    say(c, wmem_strdup_printf(c->pinfo->pool, "index 0x%04x, subindex %u", number, element));
    if (number < FIRST_S_INDEX || number >= S_INDEX_END)
        return;
    sis_add_ident(c->tree, c->pinfo->pool, c->tvb, &nowhere, ident, &known);
    wmem_strbuf_append_printf(c->words, " (%s)", sis_ident_text(c->pinfo->pool, ident));
}

static unsigned
add_drive_word(channel_t *c)
{
    static int *const bits[] = {&hf_drive_format,
                                &hf_drive_error,
                                &hf_drive_last,
                                &hf_drive_toggle,
                                &hf_drive_fragment,
                                &hf_drive_length,
                                NULL};
    unsigned there = c->there - WORD_SIZE, fragment;

    c->word = tvb_get_ntohs(c->tvb, 0);
    fragment = (c->word & DRIVE_FRAGMENT) >> 8;
    proto_tree_add_bitmask_with_flags(c->tree, c->tvb, 0, hf_drive_word, ett_word, bits, ENC_BIG_ENDIAN,
                                      BMT_NO_APPEND);
    if (fragment > there)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_short, "%u of %u bytes of data are there", there,
                               fragment);
    c->end = WORD_SIZE + MIN(fragment, there);
    return fragment;
}

/* IndraDrive: an order begins with index and subindex; fragments are not reassembled. */
static void
add_indradrive(channel_t *c)
{
    unsigned fragment = add_drive_word(c), at = WORD_SIZE;
    bool is_alone = c->word & DRIVE_LAST_BIT && fragment == (c->word & DRIVE_LENGTH);

    if (c->sender == SLAVE && c->word & DRIVE_ERROR_BIT) {
        say(c, "error");
        mark(c, NULL, &ei_synax_error, "error");
    }
    say_bytes(c, c->end - WORD_SIZE);
    if (c->sender == MASTER && is_alone && c->end >= 6) {
        add_index(c);
        at = 6;
    }
    if (c->end > at)
        proto_tree_add_item(c->tree, hf_payload, c->tvb, at, c->end - at, ENC_NA);
    if (c->there > c->end)
        proto_tree_add_item(c->tree, hf_beyond, c->tvb, c->end, c->there - c->end, ENC_NA);
}

static void
check_size(channel_t *c)
{
    unsigned all = tvb_reported_length(c->tvb), captured = tvb_captured_length(c->tvb);

    if (layout != SYNAX || all <= c->there)
        return;
    if (captured > c->there)
        proto_tree_add_item(c->tree, hf_sis_raw, c->tvb, c->there, captured - c->there, ENC_NA);
    expert_add_info_format(c->pinfo, c->root, &ei_synax_unexpected,
                           "%u byte%s after the six words of the channel", all - c->there,
                           plurality(all - c->there, "", "s"));
}

/* Of a channel that the capture has cut, nothing is certain. */
static void
add_cut(channel_t *c)
{
    unsigned captured = tvb_captured_length(c->tvb);

    add_sender(c);
    say(c, "Cut channel");
    if (captured > 0)
        proto_tree_add_item(c->tree, hf_sis_raw, c->tvb, 0, captured, ENC_NA);
    if (!c->pinfo->fd->visited && layout == SYNAX)
        forget(c);
}

/* Everything but the telegram for another dissector. */
static tvbuff_t *
add_channel(channel_t *c)
{
    tvbuff_t *telegram = NULL;

    if (c->there > tvb_captured_length(c->tvb)) {
        add_cut(c);
        return NULL;
    }
    if (c->there < WORD_SIZE) {
        add_open_bytes(c, c->tvb, 0, c->there, NULL);
        mark(c, NULL, &ei_synax_short, "The control or status word is cut");
        say(c, "Cut channel");
        return NULL;
    }
    add_sender(c);
    if (layout == SYNAX)
        telegram = add_synax(c);
    else
        add_indradrive(c);
    check_size(c);
    if (!c->pinfo->fd->visited && layout == SYNAX)
        follow_word(c);
    return telegram;
}

static int
dissect_synaxpk(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    unsigned all = tvb_reported_length(tvb);
    channel_t c = {.tvb = tvb, .pinfo = pinfo};
    tvbuff_t *telegram;

    c.there = layout == SYNAX ? MIN(all, CHANNEL_SIZE) : all;
    c.words = wmem_strbuf_new(pinfo->pool, "");
    c.root = proto_tree_add_item(parent, proto_synaxpk, tvb, 0, -1, ENC_NA);
    c.tree = proto_item_add_subtree(c.root, ett_synaxpk);
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SYNAXPK");
    col_clear(pinfo->cinfo, COL_INFO);
    telegram = add_channel(&c);
    col_add_str(pinfo->cinfo, COL_INFO, wmem_strbuf_get_str(c.words));
    proto_item_append_text(c.root, ", %s", wmem_strbuf_get_str(c.words));
    if (telegram != NULL) {
        col_append_str(pinfo->cinfo, COL_INFO, " | ");
        col_set_fence(pinfo->cinfo, COL_INFO);
        call_dissector(sis_telegram, telegram, pinfo, parent);
    }
    tvb_ensure_bytes_exist(tvb, 0, (int)all); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

/* clang-format off */
static const true_false_string channel_access = {"Read", "Write"};

static hf_register_info fields[] = {
    {&hf_word, {"Control or status word", "synaxpk.word", FT_UINT16, BASE_HEX, NULL, 0, "FBSteuer of the master, FBStatus of the slave", HFILL}},
    {&hf_open, {"Not defined", "synaxpk.word.open", FT_UINT16, BASE_HEX, NULL, OPEN_BITS, NULL, HFILL}},
    {&hf_error, {"Error", "synaxpk.word.error", FT_BOOLEAN, 16, NULL, ERROR_BIT, "Of the slave; of the master: clear the error", HFILL}},
    {&hf_read, {"Access to the channel", "synaxpk.word.read", FT_BOOLEAN, 16, TFS(&channel_access), READ_BIT, "An order is written and its answer read, that of writing a parameter, too", HFILL}},
    {&hf_busy, {"Bit 11 (busy)", "synaxpk.word.busy", FT_BOOLEAN, 16, NULL, BUSY_BIT, "Not certain", HFILL}},
    {&hf_last, {"Last fragment", "synaxpk.word.last", FT_BOOLEAN, 16, NULL, LAST_BIT, NULL, HFILL}},
    {&hf_bit_9, {"Bit 9 (handshake)", "synaxpk.word.bit9", FT_BOOLEAN, 16, NULL, BIT_9, "Not certain", HFILL}},
    {&hf_toggle, {"Toggle", "synaxpk.word.toggle", FT_BOOLEAN, 16, NULL, TOGGLE_BIT, NULL, HFILL}},
    {&hf_count, {"Valid data bytes", "synaxpk.word.count", FT_UINT16, BASE_DEC, NULL, COUNT, NULL, HFILL}},
    {&hf_format, {"Format", "synaxpk.word.format", FT_UINT16, BASE_HEX, VALS(channel_formats), FORMAT, NULL, HFILL}},
    {&hf_sender, {"Sender", "synaxpk.sender", FT_UINT8, BASE_DEC, VALS(channel_senders), 0, NULL, HFILL}},
    {&hf_payload, {"Data of this packet", "synaxpk.payload", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_beyond, {"Not valid", "synaxpk.beyond", FT_BYTES, BASE_NONE, NULL, 0, "Bytes of the channel after the valid ones", HFILL}},
    {&hf_byte, {"Byte", "synaxpk.byte", FT_UINT8, BASE_HEX, NULL, 0, "Not defined", HFILL}},
    {&hf_class, {"Error class", "synaxpk.class", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_class_code, {"Error code in its class", "synaxpk.class.code", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_code, {"Error of the channel", "synaxpk.code", FT_UINT16, BASE_HEX, VALS(channel_codes), 0, NULL, HFILL}},
    {&hf_sis_length, {"Length (DatL)", "synaxpk.sis.length", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_sis_length_again, {"Length again (DatLW)", "synaxpk.sis.length_repeated", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_sis_control, {"Telegram control (Cntrl)", "synaxpk.sis.control", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_sis_service_code, {"Service", "synaxpk.sis.service", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_drive_word, {"Control or status word", "synaxpk.drive", FT_UINT16, BASE_HEX, NULL, 0, "Of IndraDrive", HFILL}},
    {&hf_drive_format, {"Ident of 4 bytes (PF)", "synaxpk.drive.pf", FT_BOOLEAN, 16, NULL, 0x8000, NULL, HFILL}},
    {&hf_drive_error, {"G; in a status word F, error", "synaxpk.drive.error", FT_BOOLEAN, 16, NULL, DRIVE_ERROR_BIT, NULL, HFILL}},
    {&hf_drive_last, {"Last fragment (L)", "synaxpk.drive.last", FT_BOOLEAN, 16, NULL, DRIVE_LAST_BIT, NULL, HFILL}},
    {&hf_drive_toggle, {"Toggle (T)", "synaxpk.drive.toggle", FT_BOOLEAN, 16, NULL, 0x1000, NULL, HFILL}},
    {&hf_drive_fragment, {"Bytes in this fragment (FL)", "synaxpk.drive.fragment", FT_UINT16, BASE_DEC, NULL, DRIVE_FRAGMENT, NULL, HFILL}},
    {&hf_drive_length, {"Bytes left, with this fragment (GL)", "synaxpk.drive.length", FT_UINT16, BASE_DEC, NULL, DRIVE_LENGTH, NULL, HFILL}},
    {&hf_index, {"Index", "synaxpk.index", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_subindex, {"Subindex", "synaxpk.subindex", FT_UINT16, BASE_DEC, NULL, 0, NULL, HFILL}},
};

static const enum_val_t layouts[] = {
    {"synax", "SYNAX200", SYNAX},
    {"indradrive", "IndraDrive", INDRADRIVE},
    {NULL, NULL, 0},
};

static const enum_val_t directions[] = {
    {"guess", "As the packet says: sent, received", GUESS},
    {"master", "Master", MASTER},
    {"slave", "Slave", SLAVE},
    {NULL, NULL, 0},
};
/* clang-format on */

void
synax_synaxpk_register(void)
{
    static int *trees[] = {&ett_synaxpk, &ett_word, &ett_raw};
    module_t *module;

    proto_synaxpk = proto_register_protocol("Rexroth SYNAX200 parameter channel", "SYNAXPK", "synaxpk");
    proto_register_field_array(proto_synaxpk, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    module = prefs_register_protocol(proto_synaxpk, NULL);
    prefs_register_enum_preference(module, "layout", "Layout of the control and status word",
                                   "IndraDrive has a parameter channel of its own", &layout, layouts, FALSE);
    prefs_register_enum_preference(
        module, "direction", "Sender",
        "Who has sent the packets: in a capture made at the master, what it sent comes "
        "from the master, and what it received from the slave",
        &direction, directions, FALSE);
    register_dissector("synaxpk", dissect_synaxpk, proto_synaxpk);
    ways = synax_new_ways();
}

void
synax_synaxpk_handoff(void)
{
    sis_telegram = find_dissector("sis");
}
