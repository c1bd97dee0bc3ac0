/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The data exchange protocol on ARCNET, protocol id 0x7F (chapter 7 of DOK-SYNAX*-SY*-08V*2/2-FK01-DE-P): TO
 * sends data, FETCH asks for them, and only FETCH is answered, by a TO (page 7-3). */
#include "parts.h"

#include "items.h"
#include "kept.h"
#include "parameters/ident.h"
#include "protocol/fields.h"
#include "sis/asked.h"
#include "sis/pieces.h"
#include "rk512/head.h"
#include "synax/ways.h"

#define PROTOCOL_ID 0x7F

#define SHORT_HEAD 7u /* of a follow-up with data (page 7-6) */
#define HEAD       13u
#define BLOCK_AT   9u /* the number of a data block, or the axis */

/* Page 7-27. */
#define FIRST_MESSAGE         0x8010
#define FOLLOW_UP_MESSAGES    0x1C20u
#define FOLLOW_UP_MESSAGE_END 0x1CFFu

/* Set in the only telegram printed in full, which writes a data block (page 7-14). */
#define INFO_BLOCK 0x0040

#define CANCEL_BLOCK 98

#define LENGTH_WORDS 4u /* of a list: actual and maximum length, two bytes each (page 7-20) */

/* A list that continues in follow-ups. */
typedef struct {
    sis_ident_t ident;
    bool is_last; /* as the info access of its first telegram says */
    uint32_t number;
    uint32_t begun_in;
    uint32_t announced; /* bytes, length words included */
    uint32_t received;
    unsigned message; /* number of the last follow-up; 0: none yet */
} transfer_t;

/* What is kept of a telegram. */
typedef struct {
    sis_asked_t asked;
    uint32_t unanswered_in; /* an earlier request that nobody answered; 0: none */
    transfer_t *transfer;   /* whose piece it is */
    bool is_last_piece;
    bool is_out_of_order; /* its message number */
} kept_t;

/* From one station to another. */
typedef struct {
    synax_way_t key;
    kept_t *request; /* waiting for its answer */
    uint64_t subject;
    transfer_t *transfer;
} way_t;

static wmem_map_t *ways; /* of the file */

/* The telegram being dissected. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root;
    wmem_strbuf_t *words; /* for the packet list */
    uint8_t command;
    bool is_follow_up;
    bool is_block;
    bool is_short;     /* bytes are missing */
    bool is_cut;       /* the capture has not all of it */
    unsigned declared; /* bytes after the first seven, according to the head */
    unsigned whole;    /* bytes of the telegram */
    unsigned end;      /* bytes of the telegram that are in the capture */
    kept_t *kept;
} telegram_t;

static void
mark(telegram_t *t, proto_item *item, expert_field *ei, const char *text)
{
    expert_add_info_format(t->pinfo, item != NULL ? item : t->root, ei, "%s", text);
}

/* Not documented. */
static void
give_up(telegram_t *t, unsigned offset, const char *text)
{
    add_bytes(t->tree, hf_sis_raw, t->tvb, offset, t->end);
    mark(t, NULL, &ei_synax_note, text);
    wmem_strbuf_append_printf(t->words, "%s%s", wmem_strbuf_get_len(t->words) > 0 ? ": " : "", text);
}

/* The seven bytes that every telegram has, as far as they are there. */
static bool
add_short_head(telegram_t *t)
{
    static const struct {
        int *hf;
        unsigned size;
    } parts[] = {{&hf_arcnet7f_id, 1},
                 {&hf_arcnet7f_message, 2},
                 {&hf_arcnet7f_command, 1},
                 {&hf_arcnet7f_type, 1},
                 {&hf_arcnet7f_length, 2}};
    unsigned offset = 0;

    for (unsigned i = 0; i < array_length(parts) && offset + parts[i].size <= t->end; i++) {
        proto_tree_add_item(t->tree, *parts[i].hf, t->tvb, offset, parts[i].size, ENC_LITTLE_ENDIAN);
        offset += parts[i].size;
    }
    if (offset == SHORT_HEAD)
        return true;
    add_bytes(t->tree, hf_sis_raw, t->tvb, offset, t->end);
    if (t->whole < SHORT_HEAD)
        expert_add_info_format(t->pinfo, t->root, &ei_synax_short, "The head is cut");
    wmem_strbuf_append(t->words, "Cut telegram");
    return false;
}

