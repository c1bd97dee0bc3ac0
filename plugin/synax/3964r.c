/* SPDX-License-Identifier: GPL-2.0-or-later */
/* 3964R, Siemens' procedure between two partners (chapter 8; Siemens' own manuals say more than that). STX
 * asks to send, DLE grants; then the block, every DLE in it doubled, DLE ETX and the check character BCC; DLE
 * says that it came well, NAK that it did not. A packet is one of these: a character alone, or a block
 * without its STX. */

#include "synax/3964r.h"

#include <epan/proto_data.h>

#include "sertap/line.h"
#include "sis/times.h"
#include "synax/fields.h"
#include "synax/rk512i.h"

#define STX 0x02
#define ETX 0x03
#define DLE 0x10
#define NAK 0x15

#define END_SIZE   3u /* DLE ETX BCC */
#define MS         INT64_C(1000000)
#define MOST_TRIES 6 /* to connect, and to send */

/* Siemens' times: SYNAX's own are not documented. */
#define ZVZ_MS 220
#define QVZ_MS 2000

static int proto_3964r = -1;

static int hf_character = -1;
static int hf_meaning = -1;
static int hf_length = -1;
static int hf_doubled = -1;
static int hf_end = -1;
static int hf_bcc = -1;
static int hf_bcc_status = -1;
static int hf_data = -1;
static int hf_raw = -1;
static int hf_answers = -1;
static int hf_answer_in = -1;
static int hf_answer_time = -1;
static int hf_try = -1;
static int hf_repeat_of = -1;
static int hf_unanswered = -1;
static int hf_qvz_limit = -1;
static int hf_qvz_verdict = -1;
static int hf_zvz_interval = -1;
static int hf_zvz_position = -1;
static int hf_zvz_limit = -1;
static int hf_zvz_verdict = -1;

static int ett_3964r = -1;

static expert_field ei_bcc = EI_INIT;
static expert_field ei_broken = EI_INIT;
static expert_field ei_conflict = EI_INIT;
static expert_field ei_unexpected = EI_INIT;
static expert_field ei_refused = EI_INIT;
static expert_field ei_repeat = EI_INIT;
static expert_field ei_unanswered = EI_INIT;
static expert_field ei_tries = EI_INIT;
static expert_field ei_exceeded = EI_INIT;
static expert_field ei_unresolved = EI_INIT;

/* Preferences; 0: no verdict. */
static unsigned zvz_ms = ZVZ_MS, qvz_ms = QVZ_MS;

typedef enum {
    ASKS,
    BOTH_ASK,
    GRANTS,
    REFUSES_REQUEST,
    BLOCK,
    ACKNOWLEDGES,
    REFUSES_BLOCK,
    OUT_OF_PLACE,
} meaning_t;

static const value_string procedure_meanings[] = {
    {ASKS, "asks to send"},
    {BOTH_ASK, "asks to send, as the partner does: the one with low priority gives way"},
    {GRANTS, "ready to receive"},
    {REFUSES_REQUEST, "not ready to receive"},
    {BLOCK, "block"},
    {ACKNOWLEDGES, "block received"},
    {REFUSES_BLOCK, "block refused: it comes again"},
    {OUT_OF_PLACE, "nothing to answer"},
    {0, NULL},
};

/* One character or block, with the results of the first pass; lives as long as the file. */
typedef struct unit {
    meaning_t meaning;
    uint32_t frame;
    uint32_t answers;    /* the unit that this answers; 0: none */
    uint32_t answer_in;  /* and where this one was answered */
    uint32_t repeat_of;  /* of a block */
    uint32_t unanswered; /* the unanswered request or block before; 0: none */
    unsigned tries;      /* this is the n-th to connect, or to send this block; 0: it does not count */
    uint8_t line;
    int64_t end, end_earliest; /* of its last character, ns */
    bool is_bounded;
    int64_t elapsed; /* since the end of what it answers */
    sis_span_t span; /* the same, with its bounds */
} unit_t;

/* Both partners, in the first pass. */
typedef struct {
    uint64_t key;
    unit_t *request; /* waits for its answer; NULL: none */
    unit_t *rival;   /* the partner's request meanwhile: one of the two is answered */
    unit_t *block;   /* waits for its answer */
    unit_t *refused; /* the last request or block that was refused */
    uint8_t *bytes;  /* of the last block */
    unsigned length;
    unit_t *last_block; /* whose bytes these are */
} bus_t;

