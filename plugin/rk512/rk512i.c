/* SPDX-License-Identifier: GPL-2.0-or-later */
/* RK512 with the Indramat extension (chapter 8): a command of 10 bytes or a follow-up of 4, with data; a
 * reaction of 4 bytes, with data after FETCH. All of it has the high byte first. What does not fit into 128
 * bytes comes in follow-ups, and what does not fit into a data block in several: DB nn first, DB 1 last (page
 * 8-27). */
#include "rk512/rk512i.h"

#include <epan/tap.h>

#include "items.h"
#include "kept.h"
#include "parts.h"
#include "protocol/fields.h"
#include "protocol/limits.h"
#include "sertap/line.h"
#include "sis/asked.h"
#include "sis/pieces.h"
#include "rk512/head.h"

#define COMMAND_SIZE   10u
#define FOLLOW_UP_SIZE 4u /* of a reaction, too */
#define FOLLOW_UP      0xFF

#define DATA_BLOCK 'D'

/* A long list comes in DB nn to DB 1 (page 8-27). Everything else with the Indramat head is in DB 0. */
#define LAST_OF_A_CHAIN 1u
#define LONGEST_CHAIN   5u

static int rk512i_tap = -1;

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

/* What chapter 8 does not allow; shown as notes. */
typedef enum {
    FROM_BOTH = 1 << 0,
    UNANSWERED_BEFORE = 1 << 1,
    TOO_MANY_DATA = 1 << 2,
    TOO_LONG_FOR_LAST = 1 << 3,
    TOO_FEW_DATA = 1 << 4,
} fault_t;

/* A telegram, with the results of the first pass. */
typedef struct {
    sis_asked_t asked;
    const job_t *job; /* NULL: none is known */
    job_t as_it_was;  /* its time; job points here */
    unsigned faults;  /* of fault_t */
    bool is_piece;    /* of several */
    bool is_first;    /* of its job */
    bool is_last;
    bool is_repeat;
} telegram_t;