/* A FETCH has no data. The documents do not say whether its length is that of the answer, so only the
 * length of a TO is checked. A FETCH of a follow-up has the whole head, too (pages 7-24 and 7-25). Without
 * it, as page 7-6 can be understood, its length is 0. */
static void
read_extent(telegram_t *t)
{
    unsigned there = t->whole - SHORT_HEAD;

    t->declared = 2 * tvb_get_letohs(t->tvb, 5);
    if (t->command == ARCNET7F_FETCH && !(t->is_follow_up && t->declared == 0))
        t->declared = SYNAX_HEAD_SIZE;
    t->is_short = t->declared > there;
    t->whole = SHORT_HEAD + MIN(t->declared, there);
    t->is_cut = t->end < t->whole;
    t->end = MIN(t->end, t->whole);
}

static void
check_extent(telegram_t *t)
{
    unsigned there = tvb_reported_length(t->tvb);

    if (t->is_short)
        expert_add_info_format(t->pinfo, t->root, &ei_synax_short, "Fewer bytes than the length says");
    if (there > t->whole) {
        add_bytes(t->tree, hf_sis_raw, t->tvb, t->end, tvb_captured_length(t->tvb));
        expert_add_info_format(t->pinfo, t->root, &ei_synax_unexpected, "Bytes after the telegram");
    }
}

static way_t *
find_way(const packet_info *pinfo, const address *from, const address *to)
{
    return synax_find_way(ways, pinfo, from, to, 0, sizeof(way_t));
}

/* The subject of a telegram, the same in a FETCH and in its answer: a parameter or a block, and read or
 * write; for a follow-up its number. */
static uint64_t
subject_of(const telegram_t *t)
{
    if (t->is_follow_up)
        return UINT64_C(1) << 48 | tvb_get_letohs(t->tvb, 1);
    return (uint64_t)(compat_get_uint8(t->tvb, SHORT_HEAD) & 1) << 32 | tvb_get_ntohl(t->tvb, BLOCK_AT);
}

/* The number of bytes of a list by its length words; 0: it has none, or they are wrong. */
static unsigned
announced_by(const telegram_t *t)
{
    unsigned actual;

    if (t->is_block || t->end < HEAD + LENGTH_WORDS ||
        !synax_is_parameter(tvb_get_letohs(t->tvb, SHORT_HEAD)))
        return 0;
    actual = tvb_get_letohs(t->tvb, HEAD);
    return actual <= tvb_get_letohs(t->tvb, HEAD + 2) ? actual + LENGTH_WORDS : 0;
}

/* A list begins. If the info access says that nothing follows, the data may be a value that looks like
 * length words. So a list under way continues, and a follow-up decides. */
static void
begin_transfer(const telegram_t *t, way_t *way)
{
    unsigned announced = announced_by(t);
    bool is_cancel = t->is_block && compat_get_uint8(t->tvb, BLOCK_AT) == CANCEL_BLOCK;
    bool is_last = compat_get_uint8(t->tvb, SHORT_HEAD) & SYNAX_INFO_LAST;
    transfer_t *transfer;

    if (is_cancel || (t->is_cut && !is_last))
        way->transfer = NULL;
    if (t->is_short || t->is_cut || announced <= t->end - HEAD ||
        (is_last && way->transfer != NULL && !way->transfer->is_last))
        return;
    transfer = wmem_new0(wmem_file_scope(), transfer_t);
    transfer->ident =
        (sis_ident_t){.type = compat_get_uint8(t->tvb, 10), .number = tvb_get_letohs(t->tvb, 11)};
    transfer->is_last = is_last;
    transfer->number = sis_next_transfer();
    transfer->begun_in = t->pinfo->num;
    transfer->announced = announced;
    transfer->received = t->end - HEAD;
    way->transfer = t->kept->transfer = transfer;
}

