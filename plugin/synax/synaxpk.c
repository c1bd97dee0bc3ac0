/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The parameter channel in the cyclic data of Profibus: six words, the first of which is the control word
 * FBSteuer or the status word FBStatus (chapter 3 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P, "SYNAX"). That
 * manual's digest names the bits of the word without their numbers; they are those of the same channel in a
 * sister product, the OptiFeed-FS of ECODRIVE03 (FLP-04VRS, chapter 11, "FLP"), and fit every word that SYNAX
 * prints.
 *
 * The channel of IndraDrive (HDx-19, page 94) has another word: a preference chooses, nothing is mixed. */
#include "parts.h"

#include "items.h"
#include "kept.h"
#include "parameters/ident.h"
#include "protocol/fields.h"
#include "protocol/limits.h"
#include "sis/names.h"
#include "sis/pieces.h"
#include "synax/ways.h"

#define CHANNEL_SIZE 12u /* six words (SYNAX, page 3-3) */
#define WORD_SIZE    2u

#define BASIC_STATE 0x000F

#define BUSY_CODE 0x0008 /* page 3-9 */

/* The channel's own codes that are a number beside a fixed byte (FLP, page 11-15). */
#define SERIAL_ERRORS 0x0100

#define TELEGRAM_START 0x02

/* IndraDrive. */
#define FIRST_S_INDEX  0x2000
#define S_INDEX_END    0x3000
#define ORDER_HEAD_END 6u /* of the word, index and subindex */

typedef enum { SYNAX, INDRADRIVE } layout_t;
#define GUESS 0 /* no sender is known: the contents decide */
typedef unsigned sender_t;

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
    tree = proto_item_add_subtree(item, ett_synaxpk_raw);
    for (unsigned at = offset; at < end; at++)
        proto_tree_add_uint_format(tree, hf_synaxpk_byte, tvb, at, 1, compat_get_uint8(tvb, at),
                                   "Byte %u: 0x%02x", at, compat_get_uint8(tvb, at));
    if (why != NULL)
        mark(c, item, &ei_synax_note, why);
}

static sender_t
sender_of(const packet_info *pinfo)
{
    if (pref_synaxpk_direction != GUESS)
        return pref_synaxpk_direction;
    if (pinfo->p2p_dir == P2P_DIR_SENT)
        return SYNAXPK_MASTER;
    return pinfo->p2p_dir == P2P_DIR_RECV ? SYNAXPK_SLAVE : GUESS;
}

static void
add_sender(channel_t *c)
{
    c->sender = sender_of(c->pinfo);
    if (c->sender == GUESS)
        return;
    add_generated(c->tree, hf_synaxpk_sender, c->tvb, c->sender);
    wmem_strbuf_append_printf(c->words, "%s", val_to_str_const(c->sender, sis_channel_senders, ""));
}

/* FLP does not count the control word. SYNAX may count it, so two bytes fewer than counted bring no note: its
 * printed error answers can be read both ways. */
static void
read_extent(channel_t *c)
{
    unsigned count = (c->word & SYNAXPK_WORD_COUNT) >> 4, there = c->there - WORD_SIZE;

    c->end = WORD_SIZE + MIN(count, there);
    if (count > SYNAXPK_MOST_DATA)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_note,
                               "The channel has 10 bytes of data, its word says more");
    c->is_short = count <= SYNAXPK_MOST_DATA && there + WORD_SIZE < count;
    if (c->is_short)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_short, "The data are cut");
}

/* Of a sender; if that is unknown, of the access: read data come from the slave, written data from the
 * master (FLP, page 11-12). */
