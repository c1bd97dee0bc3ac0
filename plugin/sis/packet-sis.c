/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SIS telegram: every byte of the header, and the info column (DOK-GENERL-SIS-DEFINIT-IF02 chapter 2;
 * "ECODRIVE03": DOK-ECODR3-FGP-01VRS). */
#include "sis/packet-sis.h"

#include <epan/tap.h>

#include "items.h"
#include "parameters/values.h"
#include "parts.h"
#include "protocol/limits.h"
#include "sis/address.h"
#include "sis/learn.h"
#include "sis/segments.h"
#include "sis/timing.h"
#include "sis/told.h"

dissector_handle_t sis_handle;

static int expert = -1; /* the protocol of expert items: registered after all dissectors */

/* A telegram being decoded: the packet, the tree, and the place for marks of the info column. */
typedef struct {
    tvbuff_t *tvb; /* this telegram, and trailing bytes if no other telegram follows */
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root;
    unsigned declared; /* 0: its two lengths differ, or are missing */
    unsigned end;      /* available bytes of the telegram */
    sis_telegram_t *telegram;
    sis_record_t *record; /* its relations, as found */
    wmem_strbuf_t *marks; /* for the end of the info column: faults */
    sis_part_t *part;     /* for programs; NULL: none reads it */
} dissection_t;

/* A fault: an expert item, and a mark in the info column. */
static void
mark(const dissection_t *d, proto_item *ti, expert_field *ei, const char *text)
{
    expert_add_info(d->pinfo, ti, ei);
    sis_tell_expert(d->pinfo, ei);
    wmem_strbuf_append_printf(d->marks, "  [%s]", text);
}

/* Verified only if the whole telegram and its length are there. */
static void
dissect_checksum(const dissection_t *d)
{
    uint8_t checksum = compat_get_uint8(d->tvb, 1);
    unsigned flags = PROTO_CHECKSUM_NO_FLAGS;
    uint8_t expected = checksum;
    proto_item *item;

    if (d->tree == NULL && d->telegram->is_good)
        return;

    if (d->declared > 0 && tvb_bytes_exist(d->tvb, 0, d->declared)) {
        flags = PROTO_CHECKSUM_VERIFY;
        expected -= sis_sum(d->tvb, 0, d->declared);
        if (!d->telegram->is_good)
            sis_tell(d->pinfo, hf_sis_checksum_status, checksum == expected);
    }
    item = proto_tree_add_checksum(d->tree, d->tvb, 1, hf_sis_checksum, hf_sis_checksum_status, NULL,
                                   d->pinfo, expected, ENC_NA, flags);
    if (checksum == expected)
        return;
    /* The receiver's behaviour (chapter 2.4) depends on the kind of address. */
    expert_add_info_format(d->pinfo, item, &ei_sis_checksum_bad, "Wrong checksum: %s",
                           d->telegram->is_reaction
                               ? "the master waits (TwM) and sends its command again"
                               : "a station on a bus does not answer, a point-to-point station answers with "
                                 "status 0xF4");
    wmem_strbuf_append(d->marks, "  [wrong checksum]");
}

static void
dissect_lengths(const dissection_t *d)
{
    unsigned there = tvb_reported_length(d->tvb);
    proto_item *ti = proto_tree_add_item(d->tree, hf_sis_length_repeat, d->tvb, 3, 1, ENC_NA);

    if (d->declared == 0) {
        mark(d, ti, &ei_sis_length_differ, "lengths differ");
    } else if (there < d->declared) {
        expert_add_info(d->pinfo, ti, &ei_sis_length_short);
        sis_tell_expert(d->pinfo, &ei_sis_length_short);
        wmem_strbuf_append_printf(d->marks, "  [cut: %u of %u bytes]", there, d->declared);
    } else if (there > d->declared) {
        expert_add_info(d->pinfo, ti, &ei_sis_length_long);
        sis_tell_expert(d->pinfo, &ei_sis_length_long);
        wmem_strbuf_append_printf(d->marks, "  [%u byte%s too many]", there - d->declared,
                                  plurality(there - d->declared, "", "s"));
    }
}