static void
continue_transfer(const telegram_t *t, way_t *way)
{
    transfer_t *transfer = way->transfer;
    unsigned message = tvb_get_letohs(t->tvb, 1), before;

    if (transfer == NULL)
        return;
    if (t->is_short || t->is_cut) {
        way->transfer = NULL;
        return;
    }
    t->kept->transfer = transfer;
    before = message > FOLLOW_UP_MESSAGES ? message - 1 : FOLLOW_UP_MESSAGE_END; /* pages 7-20 and 7-27 */
    t->kept->is_out_of_order = transfer->message != 0 && transfer->message != before;
    transfer->message = message;
    transfer->received += t->end - SHORT_HEAD;
    t->kept->is_last_piece = transfer->received >= transfer->announced;
    if (t->kept->is_last_piece)
        way->transfer = NULL;
}

/* First pass: the request that it answers, and the list that it continues. */
static void
follow(const telegram_t *t)
{
    sis_times_t times = sis_times(t->tvb, t->pinfo, 0, NULL);
    way_t *way = find_way(t->pinfo, &t->pinfo->src, &t->pinfo->dst);
    way_t *back = find_way(t->pinfo, &t->pinfo->dst, &t->pinfo->src);

    sis_asked_note(&t->kept->asked, t->pinfo, &times);
    if (t->command == ARCNET7F_FETCH) {
        if (way->request != NULL)
            t->kept->unanswered_in = way->request->asked.frame;
        way->request = t->kept;
        way->subject = subject_of(t);
        return;
    }
    if (back->request != NULL && back->subject == subject_of(t)) {
        sis_asked_answer(&t->kept->asked, &back->request->asked, &times);
        back->request = NULL;
    }
    if (t->is_follow_up)
        continue_transfer(t, way);
    else
        begin_transfer(t, way);
}

static void
show_links(telegram_t *t)
{
    sis_asked_fields_t fields = {hf_synax_request_in, hf_synax_answer_in, hf_synax_answer_time};

    sis_asked_show(&t->kept->asked, t->tree, t->tvb, t->pinfo, &fields);
    add_link(t->tree, hf_synax_unanswered_in, t->tvb, t->kept->unanswered_in);
    if (t->kept->unanswered_in != 0)
        expert_add_info(t->pinfo, t->root, &ei_synax_unanswered_before);
}

static void
say_bytes(telegram_t *t, unsigned count)
{
    wmem_strbuf_append_printf(t->words, ", %u byte%s", count, plurality(count, "", "s"));
}

/* An answer, too, is a TO. */
static void
check_data(telegram_t *t)
{
    if (t->command == ARCNET7F_TO && t->whole == HEAD && !t->is_short)
        mark(t, NULL, &ei_synax_short, "A TO sends data (page 7-3)");
}

static void
add_block_data(telegram_t *t, unsigned block)
{
    if (block != CANCEL_BLOCK)
        check_data(t);
    add_bytes(t->tree, hf_sis_data, t->tvb, HEAD, t->end);
    if (t->whole == HEAD)
        return;
    synax_add_block_words(t->tree, t->pinfo, hf_arcnet7f_word,
                          tvb_new_subset_length(t->tvb, HEAD, t->end - HEAD), block, ENC_LITTLE_ENDIAN);
    if (block == SYNAX_BLOCK_MODE && t->whole - HEAD > 2)
        mark(t, NULL, &ei_synax_note, "Data block 100 has one word (page 7-15)");
    say_bytes(t, t->whole - HEAD);
}

