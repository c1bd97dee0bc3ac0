/* SPDX-License-Identifier: GPL-2.0-or-later */
/* 3964R, Siemens' procedure between two partners (chapter 8; Siemens' own manuals say more than that). STX
 * asks to send, DLE grants; then the block, every DLE in it doubled, DLE ETX and the check character BCC; DLE
 * says that it came well, NAK that it did not. A packet is one of these: a character alone, or a block
 * without its STX. */
#include "parts.h"

#include "items.h"
#include "kept.h"
#include "protocol/fields.h"
#include "protocol/limits.h"
#include "sertap/line.h"
#include "sis/asked.h"
#include "rk512/rk512i.h"

#define ETX 0x03

#define END_SIZE 3u /* DLE ETX BCC */
#define MS       INT64_C(1000000)

/* One character or block, with the results of the first pass; lives as long as the file. */
typedef struct unit {
    sis_asked_t asked;
    p3964r_meaning_t meaning;
    uint32_t repeat_of;  /* of a block */
    uint32_t unanswered; /* the unanswered request or block before; 0: none */
    unsigned tries;      /* this is the n-th to connect, or to send this block; 0: it does not count */
} unit_t;

/* Both partners, in the first pass. */
typedef struct {
    uint64_t key;
    unit_t *request; /* waits for its answer; NULL: none */
    unit_t *rival;   /* the partner's request meanwhile: one of the two is answered */
    unit_t *block;   /* waits for its answer */
    unit_t *granted; /* whose block has not come */
    unit_t *refused; /* the last request or block that was refused */
    uint8_t *bytes;  /* of the last block */
    unsigned length;
    unit_t *last_block;  /* whose bytes these are; NULL: accepted, or given up */
    unsigned tries;      /* to send a block, until now; 0: accepted, or given up */
    uint8_t sender;      /* its line */
    bool is_asked_again; /* since the last try */
    int64_t end;         /* of the last unit */
} bus_t;

static wmem_map_t *buses;

static void
end_series(bus_t *bus)
{
    bus->last_block = NULL; /* the same bytes again would be a new block */
    bus->tries = 0;
}

/* The next try to send, if the same partner has asked again, whatever the bytes. Who gives way to the other
 * begins anew. */
static unsigned
count_try(bus_t *bus, uint8_t line, bool is_same)
{
    bool is_next = bus->tries > 0 && bus->sender == line && (is_same || bus->is_asked_again);

    bus->tries = is_next ? bus->tries + 1 : 1;
    bus->sender = line;
    bus->is_asked_again = false;
    return bus->tries;
}

/* Two requests within QVZ come from both partners, if possible: then neither was answered. */
static void
note_request(bus_t *bus, unit_t *unit, const sis_times_t *times)
{
    unit_t *before = bus->request, *tried = before;
    int64_t qvz = (pref_3964r_qvz_ms > 0 ? pref_3964r_qvz_ms : P3964R_QVZ_MS) * MS;
    bool is_soon = before != NULL && sertap_elapsed(before->asked.end, times->begin) < qvz;
    /* The partners give up when nothing comes for the block wait, or after QVZ, if that is set to more. */
    bool is_over = sertap_elapsed(bus->end, times->begin) > MAX(P3964R_BLOCK_WAIT_MS * MS, 2 * qvz);

    unit->meaning = P3964R_ASKS;
    unit->tries = 1;
    /* Perhaps for the last block. On a line that both share, only the partner asks before QVZ is over. */
    bus->is_asked_again = unit->asked.line != 0 || bus->block == NULL ||
                          sertap_elapsed(bus->block->asked.end, times->begin) >= qvz;
    bus->granted = NULL;
    if (is_over)
        end_series(bus);
    if (is_soon && (unit->asked.line == 0 || unit->asked.line != before->asked.line)) {
        unit->meaning = P3964R_BOTH_ASK;
        bus->rival = unit;
        bus->is_asked_again = unit->asked.line != 0; /* on one line, nobody sees who gives way */
        return;                                      /* the first request still waits */
    }
    if (before != NULL)
        unit->unanswered = before->asked.frame;
    else if (bus->refused != NULL && bus->refused->meaning != P3964R_BLOCK)
        tried = bus->refused;
    if (tried != NULL && tried->asked.line == unit->asked.line && !is_over)
        unit->tries = tried->tries + 1;
    if (bus->block != NULL)
        unit->unanswered = bus->block->asked.frame;
    bus->block = bus->rival = NULL;
    bus->refused = NULL;
    bus->request = unit;
}