/* IF02: bit 5 reserved, 6 and 7 the system state of the sender. */
static void
dissect_control_if02(const dissection_t *d, proto_item *ti)
{
    if (d->telegram->control & SIS_CONTROL_RESERVED)
        mark(d, ti, &ei_sis_control_reserved_set, "reserved bit");
    if (d->telegram->control & SIS_CONTROL_WARNING)
        mark(d, ti, &ei_sis_control_warning_set, "system warning");
    if (d->telegram->control & SIS_CONTROL_ERROR)
        mark(d, ti, &ei_sis_control_error_set, "system error");
}

#define ECODRIVE03_ERROR 6

/* ECODRIVE03: bits 5 to 7 are the state of a reaction. */
static void
dissect_control_ecodrive03(const dissection_t *d, proto_item *ti)
{
    unsigned status = d->telegram->control >> 5;
    const char *text = val_to_str_const(status, sis_control_status_ecodrive03, "");
    expert_field *ei = status == ECODRIVE03_ERROR ? &ei_sis_control_status_error : &ei_sis_control_status_set;

    if (status == 0)
        return;
    if (!d->telegram->is_reaction) {
        mark(d, ti, &ei_sis_control_reserved_set, "reserved bits");
        return;
    }
    expert_add_info_format(d->pinfo, ti, ei, "Status in the telegram control: %s", text);
    sis_tell_expert(d->pinfo, ei);
    wmem_strbuf_append_printf(d->marks, "  [control status %u: %s]", status, text);
}

/* SEND, FETCH or a message to several (fig. 2-3); NULL: a reaction, or no chapter says so. */
static const char *
kind_of_command(const sis_telegram_t *telegram)
{
    const char *text;

    if (telegram->is_reaction)
        return NULL;
    text = try_val_to_str(sis_receiver_kind(telegram->last_address), sis_message_kinds);
    return text != NULL ? text : try_val_to_str(sis_general_service(telegram->service), sis_command_kinds);
}

static void
dissect_control(const dissection_t *d)
{
    static int *const bits_if02[] = {&hf_sis_control_error,
                                     &hf_sis_control_warning,
                                     &hf_sis_control_reserved,
                                     &hf_sis_control_reaction,
                                     &hf_sis_control_number,
                                     &hf_sis_control_subaddresses,
                                     NULL};
    static int *const bits_ecodrive03[][5] = {{&hf_sis_control_reserved_bits, &hf_sis_control_reaction,
                                               &hf_sis_control_number, &hf_sis_control_subaddresses, NULL},
                                              {&hf_sis_control_status, &hf_sis_control_reaction,
                                               &hf_sis_control_number, &hf_sis_control_subaddresses, NULL}};
    bool is_if02 = pref_sis_edition == SIS_EDITION_IF02;
    int *const *bits = is_if02 ? bits_if02 : bits_ecodrive03[d->telegram->is_reaction];
    const char *kind;
    proto_item *ti = NULL;

    if (d->tree != NULL) {
        kind = kind_of_command(d->telegram);
        ti = proto_tree_add_bitmask_with_flags(d->tree, d->tvb, 4, hf_sis_control, ett_sis_control, bits,
                                               ENC_NA, BMT_NO_APPEND);
        proto_item_append_text(ti, " (%s%s%s)", d->telegram->is_reaction ? "reaction" : "command",
                               kind != NULL ? ", " : "", kind != NULL ? kind : "");
    }
    if (is_if02)
        dissect_control_if02(d, ti);
    else
        dissect_control_ecodrive03(d, ti);
}