static way_t *
find_way(const channel_t *c, unsigned whose)
{
    const packet_info *pinfo = c->pinfo;

    return synax_find_way(ways, pinfo, &pinfo->src, &pinfo->dst, whose, sizeof(way_t));
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
    way_t *way = find_way(c, c->sender != GUESS ? c->sender : c->word & SYNAXPK_WORD_READ);
    bool is_last = c->word & SYNAXPK_WORD_LAST;

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
        way->transfer = sis_next_transfer();
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

/* Forgets what was under way. */
static void
forget(const channel_t *c)
{
    if (c->sender != GUESS) {
        begin_anew(c, c->sender);
    } else {
        begin_anew(c, 0);
        begin_anew(c, SYNAXPK_WORD_READ);
    }
}

/* First pass: data are repeated only if their sender has sent nothing else since. If the sender is
 * unknown, only the basic state shows that they are new. */
static void
follow_word(const channel_t *c)
{
    if (c->word == BASIC_STATE)
        forget(c);
    if (c->sender != GUESS)
        keep_image(c, find_way(c, c->sender));
}

/* The number word of a parameter; the format tells its type. */
static void
add_parameter(channel_t *c)
{
    sis_ident_t ident = {.type = (c->word & SYNAXPK_WORD_FORMAT) == SYNAXPK_A_SHORT_1,
                         .number = tvb_get_ntohs(c->tvb, WORD_SIZE)};
    sis_ident_place_t place = {WORD_SIZE, 2, SIS_NO_TYPE_BYTE, WORD_SIZE, ENC_BIG_ENDIAN};
    sis_known_t known = sis_known_from_tables(NULL, ident);

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

    proto_tree_add_item(c->tree, hf_synaxpk_class, c->tvb, 4, 1, ENC_NA);
    item = proto_tree_add_item(c->tree, hf_synaxpk_class_code, c->tvb, 5, 1, ENC_NA);
    if (!(c->word & SYNAXPK_WORD_ERROR)) {
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
    return !(c->word & SYNAXPK_WORD_ERROR) && c->word & SYNAXPK_WORD_BUSY && c->end >= 6 &&
           tvb_get_ntohs(c->tvb, 4) == BUSY_CODE;
}

/* Word 1 parameter, then class and code; the columns "Ctrl" and "Status" have no content in print. */
static void
add_short_answer(channel_t *c)
{
    say(c, c->word & SYNAXPK_WORD_ERROR ? "error" : "busy");
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
    if (c->word & SYNAXPK_WORD_ERROR || is_busy(c)) {
        add_short_answer(c);
        return;
    }
    say_bytes(c, c->end - WORD_SIZE);
    if (c->sender == SYNAXPK_SLAVE && c->end > 4) {
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
    text = try_rval_to_str(code, sis_channel_codes);
    if (text == NULL && (code & 0xFF00) == SERIAL_ERRORS)
        text = wmem_strdup_printf(c->pinfo->pool, "Serial error %u", code & 0xFF);
    if (text == NULL) {
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, "The place of the error code is not defined");
        return;
    }
    item = proto_tree_add_uint_format_value(c->tree, hf_synaxpk_code, c->tvb, WORD_SIZE, 2, code,
                                            "%s (0x%04x)", text, code);
    expert_add_info_format(c->pinfo, item, &ei_synax_error, "error 0x%04x: %s", code, text);
    wmem_strbuf_append_printf(c->words, " 0x%04x: %s", code, text);
    add_open_bytes(c, c->tvb, 4, c->end, "What follows the error code is not defined");
}

/* Without start character and sum; the documents do not say whether the addresses are there. */
static void
add_sis_part(channel_t *c, tvbuff_t *data)
{
    static int *const parts[] = {&hf_synaxpk_sis_length, &hf_synaxpk_sis_length_repeated,
                                 &hf_synaxpk_sis_control, &hf_synaxpk_sis_service};
    unsigned length = tvb_captured_length(data), known = MIN(length, array_length(parts));

    for (unsigned at = 0; at < known; at++) {
        proto_item *item = proto_tree_add_item(c->tree, *parts[at], data, at, 1, ENC_NA);

        if (parts[at] == &hf_synaxpk_sis_service) {
            const char *name = sis_service_name(c->pinfo->pool, compat_get_uint8(data, at));

            proto_item_append_text(item, " (%s)", name);
            say(c, name);
        }
    }
    add_open_bytes(c, data, known, length, "Whether addresses stand before the data is not defined");
}

/* The common part of two contradictory documents: a telegram begins with its start character and has equal
 * lengths; without that head it begins with the lengths. */
static tvbuff_t *
add_sis_data(channel_t *c, tvbuff_t *data)
{
    unsigned length = tvb_captured_length(data);

    if (length >= 4 && compat_get_uint8(data, 0) == TELEGRAM_START &&
        compat_get_uint8(data, 2) == compat_get_uint8(data, 3))
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
    kept_t *kept = kept_of_packet(c->pinfo, proto_synaxpk, 0, sizeof *kept);
    tvbuff_t *piece = tvb_new_subset_length(c->tvb, WORD_SIZE, c->end - WORD_SIZE), *whole = piece;
    bool is_last = c->word & SYNAXPK_WORD_LAST;

    if (!c->pinfo->fd->visited)
        follow(c, kept);
    say_bytes(c, c->end - WORD_SIZE);
    if (kept->is_repeated || kept->transfer != 0 || c->is_short)
        proto_tree_add_item(c->tree, hf_synaxpk_payload, c->tvb, WORD_SIZE, c->end - WORD_SIZE, ENC_NA);
    if (kept->is_repeated) {
        say(c, "as before");
        return NULL;
    }
    if (!is_last)
        say(c, "more follows");
    if (c->is_short)
        return NULL;
    if (kept->transfer != 0)
        whole = sis_put_next(c->tree, c->pinfo, piece, kept->transfer, is_last);
    return whole != NULL ? add_sis_data(c, whole) : NULL;
}

static tvbuff_t *
add_content(channel_t *c)
{
    unsigned format = c->word & SYNAXPK_WORD_FORMAT;

    say(c, val_to_str_const(format, sis_channel_formats, "format not defined"));
    if (c->word & SYNAXPK_WORD_ERROR && c->end == WORD_SIZE) {
        say(c, "error bit");
        return NULL;
    }
    if (format == SYNAXPK_SIS_FORMAT && c->word & SYNAXPK_WORD_ERROR) {
        add_channel_error(c);
        return NULL;
    }
    say(c, c->word & SYNAXPK_WORD_READ ? "channel read" : "channel write");
    if (c->end == WORD_SIZE)
        say(c, "no data");
    else if (format == SYNAXPK_SIS_FORMAT)
        return add_sis_format(c);
    else if (format == SYNAXPK_DRIVE_SHORT_1 || format == SYNAXPK_A_SHORT_1)
        add_short_1(c);
    else
        add_open_bytes(c, c->tvb, WORD_SIZE, c->end, "This format is not defined");
    return NULL;
}

static void
add_word(channel_t *c)
{
    static int *const bits[] = {&hf_synaxpk_word_open,   &hf_synaxpk_word_error,
                                &hf_synaxpk_word_read,   &hf_synaxpk_word_busy,
                                &hf_synaxpk_word_last,   &hf_synaxpk_word_bit9,
                                &hf_synaxpk_word_toggle, &hf_synaxpk_word_count,
                                &hf_synaxpk_word_format, NULL};
    proto_item *item;

    c->word = tvb_get_ntohs(c->tvb, 0);
    item = proto_tree_add_bitmask_with_flags(c->tree, c->tvb, 0, hf_synaxpk_word, ett_synaxpk_word, bits,
                                             ENC_BIG_ENDIAN, BMT_NO_APPEND);
    if (c->word & SYNAXPK_WORD_OPEN)
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
    } else if (c->word & SYNAXPK_WORD_ERROR && c->sender == SYNAXPK_MASTER) {
        say(c, "clear error");
    } else {
        read_extent(c);
        telegram = add_content(c);
    }
    add_bytes(c->tree, hf_synaxpk_beyond, c->tvb, c->end, c->there);
    return telegram;
}

/* Index 0x2000 and above: an S parameter; the subindex is its element (IndraDrive MPH-02, page 4-48). */
static void
add_index(channel_t *c)
{
    static const sis_ident_place_t nowhere = {0};
    unsigned number = tvb_get_ntohs(c->tvb, WORD_SIZE), element = tvb_get_ntohs(c->tvb, 4);
    sis_ident_t ident = {.number = (uint16_t)(number - FIRST_S_INDEX)};
    sis_known_t known = sis_known_from_tables(NULL, ident);

    proto_tree_add_item(c->tree, hf_synaxpk_index, c->tvb, WORD_SIZE, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(c->tree, hf_synaxpk_subindex, c->tvb, 4, 2, ENC_BIG_ENDIAN);
    say(c, wmem_strdup_printf(c->pinfo->pool, "index 0x%04x, subindex %u", number, element));
    if (number < FIRST_S_INDEX || number >= S_INDEX_END)
        return;
    sis_add_ident(c->tree, c->pinfo->pool, c->tvb, &nowhere, ident, &known);
    wmem_strbuf_append_printf(c->words, " (%s)", sis_ident_text(c->pinfo->pool, ident));
}

static unsigned
add_drive_word(channel_t *c)
{
    static int *const bits[] = {&hf_synaxpk_drive_pf,
                                &hf_synaxpk_drive_error,
                                &hf_synaxpk_drive_last,
                                &hf_synaxpk_drive_toggle,
                                &hf_synaxpk_drive_fragment,
                                &hf_synaxpk_drive_length,
                                NULL};
    unsigned there = c->there - WORD_SIZE, fragment;

    c->word = tvb_get_ntohs(c->tvb, 0);
    fragment = (c->word & SYNAXPK_DRIVE_FRAGMENT) >> 8;
    proto_tree_add_bitmask_with_flags(c->tree, c->tvb, 0, hf_synaxpk_drive, ett_synaxpk_word, bits,
                                      ENC_BIG_ENDIAN, BMT_NO_APPEND);
    if (fragment > there)
        expert_add_info_format(c->pinfo, c->root, &ei_synax_short, "The data are cut");
    c->end = WORD_SIZE + MIN(fragment, there);
    return fragment;
}

/* An order begins with index and subindex; idents of 4 bytes extend them (HDx-19, page 94). Returns where its
 * data begin. */
static unsigned
add_order(channel_t *c)
{
    if (c->word & SYNAXPK_DRIVE_PF) {
        mark(c, NULL, &ei_synax_note, "Orders with an ident of 4 bytes are not decoded");
        return WORD_SIZE;
    }
    add_index(c);
    return ORDER_HEAD_END;
}

/* IndraDrive: fragments are not reassembled. */
static void
add_indradrive(channel_t *c)
{
    unsigned fragment = add_drive_word(c), at = WORD_SIZE;
    bool is_alone = c->word & SYNAXPK_DRIVE_LAST && fragment == (c->word & SYNAXPK_DRIVE_LENGTH);

    if (c->sender == SYNAXPK_SLAVE && c->word & SYNAXPK_DRIVE_ERROR) {
        say(c, "error");
        mark(c, NULL, &ei_synax_error, "The drive reports an error");
    }
    say_bytes(c, c->end - WORD_SIZE);
    if (c->sender == SYNAXPK_MASTER && is_alone && c->end >= ORDER_HEAD_END)
        at = add_order(c);
    add_bytes(c->tree, hf_synaxpk_payload, c->tvb, at, c->end);
    add_bytes(c->tree, hf_synaxpk_beyond, c->tvb, c->end, c->there);
}

static void
check_size(channel_t *c)
{
    unsigned all = tvb_reported_length(c->tvb), captured = tvb_captured_length(c->tvb);

    if (pref_synaxpk_layout != SYNAX || all <= c->there)
        return;
    add_bytes(c->tree, hf_sis_raw, c->tvb, c->there, captured);
    expert_add_info_format(c->pinfo, c->root, &ei_synax_unexpected,
                           "Bytes after the six words of the channel");
}

/* Of a channel that the capture has cut, nothing is certain. */
static void
add_cut(channel_t *c)
{
    unsigned captured = tvb_captured_length(c->tvb);

    add_sender(c);
    say(c, "Cut channel");
    add_bytes(c->tree, hf_sis_raw, c->tvb, 0, captured);
    if (!c->pinfo->fd->visited && pref_synaxpk_layout == SYNAX)
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
    if (pref_synaxpk_layout == SYNAX)
        telegram = add_synax(c);
    else
        add_indradrive(c);
    check_size(c);
    if (!c->pinfo->fd->visited && pref_synaxpk_layout == SYNAX)
        follow_word(c);
    return telegram;
}

static int
dissect_synaxpk(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    unsigned all = tvb_reported_length(tvb);
    channel_t c = {.tvb = tvb, .pinfo = pinfo};
    tvbuff_t *telegram;

    c.there = pref_synaxpk_layout == SYNAX ? MIN(all, CHANNEL_SIZE) : all;
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

void
synax_synaxpk_register(void)
{
    register_dissector("synaxpk", dissect_synaxpk, proto_synaxpk);
    ways = synax_new_ways();
}

void
synax_synaxpk_handoff(void)
{
    sis_telegram = find_dissector("sis");
}