static wmem_map_t *buses;

static bus_t *
bus_of(packet_info *pinfo)
{
    uint64_t key = sertap_bus_key(pinfo);
    bus_t *bus = wmem_map_lookup(buses, &key);

    if (bus == NULL) {
        bus = wmem_new0(wmem_file_scope(), bus_t);
        bus->key = key;
        wmem_map_insert(buses, &bus->key, bus);
    }
    return bus;
}

static void
answer(unit_t *unit, unit_t *asked, const sis_times_t *times)
{
    asked->answer_in = unit->frame;
    unit->answers = asked->frame;
    unit->elapsed = sertap_elapsed(asked->end, times->begin);
    unit->span = (sis_span_t){0, SIS_ANY_TIME};
    if (asked->is_bounded && times->is_bounded)
        unit->span = sis_span_between(asked->end_earliest, asked->end, times);
}

/* Two requests within QVZ come from both partners, if possible: then neither was answered. */
static void
note_request(bus_t *bus, unit_t *unit, const sis_times_t *times)
{
    unit_t *before = bus->request;
    int64_t soon = (qvz_ms > 0 ? qvz_ms : QVZ_MS) * MS;
    bool is_soon = before != NULL && sertap_elapsed(before->end, times->begin) < soon;

    unit->meaning = ASKS;
    unit->tries = 1;
    if (is_soon && (unit->line == 0 || unit->line != before->line)) {
        unit->meaning = BOTH_ASK;
        bus->rival = unit;
        return; /* the first request still waits */
    }
    if (before != NULL) {
        unit->unanswered = before->frame;
        unit->tries = before->tries + 1;
    } else if (bus->refused != NULL && bus->refused->meaning != BLOCK) {
        unit->tries = bus->refused->tries + 1;
    }
    if (bus->block != NULL)
        unit->unanswered = bus->block->frame;
    bus->block = bus->rival = NULL;
    bus->refused = NULL;
    bus->request = unit;
}

/* Nobody answers himself. A shared line does not show who has sent what. */
static bool
can_answer(const unit_t *unit, const unit_t *asked)
{
    return asked != NULL && (unit->line == 0 || unit->line != asked->line);
}

static void
note_answer(bus_t *bus, unit_t *unit, const sis_times_t *times, bool is_good)
{
    unit_t *request = can_answer(unit, bus->request) ? bus->request : bus->rival;

    if (can_answer(unit, request)) {
        unit->meaning = is_good ? GRANTS : REFUSES_REQUEST;
        answer(unit, request, times);
        bus->refused = is_good ? NULL : request;
        bus->request = bus->rival = NULL;
    } else if (can_answer(unit, bus->block)) {
        unit->meaning = is_good ? ACKNOWLEDGES : REFUSES_BLOCK;
        answer(unit, bus->block, times);
        bus->refused = is_good ? NULL : bus->block;
        if (is_good) /* the same bytes again would be a new block */
            bus->last_block = NULL;
        bus->block = NULL;
    } else {
        unit->meaning = OUT_OF_PLACE;
    }
}

static void
note_block(bus_t *bus, unit_t *unit, tvbuff_t *tvb)
{
    unsigned length = tvb_captured_length(tvb);
    bool is_whole = length == tvb_reported_length(tvb);
    bool is_same = is_whole && bus->last_block != NULL && bus->length == length &&
                   tvb_memeql(tvb, 0, bus->bytes, length) == 0;

    unit->meaning = BLOCK;
    unit->tries = 1;
    if (is_same) {
        unit->repeat_of =
            bus->last_block->repeat_of != 0 ? bus->last_block->repeat_of : bus->last_block->frame;
        unit->tries = bus->last_block->tries + 1;
    } else {
        wmem_free(wmem_file_scope(), bus->bytes);
        bus->bytes = tvb_memdup(wmem_file_scope(), tvb, 0, length);
        bus->length = is_whole ? length : 0; /* the rest may differ: no block is the same */
    }
    bus->request = bus->rival = NULL;
    bus->refused = NULL;
    bus->block = bus->last_block = unit;
}

