/* SPDX-License-Identifier: GPL-2.0-or-later */
/* RK512 with the Indramat extension (chapter 8): a command of 10 bytes or a follow-up of 4, with data; a
 * reaction of 4 bytes, with data after FETCH. All of it has the high byte first. What does not fit into 128
 * bytes comes in follow-ups, and what does not fit into a data block in several: DB nn first, DB 1 last (page
 * 8-27). */

#include "synax/rk512i.h"

#include <epan/proto_data.h>
#include <epan/tap.h>

#include "parameters/fields.h"
#include "sertap/line.h"
#include "synax/fields.h"
#include "synax/head.h"
#include "synax/pieces.h"

#define COMMAND_SIZE   10u
#define FOLLOW_UP_SIZE 4u /* of a reaction, too */
#define FOLLOW_UP      0xFF

#define SEND  'A'
#define FETCH 'E'

#define LAST_OF_A_CHAIN 1u  /* DB nn .. DB 1 */
#define FIRST_FIXED     98u /* from here on data blocks have meanings of their own */

int proto_rk512i = -1;

static int rk512i_tap = -1;

static int hf_follow_up = -1;
static int hf_zero = -1;
static int hf_command = -1;
static int hf_kind = -1;
static int hf_block = -1;
static int hf_word = -1;
static int hf_count = -1;
static int hf_flag_byte = -1;
static int hf_flag = -1;
static int hf_error = -1;
static int hf_data = -1;

static int ett_rk512i = -1;
static int ett_whole = -1;

/* What a command asks for, with its follow-ups and further blocks. */
typedef struct {
    uint32_t number;
    uint8_t command, kind, block;
    unsigned left; /* bytes of this block that are still to come */
    bool is_open;  /* more blocks follow */
    bool has_head; /* the Indramat head stood in its first telegram */
    uint16_t info;
    uint8_t axis;
    sis_ident_t ident;
} job_t;

/* A telegram, with the results of the first pass. */
typedef struct telegram {
    const job_t *job; /* NULL: none is known */
    job_t as_it_was;  /* its time; job points here */
    uint32_t frame;
    uint32_t request_in, answer_in; /* 0: none */
    int64_t end;                    /* of its last character, ns */
    int64_t elapsed;
    bool is_piece; /* of several */
    bool is_first; /* of its job */
    bool is_last;
    bool is_repeat;
} telegram_t;

typedef struct {
    uint64_t key;
    job_t job;
    telegram_t *request; /* waits for its reaction */
} bus_t;

static wmem_map_t *buses;

/* One telegram being decoded. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root;
    wmem_strbuf_t *words;
    const telegram_t *telegram;
    unsigned data_at; /* the beginning of its data */
    bool is_follow_up, is_reaction;
    bool is_cut;     /* a command without its whole head */
    bool is_snapped; /* the capture has not all of it */
} dissection_t;

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

/* Data blocks, extended ones, timers and counters are counted in words, all others in bytes (Siemens). */
static unsigned
bytes_of(uint8_t kind, unsigned count)
{
    return strchr("DXTZ", kind) != NULL && kind != 0 ? 2 * count : count;
}

static bool
has_indramat_head(uint8_t block)
{
    return block < FIRST_FIXED;
}

/* The first telegram of a block: a new job, or the next block of the present one. */
static void
begin_block(job_t *job, const dissection_t *d, telegram_t *telegram)
{
    uint8_t command = compat_get_uint8(d->tvb, 2), block = compat_get_uint8(d->tvb, 4);
    bool goes_on = job->is_open && job->left == 0 && job->command == command && block + 1 == job->block;
    unsigned data = tvb_captured_length(d->tvb) - COMMAND_SIZE;

    if (!goes_on) {
        *job = (job_t){.number = synax_next_transfer()};
        telegram->is_first = true;
        if (has_indramat_head(block) && data >= SYNAX_HEAD_SIZE) {
            job->has_head = true;
            job->info = tvb_get_ntohs(d->tvb, COMMAND_SIZE);
            job->axis = compat_get_uint8(d->tvb, COMMAND_SIZE + 2);
            job->ident = (sis_ident_t){compat_get_uint8(d->tvb, COMMAND_SIZE + 3),
                                       tvb_get_ntohs(d->tvb, COMMAND_SIZE + 4)};
        }
    }
    job->command = command;
    job->kind = compat_get_uint8(d->tvb, 3);
    job->block = block;
    job->left = bytes_of(job->kind, tvb_get_ntohs(d->tvb, 6));
    job->is_open = command != FETCH && block > LAST_OF_A_CHAIN && block < FIRST_FIXED;
    telegram->is_piece = goes_on || job->is_open;
}