/* Instead of axis and parameter; the three bytes after its number are 0 in the telegram that is printed. */
static void
add_block(telegram_t *t)
{
    uint8_t block = compat_get_uint8(t->tvb, BLOCK_AT);
    const char *text = synax_block_text(block),
               *access = compat_get_uint8(t->tvb, SHORT_HEAD) & 1 ? "Write" : "Read";
    proto_item *item;

    synax_add_info(t->tree, t->pinfo, t->tvb, SHORT_HEAD, ENC_LITTLE_ENDIAN, INFO_BLOCK);
    item = synax_add_block(t->tree, hf_arcnet7f_block, t->tvb, BLOCK_AT);
    if (text == NULL)
        mark(t, item, &ei_synax_note, "Data block that is not defined");
    if (tvb_get_letoh24(t->tvb, BLOCK_AT + 1) != 0) {
        add_bytes(t->tree, hf_sis_raw, t->tvb, BLOCK_AT + 1, HEAD);
        mark(t, NULL, &ei_synax_note, "Content after the number of a data block");
    }
    wmem_strbuf_append_printf(t->words, "%s DB %u%s%s%s", access, block, text != NULL ? " (" : "",
                              text != NULL ? text : "", text != NULL ? ")" : "");
    add_block_data(t, block);
}

static void
add_length_words(const telegram_t *t)
{
    proto_tree_add_item(t->tree, hf_arcnet7f_list_actual, t->tvb, HEAD, 2, ENC_LITTLE_ENDIAN);
    proto_tree_add_item(t->tree, hf_arcnet7f_list_maximum, t->tvb, HEAD + 2, 2, ENC_LITTLE_ENDIAN);
}

/* A list that is whole in its first telegram (page 7-28), in whole words as add_whole() has them. Values that
 * an attribute describes show their length words themselves. */
static void
add_whole_list(telegram_t *t, unsigned announced, const synax_head_t *head)
{
    bool has_attribute = head->known.attribute_from != SIS_FROM_NOWHERE;

    wmem_strbuf_append(t->words, announced > LENGTH_WORDS || has_attribute ? ", list" : ", empty list");
    if (!has_attribute)
        add_length_words(t);
    synax_add_data(t->tree, t->pinfo, tvb_new_subset_length(t->tvb, HEAD, announced),
                   has_attribute ? 0 : LENGTH_WORDS, ENC_LITTLE_ENDIAN, head, t->words);
    add_bytes(t->tree, hf_sis_raw, t->tvb, HEAD + announced, t->end);
}

/* The first piece of a list: its length words, and whatever follows them. */
static void
add_first_piece(telegram_t *t, unsigned announced)
{
    unsigned here = t->end - HEAD - LENGTH_WORDS;

    add_length_words(t);
    add_bytes(t->tree, hf_sis_data, t->tvb, HEAD + LENGTH_WORDS, t->end);
    wmem_strbuf_append_printf(t->words, ", list of %u bytes, %u here", announced - LENGTH_WORDS, here);
}

static void
add_parameter(telegram_t *t)
{
    synax_head_t head = synax_add_head(t->tree, t->pinfo, t->tvb, SHORT_HEAD, ENC_LITTLE_ENDIAN, t->words);
    unsigned announced = announced_by(t), length = t->end - HEAD;
    tvbuff_t *data = tvb_new_subset_length(t->tvb, HEAD, length);

    if (t->command == ARCNET7F_FETCH)
        return;
    if (t->is_cut) {
        say_bytes(t, t->whole - HEAD);
        add_bytes(t->tree, hf_sis_data, t->tvb, HEAD, t->end);
        return;
    }
    if (!head.is_parameter || head.is_last) {
        check_data(t);
        synax_add_data(t->tree, t->pinfo, data, 0, ENC_LITTLE_ENDIAN, &head, t->words);
    } else if (announced > 0 && announced + announced % 2 == length) {
        add_whole_list(t, announced, &head);
    } else if (announced > length) {
        add_first_piece(t, announced);
    } else {
        say_bytes(t, length);
        add_bytes(t->tree, hf_sis_data, t->tvb, HEAD, t->end);
        mark(t, NULL, &ei_synax_note,
             "More is to follow, but the data do not begin with the lengths of a list");
    }
    if (t->kept->transfer != NULL)
        sis_put_next(t->tree, t->pinfo, data, t->kept->transfer->number, false);
}