/* The meaning of a unit depends on what came before it; found in the first pass, and kept. */
static const unit_t *
find_unit(tvbuff_t *tvb, packet_info *pinfo, const sis_times_t *times)
{
    unit_t *unit = p_get_proto_data(wmem_file_scope(), pinfo, proto_3964r, 0);
    const sertap_record_t *record = sertap_record(pinfo);
    uint8_t character = compat_get_uint8(tvb, 0);
    bus_t *bus;

    if (unit != NULL)
        return unit;
    unit = wmem_new0(wmem_file_scope(), unit_t);
    p_add_proto_data(wmem_file_scope(), pinfo, proto_3964r, 0, unit);
    unit->frame = pinfo->num;
    unit->line = record != NULL ? record->line : 0;
    unit->end = times->end;
    unit->end_earliest = times->end_earliest;
    unit->is_bounded = times->is_bounded;
    bus = bus_of(pinfo);
    if (tvb_reported_length(tvb) > 1)
        note_block(bus, unit, tvb);
    else if (character == STX)
        note_request(bus, unit, times);
    else if (character == DLE || character == NAK)
        note_answer(bus, unit, times, character == DLE);
    else
        unit->meaning = OUT_OF_PLACE;
    return unit;
}

static void
show_verdict(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, int hf_limit, int hf_verdict,
             unsigned limit_ms, sis_verdict_t verdict, const char *words)
{
    nstime_t limit = sertap_time(limit_ms * MS);
    proto_item *item = proto_tree_add_time_format_value(tree, hf_limit, tvb, 0, 0, &limit, "%u ms", limit_ms);

    proto_item_set_generated(item);
    item = proto_tree_add_uint(tree, hf_verdict, tvb, 0, 0, verdict);
    proto_item_set_generated(item);
    if (verdict == SIS_TIME_OK)
        return;
    expert_add_info_format(pinfo, item, verdict == SIS_TIME_EXCEEDED ? &ei_exceeded : &ei_unresolved, "%s",
                           words);
    if (verdict == SIS_TIME_EXCEEDED)
        col_append_fstr(pinfo->cinfo, COL_INFO, "  [%s]", words);
}

static void
add_frame(proto_tree *tree, tvbuff_t *tvb, int hf, uint32_t frame)
{
    if (frame != 0)
        proto_item_set_generated(proto_tree_add_uint(tree, hf, tvb, 0, 0, frame));
}

/* How long the partner took, against the acknowledgment delay QVZ. */
static void
show_answer(const unit_t *unit, const sis_times_t *times, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    add_frame(tree, tvb, hf_answers, unit->answers);
    if (unit->answers == 0)
        return;
    proto_item_set_generated(sertap_add_ms(tree, hf_answer_time, tvb, 0, 0, pinfo->pool, unit->elapsed));
    if (times->record != NULL && qvz_ms > 0)
        show_verdict(tree, pinfo, tvb, hf_qvz_limit, hf_qvz_verdict, qvz_ms,
                     sis_judge(unit->span, qvz_ms * MS),
                     wmem_strdup_printf(pinfo->pool, "answered later than QVZ = %u ms", qvz_ms));
}

/* The longest interval inside a block, against the character delay ZVZ. */
static void
show_intervals(const sis_times_t *times, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    sis_longest_t longest;
    int64_t shown;

    if (times->record == NULL)
        return;
    longest = sis_longest(times, zvz_ms * MS);
    if (longest.interval.at == 0)
        return;
    shown = longest.interval.is_exact ? longest.interval.recorded : longest.interval.span.most;
    if (shown != SIS_ANY_TIME)
        proto_item_set_generated(sertap_add_ms(tree, hf_zvz_interval, tvb, 0, 0, pinfo->pool, shown));
    proto_item_set_generated(proto_tree_add_uint(tree, hf_zvz_position, tvb, 0, 0, longest.interval.at));
    if (zvz_ms > 0)
        show_verdict(tree, pinfo, tvb, hf_zvz_limit, hf_zvz_verdict, zvz_ms, longest.verdict,
                     wmem_strdup_printf(pinfo->pool, "an interval longer than ZVZ = %u ms", zvz_ms));
}