static void
dissect_service(const dissection_t *d)
{
    uint8_t service = d->telegram->service;
    bool is_reserved = sis_service_is_reserved(service);
    bool is_unknown = pref_sis_edition == SIS_EDITION_ECODRIVE03 && !is_reserved &&
                      (service == 0x04 || (service >= 0x10 && service < 0x80));
    proto_item *ti = NULL;

    if (d->tree != NULL)
        ti = proto_tree_add_uint_format_value(d->tree, hf_sis_service, d->tvb, 5, 1, service, "%s (0x%02x)",
                                              sis_service_range_name(service), service);
    if (is_unknown || is_reserved)
        expert_add_info_format(d->pinfo, ti, &ei_sis_service_reserved, "%s",
                               is_unknown ? "ECODRIVE03 does not have this service" : "Reserved service");
}

static void
dissect_sender(const dissection_t *d)
{
    uint8_t sender = d->telegram->sender;
    sis_address_kind_t kind = sis_sender_kind(sender);
    proto_item *ti = proto_tree_add_uint_format_value(d->tree, hf_sis_sender, d->tvb, 6, 1, sender, "%u (%s)",
                                                      sender, val_to_str_const(kind, sis_address_kinds, ""));

    if (kind == SIS_SERVICE_MASTER)
        mark(d, ti, &ei_sis_sender_service_master, "service address 127");
    else if (kind == SIS_NO_SENDER)
        mark(d, ti, &ei_sis_sender_invalid, "invalid sender address");
}

/* One address of the list: the receiver itself, or a subaddress. */
static void
dissect_receiver(const dissection_t *d, int hf, unsigned offset, bool is_last)
{
    uint8_t receiver = compat_get_uint8(d->tvb, offset);
    sis_address_kind_t kind = sis_receiver_kind(receiver);
    const char *text = val_to_str_const(kind, sis_address_kinds, "");
    proto_item *ti;

    if (hf == hf_sis_subaddress)
        ti = proto_tree_add_uint_format(d->tree, hf, d->tvb, offset, 1, receiver, "Subaddress %u: %u (%s)",
                                        offset - SIS_STATIC_LENGTH + 1, receiver, text);
    else
        ti = proto_tree_add_uint_format_value(d->tree, hf, d->tvb, offset, 1, receiver, "%u (%s)", receiver,
                                              text);
    if (kind == SIS_NOT_ASSIGNED)
        mark(d, ti, &ei_sis_receiver_reserved, "address 127 is not assigned");
    if (kind == SIS_RESERVED)
        mark(d, ti, &ei_sis_receiver_reserved, "reserved address");
    if (kind == SIS_LEVEL_BROADCAST && !is_last)
        mark(d, ti, &ei_sis_receiver_level_broadcast, "254 before the last address");
    if (is_last && d->telegram->is_reaction && !sis_is_answered(receiver))
        mark(d, ti, &ei_sis_reaction_unexpected, "reaction to a group or broadcast");
}

/* Receiver, subaddresses and telegram number: the number comes directly after the last subaddress present. */
static void
dissect_addresses(const dissection_t *d)
{
    unsigned count = d->telegram->subaddress_count, number_at = SIS_STATIC_LENGTH + count;

    dissect_sender(d);
    dissect_receiver(d, hf_sis_receiver, 7, count == 0);
    for (unsigned i = 0; i < count && SIS_STATIC_LENGTH + i < d->end; i++)
        dissect_receiver(d, hf_sis_subaddress, SIS_STATIC_LENGTH + i, i + 1 == count);
    if (number_at < d->telegram->body_offset && number_at < d->end)
        proto_tree_add_item(d->tree, hf_sis_number, d->tvb, number_at, 1, ENC_NA);
    if (d->declared > 0 && d->telegram->body_offset > d->declared)
        mark(d, d->root, &ei_sis_length_header, "header longer than telegram");

    if (d->tree == NULL)
        return;
    add_generated(d->tree, hf_sis_talker, d->tvb, d->telegram->talker);
    add_generated(d->tree, hf_sis_listener, d->tvb, d->telegram->listener);
    proto_item_set_hidden(add_generated(d->tree, hf_sis_station, d->tvb, d->telegram->talker));
    proto_item_set_hidden(add_generated(d->tree, hf_sis_station, d->tvb, d->telegram->listener));
}