static bool
can_answer(const unit_t *unit, const unit_t *asked)
{
    return asked != NULL && sis_may_answer(&unit->asked, &asked->asked);
}

static void
note_answer(bus_t *bus, unit_t *unit, const sis_times_t *times, bool is_good)
{
    unit_t *request = can_answer(unit, bus->request) ? bus->request : bus->rival;

    if (can_answer(unit, request)) {
        unit->meaning = is_good ? P3964R_GRANTS : P3964R_REFUSES_REQUEST;
        sis_asked_answer(&unit->asked, &request->asked, times);
        bus->refused = is_good ? NULL : request;
        bus->granted = is_good ? request : NULL;
        bus->request = bus->rival = NULL;
    } else if (can_answer(unit, bus->block)) {
        unit->meaning = is_good ? P3964R_ACKNOWLEDGES : P3964R_REFUSES_BLOCK;
        sis_asked_answer(&unit->asked, &bus->block->asked, times);
        bus->refused = is_good ? NULL : bus->block;
        if (is_good)
            end_series(bus);
        bus->block = NULL;
    } else if (!is_good && can_answer(unit, bus->granted)) { /* a block that broke off: no frame */
        unit->meaning = P3964R_REFUSES_BLOCK;
        count_try(bus, bus->granted->asked.line, false);
        bus->granted = NULL;
    } else {
        unit->meaning = P3964R_OUT_OF_PLACE;
    }
}

static void
note_block(bus_t *bus, unit_t *unit, tvbuff_t *tvb)
{
    const unit_t *last = bus->last_block;
    unsigned length = tvb_captured_length(tvb);
    bool is_whole = length == tvb_reported_length(tvb);
    bool is_same = is_whole && last != NULL && last->asked.line == unit->asked.line &&
                   bus->length == length && tvb_memeql(tvb, 0, bus->bytes, length) == 0;

    unit->meaning = P3964R_BLOCK;
    unit->tries = count_try(bus, unit->asked.line, is_same);
    if (is_same) {
        unit->repeat_of = last->repeat_of != 0 ? last->repeat_of : last->asked.frame;
    } else {
        wmem_free(wmem_file_scope(), bus->bytes);
        bus->bytes = tvb_memdup(wmem_file_scope(), tvb, 0, length);
        bus->length = is_whole ? length : 0; /* the rest may differ: no block is the same */
    }
    bus->request = bus->rival = bus->granted = NULL;
    bus->refused = NULL;
    bus->block = bus->last_block = unit;
}

/* The meaning of a unit depends on what came before it; found in the first pass, and kept. */
static const unit_t *
find_unit(tvbuff_t *tvb, packet_info *pinfo, const sis_times_t *times)
{
    unit_t *unit = kept_of_packet(pinfo, proto_3964r, 0, sizeof *unit);
    uint8_t character = compat_get_uint8(tvb, 0);
    bus_t *bus;

    if (unit->asked.frame != 0)
        return unit;
    sis_asked_note(&unit->asked, pinfo, times);
    bus = sertap_kept_of_bus(buses, pinfo, sizeof *bus);
    if (tvb_reported_length(tvb) > 1)
        note_block(bus, unit, tvb);
    else if (character == P3964R_STX)
        note_request(bus, unit, times);
    else if (character == P3964R_DLE || character == P3964R_NAK)
        note_answer(bus, unit, times, character == P3964R_DLE);
    else
        unit->meaning = P3964R_OUT_OF_PLACE;
    bus->end = times->end;
    return unit;
}

static void
show_verdict(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, int hf_limit, int hf_verdict,
             unsigned limit_ms, sis_verdict_t verdict, const char *words)
{
    proto_item *item;

    sertap_add_time(tree, hf_limit, tvb, limit_ms * MS, wmem_strdup_printf(pinfo->pool, "%u ms", limit_ms));
    item = add_generated(tree, hf_verdict, tvb, verdict);
    if (verdict == SIS_TIME_OK)
        return;
    expert_add_info_format(
        pinfo, item, verdict == SIS_TIME_EXCEEDED ? &ei_3964r_exceeded : &ei_3964r_unresolved, "%s", words);
    if (verdict == SIS_TIME_EXCEEDED)
        col_append_fstr(pinfo->cinfo, COL_INFO, "  [%s]", words);
}