/* Bytes of a block, in a SEND command or in the reaction to a FETCH. */
static void
take_bytes(job_t *job, telegram_t *telegram, unsigned count)
{
    job->left = count < job->left ? job->left - count : 0;
    telegram->is_last = job->left == 0 && !job->is_open;
    telegram->is_piece |= job->left > 0 || !telegram->is_first;
}

static void
note_command(bus_t *bus, const dissection_t *d, telegram_t *telegram)
{
    job_t *job = &bus->job;

    if (!d->is_follow_up)
        begin_block(job, d, telegram);
    else if (job->left == 0 || job->command != compat_get_uint8(d->tvb, 2))
        return; /* nobody knows of what */
    telegram->job = &telegram->as_it_was;
    if (job->command != FETCH)
        take_bytes(job, telegram, tvb_captured_length(d->tvb) - d->data_at);
    telegram->as_it_was = *job;
    bus->request = telegram;
}

static void
note_reaction(bus_t *bus, const dissection_t *d, telegram_t *telegram, int64_t begin)
{
    telegram_t *request = bus->request;

    if (request == NULL)
        return;
    bus->request = NULL;
    request->answer_in = telegram->frame;
    telegram->request_in = request->frame;
    telegram->elapsed = sertap_elapsed(request->end, begin);
    telegram->job = &telegram->as_it_was;
    telegram->is_first = request->is_first;
    if (bus->job.command == FETCH && tvb_captured_length(d->tvb) > d->data_at)
        take_bytes(&bus->job, telegram, tvb_captured_length(d->tvb) - d->data_at);
    telegram->as_it_was = bus->job;
}

/* The job of this telegram; found in the first pass, and kept. A repeated block is ignored. */
static const telegram_t *
find_telegram(const dissection_t *d, const synax_block_t *block)
{
    telegram_t *telegram = p_get_proto_data(wmem_file_scope(), d->pinfo, proto_rk512i, 0);
    const sertap_record_t *record = sertap_record(d->pinfo);
    int64_t begin = sertap_ns(&d->pinfo->abs_ts);
    bus_t *bus;

    if (telegram != NULL)
        return telegram;
    telegram = wmem_new0(wmem_file_scope(), telegram_t);
    p_add_proto_data(wmem_file_scope(), d->pinfo, proto_rk512i, 0, telegram);
    telegram->frame = d->pinfo->num;
    telegram->end = begin + (record != NULL ? (int64_t)record->duration : 0);
    telegram->is_repeat = block != NULL && block->is_repeat;
    if (telegram->is_repeat || (d->is_cut && !d->is_snapped))
        return telegram;
    bus = bus_of(d->pinfo);
    if (d->is_snapped)
        *bus = (bus_t){.key = bus->key};
    else if (d->is_reaction)
        note_reaction(bus, d, telegram, begin);
    else
        note_command(bus, d, telegram);
    return telegram;
}

static void
say_count(const dissection_t *d, uint8_t kind, unsigned count)
{
    const char *unit = bytes_of(kind, 1) == 2 ? "word" : "byte";

    wmem_strbuf_append_printf(d->words, ", %u %s%s", count, unit, plurality(count, "", "s"));
}

/* The coordination flag: none is FF FF in Siemens' words, SYNAX writes zeros. Both are shown, none is judged.
 */