static void
show_command(const dissection_t *d, const sis_exchange_t *exchange)
{
    add_link(d->tree, hf_sis_reaction_in, d->tvb, exchange->reaction_in);
    if (exchange->first != NULL)
        add_link(d->tree, hf_sis_repeat_of, d->tvb, exchange->first->command_in);
    add_link(d->tree, hf_sis_unanswered_before, d->tvb, exchange->gave_up);
    if (sis_exchange_above(exchange) != NULL)
        add_link(d->tree, hf_sis_routed_from, d->tvb, sis_exchange_above(exchange)->command_in);
    add_link(d->tree, hf_sis_next_command_in, d->tvb, exchange->next_command_in);
    if (exchange->first != NULL) {
        expert_add_info(d->pinfo, d->root, &ei_sis_command_repeat);
        sis_tell(d->pinfo, hf_sis_repeat_of, exchange->first->command_in);
        wmem_strbuf_append(d->marks, "  [repeat]");
    }
    if (exchange->next_command_in != 0) {
        expert_add_info_format(d->pinfo, d->root, &ei_sis_command_unanswered,
                               "No reaction before the next command%s",
                               exchange->is_reaction_damaged ? "; a damaged telegram came between" : "");
        sis_tell_expert(d->pinfo, &ei_sis_command_unanswered);
        wmem_strbuf_append(d->marks, "  [no reaction]");
    }
}

static void
show_origin(const dissection_t *d)
{
    const sis_rare_t *rare = sis_rare(d->record, 0);

    if (rare->origin == SIS_TO_DAMAGED) {
        proto_item_append_text(add_link(d->tree, hf_sis_command_in, d->tvb, rare->damaged_in), ", damaged");
        expert_add_info(d->pinfo, d->root, &ei_sis_reaction_to_damaged);
    } else if (rare->origin == SIS_OWN_NUMBER) {
        expert_add_info_format(d->pinfo, d->root, &ei_sis_reaction_unasked,
                               "A command to 128 is answered with 128, not with the station's own number");
    } else {
        expert_add_info(d->pinfo, d->root, &ei_sis_reaction_unasked);
    }
}

static void
show_reaction(const dissection_t *d)
{
    const sis_record_t *record = d->record;
    const sis_exchange_t *exchange = record->exchange;
    proto_item *command;

    if (exchange == NULL) {
        show_origin(d);
        return;
    }
    command = add_link(d->tree, hf_sis_command_in, d->tvb, exchange->command_in);
    add_link(d->tree, hf_sis_routed_from, d->tvb, sis_rare(record, 0)->routed_from);
    add_link(d->tree, hf_sis_answered_in, d->tvb, record->reaction_before);
    if (record->reaction_before != 0) {
        expert_add_info(d->pinfo, d->root, &ei_sis_reaction_again);
        sis_tell_expert(d->pinfo, &ei_sis_reaction_again);
    } else if (exchange->has_time && !exchange->is_measured)
        proto_item_append_text(command, ", %s: the reaction time is not known",
                               exchange->reaction_time == 0 ? "in the same read"
                                                            : "whose end has a later time");
    else if (exchange->has_time && d->tree != NULL) {
        sertap_add_ms(d->tree, hf_sis_reaction_time, d->tvb, d->pinfo->pool, exchange->reaction_time);
        sertap_add_column_ms(d->tree, hf_sis_reaction_time_ms, d->tvb, exchange->reaction_time);
    }
}

/* Command and reaction, repeats, and the same exchange on other levels. */
static void
show_relations(const dissection_t *d)
{
    const sis_exchange_t *exchange = d->record->exchange;

    if (exchange != NULL)
        add_generated(d->tree, hf_sis_stream, d->tvb, exchange->stream->number);
    if (d->telegram->is_reaction)
        show_reaction(d);
    else if (exchange != NULL)
        show_command(d, exchange);
}