/* How long the partner took, against the acknowledgment delay QVZ. */
static void
show_answer(const unit_t *unit, const sis_times_t *times, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    add_link(tree, hf_3964r_answers, tvb, unit->asked.request_in);
    if (unit->asked.request_in == 0)
        return;
    sertap_add_ms(tree, hf_3964r_answer_time, tvb, pinfo->pool, unit->asked.elapsed);
    if (times->record != NULL && pref_3964r_qvz_ms > 0)
        show_verdict(tree, pinfo, tvb, hf_3964r_qvz_limit, hf_3964r_qvz_verdict, pref_3964r_qvz_ms,
                     sis_judge(unit->asked.span, pref_3964r_qvz_ms * MS),
                     wmem_strdup_printf(pinfo->pool, "answered later than QVZ = %u ms", pref_3964r_qvz_ms));
}

/* The longest interval inside a block, against the character delay ZVZ. */
static void
show_intervals(const sis_times_t *times, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    sis_longest_t longest;
    int64_t shown;
    bool is_longer;

    if (times->record == NULL)
        return;
    longest = sis_longest(pinfo->pool, times, pref_3964r_zvz_ms * MS, SIS_FROM_START);
    if (longest.interval.at == 0)
        return;
    is_longer = longest.interval.is_saturated;
    shown = longest.interval.is_exact || is_longer ? longest.interval.recorded : longest.interval.span.most;
    if (shown != SIS_ANY_TIME)
        sertap_add_time(tree, hf_3964r_zvz_interval_max, tvb, shown,
                        wmem_strconcat(pinfo->pool, is_longer ? "more than " : "",
                                       sertap_ms_text(pinfo->pool, shown), NULL));
    add_generated(tree, hf_3964r_zvz_position, tvb, longest.interval.at);
    if (pref_3964r_zvz_ms > 0)
        show_verdict(
            tree, pinfo, tvb, hf_3964r_zvz_limit, hf_3964r_zvz_verdict, pref_3964r_zvz_ms, longest.verdict,
            wmem_strdup_printf(pinfo->pool, "an interval longer than ZVZ = %u ms", pref_3964r_zvz_ms));
}

static void
show_unit(const unit_t *unit, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, proto_item *root)
{
    add_link(tree, hf_3964r_answer_in, tvb, unit->asked.answer_in);
    add_link(tree, hf_3964r_repeat_of, tvb, unit->repeat_of);
    add_link(tree, hf_3964r_unanswered_before, tvb, unit->unanswered);
    if (unit->tries > 0)
        add_generated(tree, hf_3964r_try, tvb, unit->tries);
    if (unit->meaning == P3964R_BOTH_ASK)
        expert_add_info(pinfo, root, &ei_3964r_conflict);
    if (unit->meaning == P3964R_OUT_OF_PLACE)
        expert_add_info(pinfo, root, &ei_3964r_unexpected);
    if (unit->meaning == P3964R_REFUSES_REQUEST || unit->meaning == P3964R_REFUSES_BLOCK)
        expert_add_info(pinfo, root, &ei_3964r_refused);
    if (unit->unanswered != 0)
        expert_add_info(pinfo, root, &ei_3964r_unanswered);
    if (unit->repeat_of != 0)
        expert_add_info(pinfo, root, &ei_3964r_repeat);
    if (unit->tries > P3964R_MOST_TRIES)
        expert_add_info(pinfo, root, &ei_3964r_tries);
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
        if (bytes[length++] != P3964R_DLE)
            continue;
        if (++i == end || compat_get_uint8(tvb, i) != P3964R_DLE)
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

    return compat_get_uint8(tvb, 0) == P3964R_STX && block_check(tvb, 0, end + 2) != bcc &&
           block_check(tvb, 1, end + 2) == bcc;
}

static bool
show_check(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, unsigned begin, unsigned end)
{
    uint8_t expected = block_check(tvb, begin, end + 2);
    bool is_good = compat_get_uint8(tvb, end + 2) == expected;
    proto_item *item;

    proto_tree_add_item(tree, hf_3964r_end, tvb, end, 2, ENC_BIG_ENDIAN);
    item = proto_tree_add_checksum(tree, tvb, end + 2, hf_3964r_bcc, hf_3964r_bcc_status, NULL, pinfo,
                                   expected, ENC_NA, PROTO_CHECKSUM_VERIFY);
    if (!is_good) {
        expert_add_info(pinfo, item, &ei_3964r_bcc_bad);
        col_append_str(pinfo->cinfo, COL_INFO, "  [wrong BCC]");
    }
    return is_good;
}