typedef struct {
    uint64_t key;
    job_t job;
    telegram_t *request; /* waits for its reaction */
    uint8_t master;      /* line of the first command; 0: not known */
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

/* Data blocks, extended ones, timers and counters are counted in words, all others in bytes (Siemens). */
static unsigned
bytes_of(uint8_t kind, unsigned count)
{
    return strchr("DXTZ", kind) != NULL && kind != 0 ? 2 * count : count;
}

/* The only ones that SYNAX has (page 8-24). */
static bool
is_data_block(uint8_t command, uint8_t kind)
{
    return (command == RK512_SEND || command == RK512_FETCH) && kind == DATA_BLOCK;
}

static void
read_head(job_t *job, const dissection_t *d)
{
    job->has_head = is_data_block(job->command, job->kind) && job->block <= LONGEST_CHAIN &&
                    tvb_captured_length(d->tvb) >= COMMAND_SIZE + SYNAX_HEAD_SIZE;
    if (!job->has_head)
        return;
    job->info = tvb_get_ntohs(d->tvb, COMMAND_SIZE);
    job->axis = compat_get_uint8(d->tvb, COMMAND_SIZE + 2);
    job->ident = (sis_ident_t){.type = compat_get_uint8(d->tvb, COMMAND_SIZE + 3),
                               .number = tvb_get_ntohs(d->tvb, COMMAND_SIZE + 4)};
}

/* The first telegram of a block: a new job, or the next block of the present one. */
static void
begin_block(job_t *job, const dissection_t *d, telegram_t *telegram)
{
    uint8_t command = compat_get_uint8(d->tvb, 2), block = compat_get_uint8(d->tvb, 4);
    bool goes_on = job->is_open && job->left == 0 && job->command == command && block + 1 == job->block;

    if (!goes_on)
        *job = (job_t){.number = sis_next_transfer()};
    job->command = command;
    job->kind = compat_get_uint8(d->tvb, 3);
    job->block = block;
    job->left = bytes_of(job->kind, tvb_get_ntohs(d->tvb, 6));
    job->is_open =
        command == RK512_SEND && job->kind == DATA_BLOCK && block > LAST_OF_A_CHAIN && block <= LONGEST_CHAIN;
    telegram->is_first = !goes_on;
    telegram->is_piece = goes_on || job->is_open;
    if (goes_on)
        return;
    read_head(job, d);
    if (job->has_head && command == RK512_SEND && job->info & SYNAX_INFO_LAST &&
        (job->is_open || job->left > RK512_MOST_AT_ONCE))
        telegram->faults |= TOO_LONG_FOR_LAST;
}

/* Bytes of a block, in a SEND command or in the reaction to a FETCH. */
static void
take_bytes(job_t *job, telegram_t *telegram, unsigned count)
{
    if (count > job->left)
        telegram->faults |= TOO_MANY_DATA;
    job->left = count < job->left ? job->left - count : 0;
    telegram->is_last = job->left == 0 && !job->is_open;
    telegram->is_piece |= job->left > 0 || !telegram->is_first;
}

static void
note_command(bus_t *bus, const dissection_t *d, telegram_t *telegram)
{
    job_t *job = &bus->job;

    if (bus->request != NULL)
        telegram->faults |= UNANSWERED_BEFORE;
    bus->request = NULL;
    if (bus->master == 0)
        bus->master = telegram->asked.line;
    else if (telegram->asked.line != 0 && telegram->asked.line != bus->master)
        telegram->faults |= FROM_BOTH;
    if (!d->is_follow_up)
        begin_block(job, d, telegram);
    else if (job->left == 0 || job->command != compat_get_uint8(d->tvb, 2))
        return; /* nobody knows of what */
    telegram->job = &telegram->as_it_was;
    if (job->command != RK512_FETCH)
        take_bytes(job, telegram, tvb_captured_length(d->tvb) - d->data_at);
    telegram->as_it_was = *job;
    bus->request = telegram;
}

static void
note_reaction(bus_t *bus, const dissection_t *d, telegram_t *telegram, const sis_times_t *times)
{
    telegram_t *request = bus->request;
    unsigned count = tvb_captured_length(d->tvb) - d->data_at;
    bool is_error = compat_get_uint8(d->tvb, 3) != 0;

    if (request == NULL)
        return;
    bus->request = NULL;
    sis_asked_answer(&telegram->asked, &request->asked, times);
    telegram->job = &telegram->as_it_was;
    telegram->is_first = request->is_first;
    if (bus->job.command == RK512_FETCH && !is_error && count < MIN(bus->job.left, RK512_MOST_IN_TELEGRAM))
        telegram->faults |= TOO_FEW_DATA;
    if (bus->job.command == RK512_FETCH && count > 0)
        take_bytes(&bus->job, telegram, count);
    telegram->as_it_was = bus->job;
    if (is_error)
        bus->job = (job_t){0}; /* nothing continues it */
}

/* The job of this telegram; found in the first pass, and kept. A repeated block is ignored. */
static const telegram_t *
find_telegram(const dissection_t *d, const rk512i_block_t *block)
{
    telegram_t *telegram = kept_of_packet(d->pinfo, proto_rk512i, 0, sizeof *telegram);
    const sertap_record_t *record = sertap_record(d->pinfo);
    sis_times_t times = sis_times(d->tvb, d->pinfo, 0, NULL);
    bus_t *bus;

    if (telegram->asked.frame != 0)
        return telegram;
    times.end += record != NULL ? (int64_t)record->duration : 0;
    sis_asked_note(&telegram->asked, d->pinfo, &times);
    telegram->is_repeat = block != NULL && block->is_repeat;
    if (telegram->is_repeat || (d->is_cut && !d->is_snapped))
        return telegram;
    bus = sertap_kept_of_bus(buses, d->pinfo, sizeof *bus);
    if (d->is_snapped)
        *bus = (bus_t){.key = bus->key};
    else if (d->is_reaction)
        note_reaction(bus, d, telegram, &times);
    else
        note_command(bus, d, telegram);
    return telegram;
}

static void
note(const dissection_t *d, const char *text)
{
    expert_add_info_format(d->pinfo, d->root, &ei_synax_note, "%s", text);
}

static void
show_faults(const dissection_t *d)
{
    static const struct {
        fault_t fault;
        expert_field *ei;
        const char *text;
    } faults[] = {
        {FROM_BOTH, &ei_synax_note, "Both partners send commands, but a PPC only reacts (page 8-3)"},
        {UNANSWERED_BEFORE, &ei_synax_unanswered_before, "The command before this one got no reaction"},
        {TOO_MANY_DATA, &ei_synax_unexpected, "More data than the command says"},
        {TOO_FEW_DATA, &ei_synax_short, "Fewer data than the command asks for"},
        {TOO_LONG_FOR_LAST, &ei_synax_note,
         "With more than 1024 bytes, bit 1 of the info access is 0 (page 8-18)"},
    };

    for (unsigned i = 0; i < array_length(faults); i++) {
        if (d->telegram->faults & faults[i].fault)
            expert_add_info_format(d->pinfo, d->root, faults[i].ei, "%s", faults[i].text);
    }
}

/* Data blocks that are defined, and how many words they have. */
static void
check_command(const dissection_t *d, uint8_t block)
{
    unsigned count = tvb_get_ntohs(d->tvb, 6);

    if (!is_data_block(compat_get_uint8(d->tvb, 2), compat_get_uint8(d->tvb, 3))) {
        note(d, "SYNAX has only SEND and FETCH of data blocks (page 8-24)");
        return;
    }
    if (block > LONGEST_CHAIN && synax_block_text(block) == NULL)
        note(d, "Data block that is not defined");
    if (block == SYNAX_BLOCK_IO && count > RK512_MOST_IO_WORDS)
        note(d, "Data block 99 has at most 32 words (page 8-8)");
    if (block == SYNAX_BLOCK_MODE && count != 1)
        note(d, "Data block 100 has one word (page 8-10)");
    if (compat_get_uint8(d->tvb, 5) != 0)
        note(d, "Only whole data blocks can be accessed (page 8-7)");
}

/* The coordination flag: none is FF FF in Siemens' words, SYNAX writes zeros. Both are shown, none is judged.
 */
static void
show_command(const dissection_t *d)
{
    uint8_t block = compat_get_uint8(d->tvb, 4);
    unsigned count = tvb_get_ntohs(d->tvb, 6);
    const char *unit = bytes_of(compat_get_uint8(d->tvb, 3), 1) == 2 ? "word" : "byte";

    synax_add_block(d->tree, hf_rk512i_block, d->tvb, 4);
    proto_tree_add_item(d->tree, hf_rk512i_word, d->tvb, 5, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_rk512i_count, d->tvb, 6, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(d->tree, hf_rk512i_flag_byte, d->tvb, 8, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_rk512i_flag, d->tvb, 9, 1, ENC_NA);
    wmem_strbuf_append_printf(d->words, " DB %u, %u %s%s", block, count, unit, plurality(count, "", "s"));
    check_command(d, block);
}

/* Error numbers are Siemens'; SYNAX' table is lost. */
static void
show_reaction(const dissection_t *d)
{
    const job_t *job = d->telegram->job;
    synax_head_t head;
    uint8_t error = compat_get_uint8(d->tvb, 3);
    const char *text = val_to_str_const(error, sis_rk512_errors, "Not defined");
    proto_item *item =
        proto_tree_add_uint_format_value(d->tree, hf_rk512i_error, d->tvb, 3, 1, error, "%s (0x%02x)%s", text,
                                         error, error != 0 ? ", by Siemens' numbers" : "");

    if (job != NULL && job->has_head) {
        head = synax_head_of(job->info, job->axis, job->ident);
        wmem_strbuf_append(d->words, ": ");
        synax_recall_head(d->tree, d->pinfo, d->tvb, &head, d->words);
    }
    if (error == 0)
        return;
    expert_add_info_format(d->pinfo, item, &ei_synax_error, "Error 0x%02x: %s (Siemens' number)", error,
                           text);
    wmem_strbuf_append_printf(d->words, "  [error 0x%02x: %s (Siemens' number)]", error, text);
}

/* All bytes of a block, or of DB nn to DB 1. Those of SEND begin with the Indramat head. A reaction has
 * none, so its command names the parameter. */
static void
show_whole(const dissection_t *d, proto_tree *tree, tvbuff_t *tvb)
{
    const job_t *job = d->telegram->job;
    synax_head_t head;

    if (!job->has_head) {
        proto_tree_add_item(tree, hf_rk512i_data, tvb, 0, -1, ENC_NA);
        if (is_data_block(job->command, job->kind))
            synax_add_block_words(tree, d->pinfo, hf_rk512i_block_word, tvb, job->block, ENC_BIG_ENDIAN);
    } else if (d->is_reaction) {
        head = synax_head_of(job->info, job->axis, job->ident);
        synax_add_data(tree, d->pinfo, tvb, 0, ENC_BIG_ENDIAN, &head, d->words);
    } else {
        wmem_strbuf_append(d->words, ": ");
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

    proto_tree_add_item(d->tree, hf_rk512i_data, d->tvb, d->data_at, length, ENC_NA);
    wmem_strbuf_append_printf(d->words, ", %s of %u bytes", telegram->is_last ? "last piece" : "piece",
                              length);
    whole = sis_put_next(d->tree, d->pinfo, tvb_new_subset_remaining(d->tvb, d->data_at),
                         telegram->job->number, telegram->is_last);
    if (whole != NULL)
        show_whole(
            d, proto_tree_add_subtree(d->tree, whole, 0, -1, ett_rk512i_whole, NULL, "Data of all pieces"),
            whole);
}

static void
show_data(const dissection_t *d)
{
    const telegram_t *telegram = d->telegram;
    unsigned length = tvb_captured_length(d->tvb) - d->data_at;
    bool is_request = telegram->job != NULL && !d->is_reaction && telegram->job->command == RK512_FETCH;

    if (length == 0)
        return;
    if (telegram->job == NULL || telegram->is_repeat || (is_request && !telegram->job->has_head)) {
        proto_tree_add_item(d->tree, hf_rk512i_data, d->tvb, d->data_at, length, ENC_NA);
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

    proto_tree_add_item(d->tree, hf_rk512i_follow_up, d->tvb, 0, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_rk512i_zero, d->tvb, 1, 1, ENC_NA);
    d->data_at = FOLLOW_UP_SIZE;
    if (d->is_reaction) {
        wmem_strbuf_append(d->words, d->is_follow_up ? "Reaction to a follow-up" : "Reaction");
        return;
    }
    proto_tree_add_item(d->tree, hf_rk512i_command, d->tvb, 2, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_rk512i_kind, d->tvb, 3, 1, ENC_NA);
    wmem_strbuf_append_printf(d->words, "%s%s", val_to_str_const(third, sis_rk512_commands, "Command"),
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
    rk512i_answer_t *answer;

    if (d->telegram->asked.request_in == 0 || d->telegram->job == NULL || d->telegram->asked.elapsed < 0)
        return;
    answer = wmem_new(d->pinfo->pool, rk512i_answer_t);
    *answer = (rk512i_answer_t){d->telegram->job->command, d->telegram->asked.elapsed};
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
           (third == 0 || try_val_to_str(third, sis_rk512_commands) != NULL);
}

bool
rk512i_dissect(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data)
{
    sis_asked_fields_t fields = {hf_synax_request_in, hf_synax_answer_in, hf_synax_answer_time};
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
    else
        add_bytes(d.tree, hf_rk512i_data, tvb, d.data_at, tvb_captured_length(tvb));
    show_faults(&d);
    sis_asked_show(&d.telegram->asked, d.tree, tvb, pinfo, &fields);
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
    if (!rk512i_dissect(tvb, pinfo, parent, data))
        return 0;
    tvb_ensure_bytes_exist(tvb, 0, (int)there); /* throws where the capture has cut it */
    return tvb_captured_length(tvb);
}

void
rk512i_register(void)
{
    buses = kept_map_of_numbers();
    rk512i_tap = register_tap("rk512i");
    register_dissector("rk512i", dissect_rk512i, proto_rk512i);
}