/* The request of an exchange is written when its command is read for the first time. */
static void
set_request(sis_body_t *body, const sis_exchange_t *exchange)
{
    bool is_read = exchange != NULL && exchange->request->is_read;

    if (is_read)
        body->asked = exchange->request;
    if (body->is_reaction)
        return;
    body->request = exchange != NULL && !is_read
                        ? exchange->request
                        : sis_request_new(body->pinfo->pool, body->service, NULL, false);
}

/* Decodes the useful data, with data of their exchange. Returns words for the packet list. */
static const char *
dissect_useful_data(const dissection_t *d)
{
    wmem_allocator_t *pool = d->pinfo->pool;
    const sis_telegram_t *telegram = d->telegram;
    sis_body_t body = {.telegram = telegram,
                       .tvb = d->tvb,
                       .pinfo = d->pinfo,
                       .tree = d->tree,
                       .root = d->root,
                       .item = d->root,
                       .offset = MIN(telegram->body_offset, d->end),
                       .end = d->end,
                       .is_cut = d->end < d->declared || d->declared == 0 || telegram->body_offset > d->end,
                       .is_reaction = telegram->is_reaction,
                       .service = telegram->service,
                       .summary = wmem_strbuf_new(pool, sis_service_name(pool, telegram->service)),
                       .marks = d->marks,
                       .record = telegram->is_good ? d->record : NULL};

    set_request(&body, d->record->exchange);
    if (telegram->is_good)
        show_relations(d);
    sis_dissect_body(&body);
    if (!telegram->is_before)
        sis_timing_dissect(d->telegram, d->record, &body);
    d->telegram->status_text = body.status_text;
    d->telegram->error_text = body.error_text;
    d->telegram->error = body.error;
    d->telegram->errors = body.errors;
    return wmem_strbuf_get_str(body.summary);
}

/* "3" or, through routers, "3/2/8". */
static const char *
route_text(const dissection_t *d, uint8_t first)
{
    const sis_telegram_t *telegram = d->telegram;
    wmem_strbuf_t *text;

    if (telegram->subaddress_count == 0)
        return sis_station_text(d->pinfo->pool, first);
    text = wmem_strbuf_new(d->pinfo->pool, sis_station_text(d->pinfo->pool, first));
    for (unsigned i = 0; i < telegram->subaddress_count; i++) {
        if (SIS_STATIC_LENGTH + i >= d->end)
            break;
        wmem_strbuf_append_printf(
            text, "/%s", sis_station_text(d->pinfo->pool, compat_get_uint8(d->tvb, SIS_STATIC_LENGTH + i)));
    }
    return wmem_strbuf_get_str(text);
}

/* Who speaks to whom. */
static const char *
stations_text(const dissection_t *d)
{
    wmem_allocator_t *pool = d->pinfo->pool;
    const sis_telegram_t *telegram = d->telegram;

    if (telegram->is_reaction)
        return wmem_strconcat(pool, route_text(d, telegram->talker), " -> ",
                              sis_number_text(telegram->listener), NULL);
    return wmem_strconcat(pool, sis_number_text(telegram->talker), " -> ", route_text(d, telegram->listener),
                          NULL);
}

/* Relations of the telegram, and its real talker: a reaction keeps its command's addresses, unless a
 * device has swapped them. */
static void
find_record(dissection_t *d)
{
    sis_telegram_t *telegram = d->telegram;

    d->record = sis_learn_telegram(d->tvb, d->pinfo, telegram);
    telegram->record = d->record;
    if (d->record->is_swapped) {
        telegram->talker = telegram->sender;
        telegram->listener = telegram->receiver;
    }
}