static void
show_command(const dissection_t *d)
{
    uint8_t block = compat_get_uint8(d->tvb, 4);
    proto_item *item = proto_tree_add_item(d->tree, hf_block, d->tvb, 4, 1, ENC_NA);

    if (synax_block_text(block) != NULL)
        proto_item_append_text(item, " (%s)", synax_block_text(block));
    proto_tree_add_item(d->tree, hf_word, d->tvb, 5, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_count, d->tvb, 6, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(d->tree, hf_flag_byte, d->tvb, 8, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_flag, d->tvb, 9, 1, ENC_NA);
    wmem_strbuf_append_printf(d->words, " DB %u", block);
    say_count(d, compat_get_uint8(d->tvb, 3), tvb_get_ntohs(d->tvb, 6));
}

static const value_string rk512_commands[] = {
    {SEND, "SEND"},
    {FETCH, "FETCH"},
    {'O', "SEND to an extended data block"},
    {0, NULL},
};

static const value_string rk512_kinds[] = {
    {'D', "Data block"}, {'X', "Extended data block"},
    {'E', "Inputs"},     {'A', "Outputs"},
    {'M', "Flags"},      {'T', "Timers"},
    {'Z', "Counters"},   {0, NULL},
};

/* Siemens' numbers; SYNAX' table is lost. */
static const value_string rk512_errors[] = {
    {0x00, "No error"},
    {0x0A, "Access to the area not possible"},
    {0x0C, "Wrong data type"},
    {0x10, "Telegram not supported"},
    {0x12, "Object type not supported"},
    {0x14, "Block not found, or its number not allowed"},
    {0x16, "Unknown command"},
    {0x2A, "PLC stopped"},
    {0x32, "Block locked by its coordination flag"},
    {0x34, "Wrong length"},
    {0x36, "Follow-up without a command"},
    {0, NULL},
};

static void
show_reaction(const dissection_t *d)
{
    uint8_t error = compat_get_uint8(d->tvb, 3);
    const char *text = val_to_str_const(error, rk512_errors, "Not defined");
    proto_item *item =
        proto_tree_add_uint_format_value(d->tree, hf_error, d->tvb, 3, 1, error, "%s (0x%02x)%s", text, error,
                                         error != 0 ? ", by Siemens' numbers" : "");

    if (error == 0)
        return;
    expert_add_info_format(d->pinfo, item, &ei_synax_error, "Error 0x%02x: %s (Siemens' number)", error,
                           text);
    wmem_strbuf_append_printf(d->words, "  [error 0x%02x: %s]", error, text);
}

static void
show_links(const dissection_t *d)
{
    const telegram_t *telegram = d->telegram;

    if (telegram->answer_in != 0)
        proto_item_set_generated(
            proto_tree_add_uint(d->tree, hf_synax_answer_in, d->tvb, 0, 0, telegram->answer_in));
    if (telegram->request_in == 0)
        return;
    proto_item_set_generated(
        proto_tree_add_uint(d->tree, hf_synax_request_in, d->tvb, 0, 0, telegram->request_in));
    proto_item_set_generated(
        sertap_add_ms(d->tree, hf_synax_answer_time, d->tvb, 0, 0, d->pinfo->pool, telegram->elapsed));
}

/* All bytes of a block, or of DB nn to DB 1. Those of SEND begin with the Indramat head. A reaction has
 * none, so its command names the parameter. */
static void
show_whole(const dissection_t *d, proto_tree *tree, tvbuff_t *tvb)
{
    const job_t *job = d->telegram->job;
    synax_head_t head;

    if (job->has_head)
        wmem_strbuf_append(d->words, ": ");
    if (!job->has_head) {
        proto_tree_add_item(tree, hf_data, tvb, 0, -1, ENC_NA);
    } else if (d->is_reaction) {
        head = synax_head_of(job->info, job->axis, job->ident);
        synax_recall_head(tree, d->pinfo, tvb, &head, d->words);
        synax_add_data(tree, d->pinfo, tvb, 0, ENC_BIG_ENDIAN, &head, d->words);
    } else {
        head = synax_add_head(tree, d->pinfo, tvb, 0, ENC_BIG_ENDIAN, d->words);
        if (tvb_captured_length(tvb) > SYNAX_HEAD_SIZE)
            synax_add_data(tree, d->pinfo, tvb, SYNAX_HEAD_SIZE, ENC_BIG_ENDIAN, &head, d->words);
    }
}

static void
show_piece(const dissection_t *d)
{
    const telegram_t *telegram = d->telegram;
    unsigned length = tvb_captured_length(d->tvb) - d->data_at;
    tvbuff_t *whole;

    proto_tree_add_item(d->tree, hf_data, d->tvb, d->data_at, length, ENC_NA);
    wmem_strbuf_append_printf(d->words, ", %s of %u bytes", telegram->is_last ? "last piece" : "piece",
                              length);
    whole = synax_put_together(d->tree, d->pinfo, tvb_new_subset_remaining(d->tvb, d->data_at),
                               telegram->job->number, telegram->is_last);
    if (whole != NULL)
        show_whole(d, proto_tree_add_subtree(d->tree, whole, 0, -1, ett_whole, NULL, "Data of all pieces"),
                   whole);
}

static void
show_data(const dissection_t *d)
{
    const telegram_t *telegram = d->telegram;
    unsigned length = tvb_captured_length(d->tvb) - d->data_at;
    bool is_request = telegram->job != NULL && !d->is_reaction && telegram->job->command == FETCH;

    if (length == 0)
        return;
    if (telegram->job == NULL || telegram->is_repeat || (is_request && !telegram->job->has_head)) {
        proto_tree_add_item(d->tree, hf_data, d->tvb, d->data_at, length, ENC_NA);
        if (telegram->job == NULL && !telegram->is_repeat)
            expert_add_info_format(d->pinfo, d->root, &ei_synax_note, "Data of a command that is not known");
    } else if (telegram->is_piece && !is_request) {
        show_piece(d);
    } else {
        show_whole(d, d->tree, tvb_new_subset_remaining(d->tvb, d->data_at));
    }
}

static void
dissect_head(dissection_t *d)
{
    uint8_t third = compat_get_uint8(d->tvb, 2);

    proto_tree_add_item(d->tree, hf_follow_up, d->tvb, 0, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_zero, d->tvb, 1, 1, ENC_NA);
    d->data_at = FOLLOW_UP_SIZE;
    if (d->is_reaction) {
        wmem_strbuf_append(d->words, d->is_follow_up ? "Reaction to a follow-up" : "Reaction");
        return;
    }
    proto_tree_add_item(d->tree, hf_command, d->tvb, 2, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_kind, d->tvb, 3, 1, ENC_NA);
    wmem_strbuf_append_printf(d->words, "%s%s", val_to_str_const(third, rk512_commands, "Command"),
                              d->is_follow_up ? ", follow-up" : "");
    if (d->is_follow_up)
        return;
    d->is_cut = tvb_captured_length(d->tvb) < COMMAND_SIZE;
    if (d->is_cut) {
        if (!d->is_snapped)
            expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "A command has %u bytes",
                                   COMMAND_SIZE);
        wmem_strbuf_append(d->words, "  [cut]");
        return;
    }
    d->data_at = COMMAND_SIZE;
    show_command(d);
}