static void
add_first(telegram_t *t)
{
    if (t->end < HEAD) {
        add_bytes(t->tree, hf_sis_raw, t->tvb, SHORT_HEAD, t->end);
        wmem_strbuf_append(t->words, "Cut telegram");
        if (!t->is_short && !t->is_cut) /* otherwise already reported */
            expert_add_info_format(t->pinfo, t->root, &ei_synax_short, "The length is shorter than the head");
    } else if (t->is_block) {
        add_block(t);
    } else {
        add_parameter(t);
    }
}

/* The pieces are whole words: a list with an odd number of bytes has one more. */
static void
add_whole(telegram_t *t, tvbuff_t *whole)
{
    const transfer_t *transfer = t->kept->transfer;
    synax_head_t head = synax_head_of(0, 0, transfer->ident);
    unsigned length = tvb_captured_length(whole);

    wmem_strbuf_append(t->words, "; whole");
    if (length > transfer->announced + 1)
        expert_add_info_format(t->pinfo, t->root, &ei_synax_unexpected, "More bytes than the list announces");
    synax_add_data(t->tree, t->pinfo, tvb_new_subset_length(whole, 0, MIN(length, transfer->announced)), 0,
                   ENC_LITTLE_ENDIAN, &head, t->words);
}

static void
add_request_of_piece(telegram_t *t)
{
    if (t->end < HEAD) {
        add_bytes(t->tree, hf_sis_raw, t->tvb, SHORT_HEAD, t->end);
        return;
    }
    wmem_strbuf_append(t->words, ": ");
    synax_add_head(t->tree, t->pinfo, t->tvb, SHORT_HEAD, ENC_LITTLE_ENDIAN, t->words);
}

static void
add_follow_up(telegram_t *t)
{
    static const sis_ident_place_t nowhere = {0};
    const transfer_t *transfer = t->kept->transfer;
    unsigned length = t->end - SHORT_HEAD;
    sis_known_t known;
    tvbuff_t *whole;

    wmem_strbuf_append_printf(t->words, "Follow-up 0x%04x", tvb_get_letohs(t->tvb, 1));
    if (t->command == ARCNET7F_FETCH) {
        add_request_of_piece(t);
        return;
    }
    if (transfer != NULL) {
        known = sis_known_from_tables(NULL, transfer->ident);
        add_link(t->tree, hf_arcnet7f_first_in, t->tvb, transfer->begun_in);
        sis_add_ident(t->tree, t->pinfo->pool, t->tvb, &nowhere, transfer->ident, &known);
        wmem_strbuf_append_printf(t->words, " of %s", sis_ident_text(t->pinfo->pool, transfer->ident));
    }
    add_bytes(t->tree, hf_sis_data, t->tvb, SHORT_HEAD, t->end);
    say_bytes(t, t->whole - SHORT_HEAD);
    if (t->is_cut)
        return;
    if (transfer == NULL) {
        mark(t, NULL, &ei_synax_note, "No list goes on here: its beginning is missing, or it has ended");
        return;
    }
    if (t->kept->is_out_of_order)
        mark(t, NULL, &ei_synax_note, "Its message number does not follow that of the piece before");
    whole = sis_put_next(t->tree, t->pinfo, tvb_new_subset_length(t->tvb, SHORT_HEAD, length),
                         transfer->number, t->kept->is_last_piece);
    if (whole != NULL)
        add_whole(t, whole);
}