static void
dissect_start(const dissection_t *d)
{
    proto_item *ti = proto_tree_add_item(d->tree, hf_sis_start, d->tvb, 0, 1, ENC_NA);

    if (d->part != NULL)
        d->part->is_telegram = true;
    if (compat_get_uint8(d->tvb, 0) != SIS_START)
        mark(d, ti, &ei_sis_start_missing, "no start character");
}

#define HEAD_LENGTH 160 /* characters: Wireshark cuts a line of the tree soon after */

/* Header and useful data; the packet list says "16 -> 3  Command  Read parameter S-0-0044". What
 * is wrong goes before that: a narrow window shows it, too. */
static void
dissect_whole_telegram(dissection_t *d)
{
    sis_packet_t *packet = sis_packet(d->pinfo);
    const char *stations, *kind, *words;

    d->telegram = sis_telegram_read(d->tvb, d->pinfo);
    if (d->part != NULL)
        d->part->telegram = d->telegram;
    find_record(d);
    sis_set_addresses(d->pinfo, d->telegram->talker, d->telegram->listener);
    dissect_start(d);
    dissect_checksum(d);
    proto_tree_add_item(d->tree, hf_sis_length, d->tvb, 2, 1, ENC_NA);
    dissect_lengths(d);
    dissect_control(d);
    dissect_service(d);
    dissect_addresses(d);
    words = dissect_useful_data(d);
    add_bytes(d->tree, hf_sis_raw, d->tvb, d->end, tvb_captured_length(d->tvb));

    stations = stations_text(d);
    kind = d->telegram->is_reaction ? "Reaction" : "Command";
    col_append_lstr(d->pinfo->cinfo, COL_INFO, stations, "  ", kind, wmem_strbuf_get_str(d->marks), "  ",
                    words, COL_ADD_LSTR_TERMINATOR);
    if (d->tree)
        proto_item_append_text(d->root, ", %s, %s, %s", stations, kind,
                               sis_text_shortened(d->pinfo->pool, words, HEAD_LENGTH));
    packet->last = d->telegram;
    if (!d->telegram->is_before)
        tap_queue_packet(sis_tap, d->pinfo, d->telegram);
}

/* Fewer than the 8 bytes of every telegram. */
static void
dissect_stump(const dissection_t *d)
{
    unsigned there = tvb_reported_length(d->tvb);

    dissect_start(d);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "Cut telegram, %u of at least %u bytes%s", there,
                    SIS_STATIC_LENGTH, wmem_strbuf_get_str(d->marks));
    add_bytes(d->tree, hf_sis_raw, d->tvb, 1, d->end);
    expert_add_info(d->pinfo, d->root, &ei_sis_length_short);
    sis_tell_expert(d->pinfo, &ei_sis_length_short);
}

/* Neither a start character nor a valid length: addresses would be invented. */
static void
dissect_no_telegram(const dissection_t *d)
{
    unsigned there = tvb_reported_length(d->tvb);

    col_append_fstr(d->pinfo->cinfo, COL_INFO, "Not a telegram, %u byte%s", there, plurality(there, "", "s"));
    proto_item_append_text(d->root, ", not a telegram");
    expert_add_info(d->pinfo, d->root, &ei_sis_start_missing);
    sis_tell_expert(d->pinfo, &ei_sis_start_missing);
    proto_tree_add_item(d->tree, hf_sis_raw, d->tvb, 0, tvb_captured_length(d->tvb), ENC_NA);
}

/* Whether anything below a telegram is looked at: a field of SIS, or an expert item. If a filter needs other
 * fields only, there is a tree, but nobody sees what is in it. */
static bool
is_looked_at(proto_tree *tree)
{
    if (expert < 0)
        expert = proto_get_id_by_filter_name("_ws.expert");
    return proto_field_is_referenced(tree, proto_sis) || proto_field_is_referenced(tree, expert);
}