static void
queue_answer(const dissection_t *d)
{
    synax_answer_t *answer;

    if (d->telegram->request_in == 0 || d->telegram->job == NULL)
        return;
    answer = wmem_new(d->pinfo->pool, synax_answer_t);
    *answer = (synax_answer_t){d->telegram->job->command, d->telegram->elapsed};
    tap_queue_packet(rk512i_tap, d->pinfo, answer);
}

static bool
looks_like_rk512(tvbuff_t *tvb)
{
    uint8_t first, third;

    if (tvb_captured_length(tvb) < FOLLOW_UP_SIZE)
        return false;
    first = compat_get_uint8(tvb, 0);
    third = compat_get_uint8(tvb, 2);
    return (first == 0 || first == FOLLOW_UP) && compat_get_uint8(tvb, 1) == 0 &&
           (third == 0 || try_val_to_str(third, rk512_commands) != NULL);
}

bool
synax_rk512i_dissect(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data)
{
    dissection_t d = {.tvb = tvb, .pinfo = pinfo, .words = wmem_strbuf_new(pinfo->pool, "")};

    if (!looks_like_rk512(tvb))
        return false;
    d.root = proto_tree_add_item(parent, proto_rk512i, tvb, 0, -1, ENC_NA);
    d.tree = proto_item_add_subtree(d.root, ett_rk512i);
    d.is_follow_up = compat_get_uint8(tvb, 0) == FOLLOW_UP;
    d.is_reaction = compat_get_uint8(tvb, 2) == 0;
    d.is_snapped = tvb_captured_length(tvb) < tvb_reported_length(tvb);
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "RK512");
    dissect_head(&d);
    d.telegram = find_telegram(&d, data);
    if (d.is_reaction)
        show_reaction(&d);
    if (!d.is_cut && !d.is_snapped)
        show_data(&d);
    else if (tvb_captured_length(tvb) > d.data_at)
        proto_tree_add_item(d.tree, hf_data, tvb, d.data_at, tvb_captured_length(tvb) - d.data_at, ENC_NA);
    show_links(&d);
    queue_answer(&d);
    proto_item_append_text(d.root, ", %s", wmem_strbuf_get_str(d.words));
    col_append_fstr(pinfo->cinfo, COL_INFO, "  %s", wmem_strbuf_get_str(d.words));
    return true;
}