/* After the first seven bytes. */
static void
add_rest(telegram_t *t)
{
    unsigned message = tvb_get_letohs(t->tvb, 1);

    t->command = compat_get_uint8(t->tvb, 3);
    t->is_follow_up = message >= FOLLOW_UP_MESSAGES && message <= FOLLOW_UP_MESSAGE_END;
    if (compat_get_uint8(t->tvb, 0) != PROTOCOL_ID) {
        give_up(t, SHORT_HEAD, "not the protocol 0x7f");
        return;
    }
    if (t->command > ARCNET7F_FETCH) {
        give_up(t, SHORT_HEAD, "command that is not defined");
        return;
    }
    wmem_strbuf_append(t->words, t->command == ARCNET7F_FETCH ? "FETCH" : "TO");
    if (message != FIRST_MESSAGE && !t->is_follow_up) {
        give_up(t, SHORT_HEAD, "message number that is not defined");
        return;
    }
    if (compat_get_uint8(t->tvb, 4) != ARCNET7F_WORD_ARRAY) {
        give_up(t, SHORT_HEAD, "data type that is not defined");
        return;
    }
    wmem_strbuf_append(t->words, "  ");
    read_extent(t);
    t->is_block =
        !t->is_follow_up && t->end > SHORT_HEAD && compat_get_uint8(t->tvb, SHORT_HEAD) & INFO_BLOCK;
    if (!t->pinfo->fd->visited && (t->is_follow_up || t->end >= HEAD))
        follow(t);
    show_links(t);
    if (t->is_follow_up)
        add_follow_up(t);
    else
        add_first(t);
    check_extent(t);
}

static int
dissect_arcnet7f(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    telegram_t t = {.tvb = tvb,
                    .pinfo = pinfo,
                    .whole = tvb_reported_length(tvb),
                    .end = tvb_captured_length(tvb),
                    .kept = kept_of_packet(pinfo, proto_arcnet7f, 0, sizeof(kept_t))};

    t.words = wmem_strbuf_new(pinfo->pool, "");
    t.root = proto_tree_add_item(parent, proto_arcnet7f, tvb, 0, -1, ENC_NA);
    t.tree = proto_item_add_subtree(t.root, ett_arcnet7f);
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "ARCNET7F");
    col_clear(pinfo->cinfo, COL_INFO);
    if (add_short_head(&t))
        add_rest(&t);
    col_add_str(pinfo->cinfo, COL_INFO, wmem_strbuf_get_str(t.words));
    proto_item_append_text(t.root, ", %s", wmem_strbuf_get_str(t.words));
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb)); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

/* The telegram begins with the protocol id. But packet-arcnet.c keeps the id and three bytes after it, which
 * it takes for a split flag and a sequence number, and passes on the rest. So this goes back 4 bytes in the
 * packet. With the link type of BSD and 0xFF as split flag, it keeps seven bytes after the id. Only then does
 * the rest begin at 10; the id is at 2. So this is sure only for the link types of ARCNET: inside another
 * protocol, ARCNET begins elsewhere. In Wireshark's own source, packet-arcnet.c should list 0x7F among the
 * ids without a split flag; then this function is not needed. */
static int
dissect_in_arcnet(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data)
{
    tvbuff_t *packet = tvb_get_ds_tvb(tvb);
    unsigned offset = tvb_raw_offset(tvb), begin = offset == 10 ? 2 : MAX(offset, 4u) - 4;

    return dissect_arcnet7f(tvb_new_subset_remaining(packet, begin), pinfo, parent, data);
}

void
synax_arcnet7f_register(void)
{
    register_dissector("arcnet7f", dissect_arcnet7f, proto_arcnet7f);
    ways = synax_new_ways();
}

void
synax_arcnet7f_handoff(void)
{
    dissector_add_uint("arcnet.protocol_id", PROTOCOL_ID,
                       create_dissector_handle(dissect_in_arcnet, proto_arcnet7f));
}