static void
show_data(tvbuff_t *data, packet_info *pinfo, proto_tree *parent, proto_tree *tree, const unit_t *unit,
          bool is_good)
{
    rk512i_block_t block = {unit->repeat_of != 0};

    if (is_good && rk512i_dissect(data, pinfo, parent, &block))
        return;
    add_bytes(tree, hf_3964r_data, data, 0, tvb_captured_length(data));
}

static void
dissect_block(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, proto_tree *tree, proto_item *root,
              const unit_t *unit)
{
    unsigned there = tvb_captured_length(tvb), end, begin, doubled;
    tvbuff_t *data = NULL;
    bool is_good;

    if (there < tvb_reported_length(tvb)) {
        proto_tree_add_item(tree, hf_3964r_raw, tvb, 0, there, ENC_NA);
        col_append_str(pinfo->cinfo, COL_INFO, "Block");
        return;
    }
    if (there >= END_SIZE && tvb_get_ntohs(tvb, there - END_SIZE) == (P3964R_DLE << 8 | ETX)) {
        end = there - END_SIZE;
        begin = begin_of_data(tvb, end);
        data = undouble(tvb, pinfo, begin, end, &doubled);
    }
    if (data == NULL) {
        proto_tree_add_item(tree, hf_3964r_raw, tvb, 0, -1, ENC_NA);
        expert_add_info(pinfo, root, &ei_3964r_broken);
        col_append_fstr(pinfo->cinfo, COL_INFO, "Broken-off block, %u bytes", there);
        return;
    }
    col_append_fstr(pinfo->cinfo, COL_INFO, "Block, %u byte%s%s", tvb_captured_length(data),
                    plurality(tvb_captured_length(data), "", "s"), unit->repeat_of != 0 ? "  [repeat]" : "");
    if (begin > 0)
        proto_tree_add_item(tree, hf_3964r_character, tvb, 0, 1, ENC_NA);
    proto_item_set_generated(
        proto_tree_add_uint(tree, hf_3964r_length, tvb, begin, end - begin, tvb_captured_length(data)));
    if (doubled > 0)
        proto_item_set_generated(
            proto_tree_add_uint(tree, hf_3964r_doubled, tvb, begin, end - begin, doubled));
    is_good = show_check(tvb, pinfo, tree, begin, end);
    show_data(data, pinfo, parent, tree, unit, is_good);
}

static void
dissect_character(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const unit_t *unit)
{
    static const value_string names[] = {
        {P3964R_STX, "STX"}, {P3964R_DLE, "DLE"}, {P3964R_NAK, "NAK"}, {0, NULL}};
    uint8_t character = compat_get_uint8(tvb, 0);

    proto_tree_add_item(tree, hf_3964r_character, tvb, 0, 1, ENC_NA);
    col_append_fstr(pinfo->cinfo, COL_INFO, "%s  %s", val_to_str_const(character, names, "Character"),
                    val_to_str_const(unit->meaning, sis_procedure_meanings, ""));
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
    times = sis_times(tvb, pinfo, tvb_reported_length(tvb), NULL);
    unit = find_unit(tvb, pinfo, &times);
    proto_item_append_text(root, ", %s", val_to_str_const(unit->meaning, sis_procedure_meanings, ""));
    if (unit->meaning == P3964R_BLOCK)
        dissect_block(tvb, pinfo, parent, tree, root, unit);
    else
        dissect_character(tvb, pinfo, tree, unit);
    add_generated(tree, hf_3964r_meaning, tvb, unit->meaning);
    show_unit(unit, tvb, pinfo, tree, root);
    show_answer(unit, &times, tvb, pinfo, tree);
    if (unit->meaning == P3964R_BLOCK)
        show_intervals(&times, tvb, pinfo, tree);
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb)); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

void
rk512_3964r_register(void)
{
    buses = kept_map_of_numbers();
    register_dissector("3964r", dissect_3964r, proto_3964r);
}

void
rk512_3964r_handoff(void)
{
    dissector_add_uint("sertap.framing", 1, find_dissector("3964r"));
}