static int
dissect_rk512i(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data)
{
    unsigned there = tvb_reported_length(tvb);

    col_clear(pinfo->cinfo, COL_INFO);
    tvb_ensure_bytes_exist(tvb, 0, (int)MIN(there, FOLLOW_UP_SIZE));
    if (!synax_rk512i_dissect(tvb, pinfo, parent, data))
        return 0;
    tvb_ensure_bytes_exist(tvb, 0, (int)there); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

/* clang-format off */
static const value_string rk512_telegrams[] = {
    {0x00, "First telegram"},
    {0xFF, "Follow-up"},
    {0, NULL},
};

static hf_register_info fields[] = {
    {&hf_follow_up, {"Telegram", "rk512i.follow_up", FT_UINT8, BASE_HEX, VALS(rk512_telegrams), 0, NULL, HFILL}},
    {&hf_zero, {"Always 0", "rk512i.zero", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_command, {"Command", "rk512i.command", FT_UINT8, BASE_HEX, VALS(rk512_commands), 0, NULL, HFILL}},
    {&hf_kind, {"Kind of data", "rk512i.kind", FT_UINT8, BASE_HEX, VALS(rk512_kinds), 0, NULL, HFILL}},
    {&hf_block, {"Data block", "rk512i.block", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_word, {"Data word", "rk512i.word", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_count, {"Count", "rk512i.count", FT_UINT16, BASE_DEC, NULL, 0, "Words of data blocks, timers and counters, else bytes", HFILL}},
    {&hf_flag_byte, {"Byte of the coordination flag", "rk512i.flag_byte", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_flag, {"Bit and CPU of the coordination flag", "rk512i.flag", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_error, {"Error number", "rk512i.error", FT_UINT8, BASE_HEX, VALS(rk512_errors), 0, "Siemens' numbers; the table that SYNAX has is lost", HFILL}},
    {&hf_data, {"Data", "rk512i.data", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
};
/* clang-format on */

void
synax_rk512i_register(void)
{
    static int *trees[] = {&ett_rk512i, &ett_whole};

    proto_rk512i = proto_register_protocol("RK512 with the Indramat extension", "RK512I", "rk512i");
    proto_register_field_array(proto_rk512i, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    buses = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), wmem_int64_hash, g_int64_equal);
    rk512i_tap = register_tap("rk512i");
    register_dissector("rk512i", dissect_rk512i, proto_rk512i);
}