void
sis_dissect_telegram(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent)
{
    unsigned there = tvb_reported_length(tvb);
    dissection_t d = {.tvb = tvb,
                      .pinfo = pinfo,
                      .declared = sis_declared_length(tvb, 0),
                      .marks = wmem_strbuf_new(pinfo->pool, ""),
                      .part = sis_part_begin(pinfo)};

    sis_separate(pinfo);
    d.end = MIN(d.declared > 0 ? d.declared : there, tvb_captured_length(tvb));
    d.root = proto_tree_add_item(parent, proto_sis, tvb, 0, -1, ENC_NA);
    d.tree = is_looked_at(parent) ? proto_item_add_subtree(d.root, ett_sis) : NULL;
    if (compat_get_uint8(tvb, 0) != SIS_START && d.declared != there)
        dissect_no_telegram(&d);
    else if (there < SIS_STATIC_LENGTH)
        dissect_stump(&d);
    else
        dissect_whole_telegram(&d);
    sis_tell_packed(tvb, pinfo, d.tree);
    /* Throws where the capture has cut the packet, and Wireshark then says so. It stands last, so that all
     * captured bytes are dissected before. */
    tvb_ensure_bytes_exist(tvb, 0, (int)there);
}

/* Where the telegram at offset ends: at its declared length if another one starts there, else with the data.
 * A damaged one also ends where a good one begins: if a character was lost, its length counts the first one
 * of the next. */
static unsigned
telegram_extent(tvbuff_t *tvb, unsigned offset)
{
    unsigned there = tvb_reported_length_remaining(tvb, offset);
    unsigned captured = tvb_captured_length_remaining(tvb, offset);
    unsigned declared = sis_declared_length(tvb, offset), next = offset;
    bool is_followed =
        declared > 0 && declared < captured && compat_get_uint8(tvb, offset + declared) == SIS_START;
    unsigned end = offset + (is_followed ? declared : captured);

    if (declared <= captured && !sis_is_good(tvb, offset)) {
        while (compat_find_uint8(tvb, next + 1, SIS_START, &next) && next < end) {
            if (sis_is_good(tvb, next))
                return next - offset;
        }
    }
    return is_followed ? declared : there;
}

/* A packet as long as Wireshark allows would have more telegrams than Wireshark can show or count. */
static void
dissect_rest(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent)
{
    unsigned there = tvb_reported_length(tvb);
    proto_item *root = proto_tree_add_item(parent, proto_sis, tvb, 0, -1, ENC_NA);
    proto_tree *tree = proto_item_add_subtree(root, ett_sis);

    sis_separate(pinfo);
    col_append_fstr(pinfo->cinfo, COL_INFO, "Not decoded, %u byte%s", there, plurality(there, "", "s"));
    proto_item_append_text(root, ", not decoded");
    expert_add_info(pinfo, root, &ei_sis_telegrams_many);
    proto_tree_add_item(tree, hf_sis_raw, tvb, 0, tvb_captured_length(tvb), ENC_NA);
    sis_tell_packed(tvb, pinfo, tree);
    tvb_ensure_bytes_exist(tvb, 0, (int)there);
}

int
sis_dissect_packet(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    unsigned offset = 0;

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SIS");
    col_clear(pinfo->cinfo, COL_INFO);
    while (offset < SIS_MOST_DISSECTED && tvb_reported_length_remaining(tvb, offset) > 0) {
        unsigned extent = telegram_extent(tvb, offset);

        sis_dissect_telegram(extent == tvb_reported_length(tvb) ? tvb
                                                                : tvb_new_subset_length(tvb, offset, extent),
                             pinfo, tree);
        offset += extent;
    }
    if (tvb_reported_length_remaining(tvb, offset) > 0)
        dissect_rest(tvb_new_subset_remaining(tvb, offset), pinfo, tree);
    return tvb_captured_length(tvb);
}

void
sis_packet_register(void)
{
    sis_tap = register_tap("sis");
    sis_handle = register_dissector("sis", sis_dissect_packet, proto_sis);
}

void
sis_packet_handoff(void)
{
    dissector_add_uint("sertap.framing", 0, sis_handle);
}