static void
show_unit(const unit_t *unit, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, proto_item *root)
{
    add_frame(tree, tvb, hf_answer_in, unit->answer_in);
    add_frame(tree, tvb, hf_repeat_of, unit->repeat_of);
    add_frame(tree, tvb, hf_unanswered, unit->unanswered);
    if (unit->tries > 0)
        proto_item_set_generated(proto_tree_add_uint(tree, hf_try, tvb, 0, 0, unit->tries));
    if (unit->meaning == BOTH_ASK)
        expert_add_info(pinfo, root, &ei_conflict);
    if (unit->meaning == OUT_OF_PLACE)
        expert_add_info(pinfo, root, &ei_unexpected);
    if (unit->meaning == REFUSES_REQUEST || unit->meaning == REFUSES_BLOCK)
        expert_add_info(pinfo, root, &ei_refused);
    if (unit->unanswered != 0)
        expert_add_info_format(pinfo, root, &ei_unanswered, "Nobody answered frame %u", unit->unanswered);
    if (unit->repeat_of != 0)
        expert_add_info_format(pinfo, root, &ei_repeat, "The block of frame %u again, try %u",
                               unit->repeat_of, unit->tries);
    if (unit->tries > MOST_TRIES)
        expert_add_info_format(pinfo, root, &ei_tries, "Try %u, 3964R has %u", unit->tries, MOST_TRIES);
}

static uint8_t
block_check(tvbuff_t *tvb, unsigned begin, unsigned end)
{
    uint8_t bcc = 0;

    for (unsigned i = begin; i < end; i++)
        bcc ^= compat_get_uint8(tvb, i);
    return bcc;
}

/* The data between `begin` and `end`, in which every DLE is doubled. Returns them without the doubling,
 * and how many were doubled; NULL if one is not doubled. */
static tvbuff_t *
undouble(tvbuff_t *tvb, packet_info *pinfo, unsigned begin, unsigned end, unsigned *doubled)
{
    uint8_t *bytes = wmem_alloc(pinfo->pool, end - begin + 1);
    unsigned length = 0;
    tvbuff_t *data;

    *doubled = 0;
    for (unsigned i = begin; i < end; i++) {
        bytes[length] = compat_get_uint8(tvb, i);
        if (bytes[length++] != DLE)
            continue;
        if (++i == end || compat_get_uint8(tvb, i) != DLE)
            return NULL;
        ++*doubled;
    }
    if (*doubled == 0)
        return tvb_new_subset_length(tvb, begin, end - begin);
    data = tvb_new_child_real_data(tvb, bytes, length, length);
    add_new_data_source(pinfo, data, "Block without doubled DLEs");
    return data;
}

/* Another logger's block may include its STX: then the check character decides. */
static unsigned
begin_of_data(tvbuff_t *tvb, unsigned end)
{
    uint8_t bcc = compat_get_uint8(tvb, end + 2);

    return compat_get_uint8(tvb, 0) == STX && block_check(tvb, 0, end + 2) != bcc &&
           block_check(tvb, 1, end + 2) == bcc;
}

static bool
show_check(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, unsigned begin, unsigned end)
{
    uint8_t expected = block_check(tvb, begin, end + 2);
    bool is_good = compat_get_uint8(tvb, end + 2) == expected;

    proto_tree_add_item(tree, hf_end, tvb, end, 2, ENC_BIG_ENDIAN);
    proto_tree_add_checksum(tree, tvb, end + 2, hf_bcc, hf_bcc_status, &ei_bcc, pinfo, expected, ENC_NA,
                            PROTO_CHECKSUM_VERIFY);
    if (!is_good)
        col_append_str(pinfo->cinfo, COL_INFO, "  [wrong BCC]");
    return is_good;
}

static void
show_data(tvbuff_t *data, packet_info *pinfo, proto_tree *parent, proto_tree *tree, const unit_t *unit,
          bool is_good)
{
    synax_block_t block = {unit->repeat_of != 0};

    if (is_good && synax_rk512i_dissect(data, pinfo, parent, &block))
        return;
    if (tvb_captured_length(data) > 0)
        proto_tree_add_item(tree, hf_data, data, 0, -1, ENC_NA);
}

static void
dissect_block(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, proto_tree *tree, proto_item *root,
              const unit_t *unit)
{
    unsigned there = tvb_captured_length(tvb), end, begin, doubled;
    tvbuff_t *data = NULL;
    bool is_good;

    if (there < tvb_reported_length(tvb)) {
        proto_tree_add_item(tree, hf_raw, tvb, 0, there, ENC_NA);
        col_append_str(pinfo->cinfo, COL_INFO, "Block");
        return;
    }
    if (there >= END_SIZE && tvb_get_ntohs(tvb, there - END_SIZE) == (DLE << 8 | ETX)) {
        end = there - END_SIZE;
        begin = begin_of_data(tvb, end);
        data = undouble(tvb, pinfo, begin, end, &doubled);
    }
    if (data == NULL) {
        proto_tree_add_item(tree, hf_raw, tvb, 0, -1, ENC_NA);
        expert_add_info(pinfo, root, &ei_broken);
        col_append_fstr(pinfo->cinfo, COL_INFO, "Broken-off block, %u bytes", there);
        return;
    }
    col_append_fstr(pinfo->cinfo, COL_INFO, "Block, %u byte%s%s", tvb_captured_length(data),
                    plurality(tvb_captured_length(data), "", "s"), unit->repeat_of != 0 ? "  [repeat]" : "");
    if (begin > 0)
        proto_tree_add_item(tree, hf_character, tvb, 0, 1, ENC_NA);
    proto_item_set_generated(
        proto_tree_add_uint(tree, hf_length, tvb, begin, end - begin, tvb_captured_length(data)));
    if (doubled > 0)
        proto_item_set_generated(proto_tree_add_uint(tree, hf_doubled, tvb, begin, end - begin, doubled));
    is_good = show_check(tvb, pinfo, tree, begin, end);
    show_data(data, pinfo, parent, tree, unit, is_good);
}

static void
dissect_character(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const unit_t *unit)
{
    static const value_string names[] = {{STX, "STX"}, {DLE, "DLE"}, {NAK, "NAK"}, {0, NULL}};
    uint8_t character = compat_get_uint8(tvb, 0);

    proto_tree_add_item(tree, hf_character, tvb, 0, 1, ENC_NA);
    col_append_fstr(pinfo->cinfo, COL_INFO, "%s  %s", val_to_str_const(character, names, "Character"),
                    val_to_str_const(unit->meaning, procedure_meanings, ""));
}

static int
dissect_3964r(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    proto_item *root;
    proto_tree *tree;
    sis_times_t times;
    const unit_t *unit;

    if (tvb_reported_length(tvb) == 0)
        return 0;
    root = proto_tree_add_item(parent, proto_3964r, tvb, 0, -1, ENC_NA);
    tree = proto_item_add_subtree(root, ett_3964r);
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "3964R");
    col_clear(pinfo->cinfo, COL_INFO);
    times = sis_times(tvb, pinfo, tvb_reported_length(tvb));
    unit = find_unit(tvb, pinfo, &times);
    proto_item_append_text(root, ", %s", val_to_str_const(unit->meaning, procedure_meanings, ""));
    if (unit->meaning == BLOCK)
        dissect_block(tvb, pinfo, parent, tree, root, unit);
    else
        dissect_character(tvb, pinfo, tree, unit);
    proto_item_set_generated(proto_tree_add_uint(tree, hf_meaning, tvb, 0, 0, unit->meaning));
    show_unit(unit, tvb, pinfo, tree, root);
    show_answer(unit, &times, tvb, pinfo, tree);
    if (unit->meaning == BLOCK)
        show_intervals(&times, tvb, pinfo, tree);
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb)); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

/* clang-format off */
static const value_string procedure_characters[] = {
    {STX, "STX"},
    {DLE, "DLE"},
    {NAK, "NAK"},
    {0, NULL},
};

static const value_string procedure_bcc_states[] = {
    {PROTO_CHECKSUM_E_BAD, "Bad"},
    {PROTO_CHECKSUM_E_GOOD, "Good"},
    {PROTO_CHECKSUM_E_UNVERIFIED, "Unverified"},
    {0, NULL},
};

static const value_string procedure_verdicts[] = {
    {0, "OK"},
    {1, "Exceeded"},
    {2, "Unresolved"},
    {0, NULL},
};

static hf_register_info fields[] = {
    {&hf_character, {"Character", "3964r.character", FT_UINT8, BASE_HEX, VALS(procedure_characters), 0, NULL, HFILL}},
    {&hf_meaning, {"Meaning", "3964r.meaning", FT_UINT8, BASE_DEC, VALS(procedure_meanings), 0, "From what came before", HFILL}},
    {&hf_length, {"Length of the data", "3964r.length", FT_UINT32, BASE_DEC | BASE_UNIT_STRING, UNS(&units_byte_bytes), 0, "Without doubled DLEs", HFILL}},
    {&hf_doubled, {"Doubled DLEs", "3964r.doubled", FT_UINT32, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_end, {"End (DLE ETX)", "3964r.end", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_bcc, {"Block check character", "3964r.bcc", FT_UINT8, BASE_HEX, NULL, 0, "XOR of all bytes after STX, with doubled DLEs, DLE and ETX", HFILL}},
    {&hf_bcc_status, {"Status of the block check character", "3964r.bcc.status", FT_UINT8, BASE_NONE, VALS(procedure_bcc_states), 0, NULL, HFILL}},
    {&hf_data, {"Data", "3964r.data", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_raw, {"Not decoded", "3964r.raw", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_answers, {"Answer to", "3964r.answers", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, NULL, HFILL}},
    {&hf_answer_in, {"Answered in", "3964r.answer_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, NULL, HFILL}},
    {&hf_answer_time, {"Answered after", "3964r.answer_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the last character of what it answers", HFILL}},
    {&hf_try, {"Try", "3964r.try", FT_UINT32, BASE_DEC, NULL, 0, "To connect, or to send this block", HFILL}},
    {&hf_repeat_of, {"Repeat of", "3964r.repeat_of", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RETRANS_PREV), 0, NULL, HFILL}},
    {&hf_unanswered, {"Before, not answered", "3964r.unanswered_before", FT_FRAMENUM, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_qvz_limit, {"QVZ (longest time to an answer)", "3964r.qvz.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_qvz_verdict, {"Verdict on QVZ", "3964r.qvz.verdict", FT_UINT8, BASE_DEC, VALS(procedure_verdicts), 0, NULL, HFILL}},
    {&hf_zvz_interval, {"Longest interval", "3964r.zvz.interval_max", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "Between two characters of the block", HFILL}},
    {&hf_zvz_position, {"Longest interval before character", "3964r.zvz.position", FT_UINT32, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_zvz_limit, {"ZVZ (longest interval allowed)", "3964r.zvz.limit", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_zvz_verdict, {"Verdict on ZVZ", "3964r.zvz.verdict", FT_UINT8, BASE_DEC, VALS(procedure_verdicts), 0, NULL, HFILL}},
};

static ei_register_info experts[] = {
    {&ei_bcc, {"3964r.bcc.bad", PI_CHECKSUM, PI_ERROR, "Wrong block check character: the receiver answers NAK", EXPFILL}},
    {&ei_broken, {"3964r.broken", PI_MALFORMED, PI_WARN, "The block does not end with DLE ETX BCC, or a DLE in it is not doubled", EXPFILL}},
    {&ei_conflict, {"3964r.conflict", PI_SEQUENCE, PI_NOTE, "Both partners ask at once: the one with low priority gives way", EXPFILL}},
    {&ei_unexpected, {"3964r.unexpected", PI_SEQUENCE, PI_NOTE, "There is nothing that this could answer", EXPFILL}},
    {&ei_refused, {"3964r.refused", PI_RESPONSE_CODE, PI_NOTE, "The partner refuses", EXPFILL}},
    {&ei_repeat, {"3964r.repeat", PI_SEQUENCE, PI_NOTE, "The same block again", EXPFILL}},
    {&ei_unanswered, {"3964r.unanswered", PI_SEQUENCE, PI_NOTE, "Nobody answered what came before", EXPFILL}},
    {&ei_tries, {"3964r.tries", PI_SEQUENCE, PI_WARN, "More tries than 3964R has", EXPFILL}},
    {&ei_exceeded, {"3964r.exceeded", PI_PROTOCOL, PI_WARN, "A time of the procedure is exceeded", EXPFILL}},
    {&ei_unresolved, {"3964r.unresolved", PI_PROTOCOL, PI_NOTE, "A time of the procedure is perhaps exceeded", EXPFILL}},
};
/* clang-format on */

void
synax_3964r_register(void)
{
    static int *trees[] = {&ett_3964r};
    module_t *module;

    proto_3964r = proto_register_protocol("3964R procedure", "3964R", "3964r");
    proto_register_field_array(proto_3964r, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    expert_register_field_array(expert_register_protocol(proto_3964r), experts, array_length(experts));
    module = prefs_register_protocol(proto_3964r, NULL);
    prefs_register_uint_preference(module, "zvz_ms", "ZVZ in ms",
                                   "Longest interval between two characters of a block; 0: no verdict", 10,
                                   &zvz_ms);
    prefs_register_uint_preference(module, "qvz_ms", "QVZ in ms",
                                   "Longest time to the partner's answer; 0: no verdict", 10, &qvz_ms);
    buses = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), wmem_int64_hash, g_int64_equal);
    register_dissector("3964r", dissect_3964r, proto_3964r);
}

void
synax_3964r_handoff(void)
{
    dissector_add_uint("sertap.framing", 1, find_dissector("3964r"));
}
