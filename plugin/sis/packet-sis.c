/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SIS telegram: every byte of the header, and the info column (DOK-GENERL-SIS-DEFINIT-IF02 chapter 2;
 * "ECODRIVE03": DOK-ECODR3-FGP-01VRS). */

#include "sis/packet-sis.h"

#include <epan/tap.h>

#include "parameters/text.h"
#include "sis/address.h"
#include "sis/dispatch.h"
#include "sis/timing.h"

#define CONTROL_RESERVED 0x20
#define CONTROL_WARNING  0x40
#define CONTROL_ERROR    0x80
#define CONTROL_STATUS   0xE0

#define MAX_SUBADDRESSES 7

dissector_handle_t sis_handle;

static int hf_start = -1;
static int hf_checksum = -1;
static int hf_checksum_status = -1;
static int hf_length = -1;
static int hf_length_repeat = -1;
static int hf_control = -1;
static int hf_control_subaddresses = -1;
static int hf_control_number = -1;
static int hf_control_reaction = -1;
static int hf_control_reserved = -1;
static int hf_control_warning = -1;
static int hf_control_error = -1;
static int hf_control_status = -1;
static int hf_control_reserved_bits = -1;
static int hf_sender = -1;
static int hf_receiver = -1;
static int hf_subaddress = -1;
static int hf_number = -1;
static int hf_talker = -1;
static int hf_listener = -1;
static int hf_station = -1;

static int ett_sis = -1;
static int ett_control = -1;

static expert_field ei_start = EI_INIT;
static expert_field ei_checksum = EI_INIT;
static expert_field ei_lengths_differ = EI_INIT;
static expert_field ei_too_short = EI_INIT;
static expert_field ei_too_long = EI_INIT;
static expert_field ei_too_many = EI_INIT;
static expert_field ei_header_too_long = EI_INIT;
static expert_field ei_control_reserved = EI_INIT;
static expert_field ei_control_status = EI_INIT;
static expert_field ei_control_error = EI_INIT;
static expert_field ei_system_warning = EI_INIT;
static expert_field ei_system_error = EI_INIT;
static expert_field ei_service_reserved = EI_INIT;
static expert_field ei_sender_service = EI_INIT;
static expert_field ei_sender_invalid = EI_INIT;
static expert_field ei_receiver_reserved = EI_INIT;
static expert_field ei_level_broadcast = EI_INIT;
static expert_field ei_reaction_unexpected = EI_INIT;

static const value_string checksum_states[] = {
    {PROTO_CHECKSUM_E_BAD, "Bad"},
    {PROTO_CHECKSUM_E_GOOD, "Good"},
    {PROTO_CHECKSUM_E_UNVERIFIED, "Unverified"},
    {0, NULL},
};

static const true_false_string command_reaction = {"Reaction telegram", "Command telegram"};
static const true_false_string present_absent = {"Present", "Not present"};

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
} dissection_t;

/* A fault: an expert item, and a mark in the info column. */
static void
mark(const dissection_t *d, proto_item *ti, expert_field *ei, const char *text)
{
    expert_add_info(d->pinfo, ti, ei);
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
    }
    item = proto_tree_add_checksum(d->tree, d->tvb, 1, hf_checksum, hf_checksum_status, NULL, d->pinfo,
                                   expected, ENC_NA, flags);
    if (checksum == expected)
        return;
    /* The receiver's behaviour (chapter 2.4) depends on the kind of address. */
    expert_add_info_format(d->pinfo, item, &ei_checksum, "Wrong checksum: %s [should be 0x%02x]",
                           d->telegram->is_reaction
                               ? "the master waits (TwM) and sends its command again"
                               : "a station on a bus does not answer, a point-to-point station answers with "
                                 "status 0xF4",
                           expected);
    wmem_strbuf_append(d->marks, "  [wrong checksum]");
}

static void
dissect_lengths(const dissection_t *d)
{
    unsigned there = tvb_reported_length(d->tvb);
    proto_item *ti = proto_tree_add_item(d->tree, hf_length_repeat, d->tvb, 3, 1, ENC_NA);

    if (d->declared == 0) {
        mark(d, ti, &ei_lengths_differ, "lengths differ");
    } else if (there < d->declared) {
        expert_add_info_format(d->pinfo, ti, &ei_too_short, "The telegram is cut: %u of %u bytes", there,
                               d->declared);
        wmem_strbuf_append_printf(d->marks, "  [cut: %u of %u bytes]", there, d->declared);
    } else if (there > d->declared) {
        expert_add_info_format(d->pinfo, ti, &ei_too_long, "%u byte%s the end of the telegram",
                               there - d->declared, plurality(there - d->declared, " follows", "s follow"));
        wmem_strbuf_append_printf(d->marks, "  [%u byte%s too many]", there - d->declared,
                                  plurality(there - d->declared, "", "s"));
    }
}

/* IF02: bit 5 reserved, 6 and 7 the system state of the sender. */
static void
dissect_control_if02(const dissection_t *d, proto_item *ti)
{
    if (d->telegram->control & CONTROL_RESERVED)
        mark(d, ti, &ei_control_reserved, "reserved bit");
    if (d->telegram->control & CONTROL_WARNING)
        mark(d, ti, &ei_system_warning, "system warning");
    if (d->telegram->control & CONTROL_ERROR)
        mark(d, ti, &ei_system_error, "system error");
}

#define ECODRIVE03_ERROR 6

/* ECODRIVE03: bits 5 to 7 are the state of a reaction. */
static void
dissect_control_ecodrive03(const dissection_t *d, proto_item *ti)
{
    unsigned status = d->telegram->control >> 5;
    const char *text = val_to_str_const(status, sis_control_status_ecodrive03, "");

    if (status == 0)
        return;
    if (!d->telegram->is_reaction) {
        mark(d, ti, &ei_control_reserved, "reserved bits");
        return;
    }
    expert_add_info_format(d->pinfo, ti, status == ECODRIVE03_ERROR ? &ei_control_error : &ei_control_status,
                           "Status in the telegram control: %s", text);
    wmem_strbuf_append_printf(d->marks, "  [control status %u: %s]", status, text);
}

static void
dissect_control(const dissection_t *d)
{
    static int *const bits_if02[] = {&hf_control_error,
                                     &hf_control_warning,
                                     &hf_control_reserved,
                                     &hf_control_reaction,
                                     &hf_control_number,
                                     &hf_control_subaddresses,
                                     NULL};
    static int *const bits_ecodrive03[][5] = {
        {&hf_control_reserved_bits, &hf_control_reaction, &hf_control_number, &hf_control_subaddresses, NULL},
        {&hf_control_status, &hf_control_reaction, &hf_control_number, &hf_control_subaddresses, NULL}};
    bool is_if02 = sis_edition == SIS_EDITION_IF02;
    int *const *bits = is_if02 ? bits_if02 : bits_ecodrive03[d->telegram->is_reaction];
    proto_item *ti = NULL;

    if (d->tree != NULL) {
        ti = proto_tree_add_bitmask_with_flags(d->tree, d->tvb, 4, hf_control, ett_control, bits, ENC_NA,
                                               BMT_NO_APPEND);
        proto_item_append_text(ti, " (%s)", d->telegram->is_reaction ? "reaction" : "command");
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
    bool is_unknown = sis_edition == SIS_EDITION_ECODRIVE03 && !is_reserved &&
                      (service == 0x04 || (service >= 0x10 && service < 0x80));
    proto_item *ti = NULL;

    if (d->tree != NULL)
        ti = proto_tree_add_uint_format_value(d->tree, hf_sis_service, d->tvb, 5, 1, service, "%s (0x%02x)",
                                              sis_service_range_name(service), service);
    if (is_unknown || is_reserved)
        expert_add_info_format(d->pinfo, ti, &ei_service_reserved, "%s",
                               is_unknown ? "ECODRIVE03 does not have this service" : "Reserved service");
}

static void
dissect_sender(const dissection_t *d)
{
    uint8_t sender = d->telegram->sender;
    sis_address_kind_t kind = sis_sender_kind(sender);
    proto_item *ti = proto_tree_add_uint_format_value(d->tree, hf_sender, d->tvb, 6, 1, sender, "%u (%s)",
                                                      sender, sis_kind_text(kind));

    if (kind == SIS_SERVICE_MASTER)
        mark(d, ti, &ei_sender_service, "service address 127");
    else if (kind == SIS_NO_SENDER)
        mark(d, ti, &ei_sender_invalid, "invalid sender address");
}

/* One address of the list: the receiver itself, or a subaddress. */
static void
dissect_receiver(const dissection_t *d, int hf, unsigned offset, bool is_last)
{
    uint8_t receiver = compat_get_uint8(d->tvb, offset);
    sis_address_kind_t kind = sis_receiver_kind(receiver);
    const char *text = sis_kind_text(kind);
    proto_item *ti;

    if (hf == hf_subaddress)
        ti = proto_tree_add_uint_format(d->tree, hf, d->tvb, offset, 1, receiver, "Subaddress %u: %u (%s)",
                                        offset - SIS_STATIC_LENGTH + 1, receiver, text);
    else
        ti = proto_tree_add_uint_format_value(d->tree, hf, d->tvb, offset, 1, receiver, "%u (%s)", receiver,
                                              text);
    if (kind == SIS_NOT_ASSIGNED)
        mark(d, ti, &ei_receiver_reserved, "address 127 is not assigned");
    if (kind == SIS_RESERVED)
        mark(d, ti, &ei_receiver_reserved, "reserved address");
    if (kind == SIS_LEVEL_BROADCAST && !is_last)
        mark(d, ti, &ei_level_broadcast, "254 before the last address");
    if (is_last && d->telegram->is_reaction && !sis_is_answered(receiver))
        mark(d, ti, &ei_reaction_unexpected, "reaction to a group or broadcast");
}

static void
add_generated_station(const dissection_t *d, int hf, uint8_t station, bool hidden)
{
    proto_item *ti = proto_tree_add_uint(d->tree, hf, d->tvb, 0, 0, station);

    proto_item_set_generated(ti);
    if (hidden)
        proto_item_set_hidden(ti);
}

/* Receiver, subaddresses and telegram number: the number comes directly after the last subaddress present. */
static void
dissect_addresses(const dissection_t *d)
{
    unsigned count = d->telegram->subaddress_count, number_at = SIS_STATIC_LENGTH + count;

    dissect_sender(d);
    dissect_receiver(d, hf_receiver, 7, count == 0);
    for (unsigned i = 0; i < count && SIS_STATIC_LENGTH + i < d->end; i++)
        dissect_receiver(d, hf_subaddress, SIS_STATIC_LENGTH + i, i + 1 == count);
    if (number_at < d->telegram->body_offset && number_at < d->end)
        proto_tree_add_item(d->tree, hf_number, d->tvb, number_at, 1, ENC_NA);
    if (d->declared > 0 && d->telegram->body_offset > d->declared)
        mark(d, d->root, &ei_header_too_long, "header longer than telegram");

    if (d->tree == NULL)
        return;
    add_generated_station(d, hf_talker, d->telegram->talker, false);
    add_generated_station(d, hf_listener, d->telegram->listener, false);
    add_generated_station(d, hf_station, d->telegram->talker, true);
    add_generated_station(d, hf_station, d->telegram->listener, true);
}

/* Decodes the useful data, with data of their exchange. Returns words for the packet list. */
static const char *
dissect_useful_data(const dissection_t *d)
{
    wmem_allocator_t *pool = d->pinfo->pool;
    const sis_telegram_t *telegram = d->telegram;
    sis_record_t *record = d->record;
    sis_exchange_t *exchange = record->exchange;
    sis_request_t request = {.service = telegram->service};
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
                       .request = telegram->is_reaction ? NULL : &request,
                       .asked = exchange != NULL ? exchange->request : NULL,
                       .record = telegram->is_good ? record : NULL,
                       .accesses = have_tap_listener(sis_tap) ? wmem_list_new(pool) : NULL};

    sis_timing_note(record, telegram, d->pinfo);
    if (telegram->is_good)
        sis_exchange_show(record, d->tvb, d->pinfo, d->tree, d->root, telegram, d->marks);
    sis_dissect_body(&body);
    if (exchange != NULL && !telegram->is_reaction)
        sis_exchange_keep(exchange, &request);
    sis_timing_dissect(d->telegram, record, &body);
    d->telegram->status_text = body.status_text;
    d->telegram->error_text = body.error_text;
    d->telegram->error = body.error;
    d->telegram->errors = body.errors;
    d->telegram->accesses = body.accesses;
    return wmem_strbuf_get_str(body.summary);
}

static void
dissect_trailer(const dissection_t *d)
{
    unsigned there = tvb_captured_length(d->tvb);

    if (d->end < there)
        proto_tree_add_item(d->tree, hf_sis_raw, d->tvb, d->end, there - d->end, ENC_NA);
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
find_exchange(dissection_t *d)
{
    sis_telegram_t *telegram = d->telegram;

    d->record = sis_exchange_find(d->tvb, d->pinfo, telegram);
    if (sis_exchange_is_swapped(d->record, telegram)) {
        telegram->talker = telegram->sender;
        telegram->listener = telegram->receiver;
    }
}

static void
dissect_start(const dissection_t *d)
{
    proto_item *ti = proto_tree_add_item(d->tree, hf_start, d->tvb, 0, 1, ENC_NA);

    if (compat_get_uint8(d->tvb, 0) != SIS_START)
        mark(d, ti, &ei_start, "no start character");
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
    find_exchange(d);
    sis_set_addresses(d->pinfo, d->telegram->talker, d->telegram->listener);
    dissect_start(d);
    dissect_checksum(d);
    proto_tree_add_item(d->tree, hf_length, d->tvb, 2, 1, ENC_NA);
    dissect_lengths(d);
    dissect_control(d);
    dissect_service(d);
    dissect_addresses(d);
    words = dissect_useful_data(d);
    dissect_trailer(d);

    stations = stations_text(d);
    kind = d->telegram->is_reaction ? "Reaction" : "Command";
    col_append_lstr(d->pinfo->cinfo, COL_INFO, stations, "  ", kind, wmem_strbuf_get_str(d->marks), "  ",
                    words, COL_ADD_LSTR_TERMINATOR);
    if (d->tree)
        proto_item_append_text(d->root, ", %s, %s, %s", stations, kind,
                               sis_text_shortened(d->pinfo->pool, words, HEAD_LENGTH));
    d->telegram->before = packet->last;
    packet->last = d->telegram;
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
    if (there > 1)
        proto_tree_add_item(d->tree, hf_sis_raw, d->tvb, 1, there - 1, ENC_NA);
    expert_add_info_format(d->pinfo, d->root, &ei_too_short,
                           "The telegram is cut: %u byte%s, it has at least %u", there,
                           plurality(there, "", "s"), SIS_STATIC_LENGTH);
}

/* Neither a start character nor a valid length: addresses would be invented. */
static void
dissect_no_telegram(const dissection_t *d)
{
    unsigned there = tvb_reported_length(d->tvb);

    col_append_fstr(d->pinfo->cinfo, COL_INFO, "Not a telegram, %u byte%s", there, plurality(there, "", "s"));
    proto_item_append_text(d->root, ", not a telegram");
    expert_add_info(d->pinfo, d->root, &ei_start);
    proto_tree_add_item(d->tree, hf_sis_raw, d->tvb, 0, there, ENC_NA);
}

/* The info column may have text: another telegram of this packet, or TCP's text, which ends with a space. */
static void
separate(packet_info *pinfo)
{
    const char *info = col_get_text(pinfo->cinfo, COL_INFO);

    if (info != NULL && info[0] != '\0' && !g_str_has_suffix(info, " "))
        col_append_str(pinfo->cinfo, COL_INFO, " | ");
}

void
sis_dissect_telegram(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent)
{
    unsigned there = tvb_reported_length(tvb);
    dissection_t d = {.tvb = tvb,
                      .pinfo = pinfo,
                      .declared = sis_declared_length(tvb, 0),
                      .marks = wmem_strbuf_new(pinfo->pool, "")};

    separate(pinfo);
    d.end = MIN(d.declared > 0 ? d.declared : there, tvb_captured_length(tvb));
    d.root = proto_tree_add_item(parent, proto_sis, tvb, 0, -1, ENC_NA);
    d.tree = proto_item_add_subtree(d.root, ett_sis);
    if (compat_get_uint8(tvb, 0) != SIS_START && d.declared != there)
        dissect_no_telegram(&d);
    else if (there < SIS_STATIC_LENGTH)
        dissect_stump(&d);
    else
        dissect_whole_telegram(&d);
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

/* A packet as long as Wireshark allows would have more telegrams than Wireshark can show or count: it refuses
 * a tree of more than a million items, and a tap's queue holds 5,000. So these bytes begin the last of them.
 */
#define MOST_BYTES 32768

static void
dissect_rest(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent)
{
    unsigned there = tvb_reported_length(tvb);
    proto_item *root = proto_tree_add_item(parent, proto_sis, tvb, 0, -1, ENC_NA);
    proto_tree *tree = proto_item_add_subtree(root, ett_sis);

    separate(pinfo);
    col_append_fstr(pinfo->cinfo, COL_INFO, "Not decoded, %u byte%s", there, plurality(there, "", "s"));
    proto_item_append_text(root, ", not decoded");
    expert_add_info(pinfo, root, &ei_too_many);
    proto_tree_add_item(tree, hf_sis_raw, tvb, 0, tvb_captured_length(tvb), ENC_NA);
    tvb_ensure_bytes_exist(tvb, 0, (int)there);
}

static int
dissect_sis(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    unsigned offset = 0;

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SIS");
    col_clear(pinfo->cinfo, COL_INFO);
    while (offset < MOST_BYTES && tvb_reported_length_remaining(tvb, offset) > 0) {
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

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_start, {"Start character", "sis.start", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_checksum, {"Checksum", "sis.checksum", FT_UINT8, BASE_HEX, NULL, 0, "Makes the sum of all bytes 0 modulo 256", HFILL}},
    {&hf_checksum_status, {"Checksum Status", "sis.checksum.status", FT_UINT8, BASE_NONE, VALS(checksum_states), 0, NULL, HFILL}},
    {&hf_length, {"Data length", "sis.length", FT_UINT8, BASE_DEC, NULL, 0, "Bytes after the static header of 8", HFILL}},
    {&hf_length_repeat, {"Data length repetition", "sis.length_repeat", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_control, {"Telegram control", "sis.control", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_control_subaddresses, {"Subaddresses", "sis.control.subaddresses", FT_UINT8, BASE_DEC, NULL, SIS_CONTROL_SUBADDRESSES, NULL, HFILL}},
    {&hf_control_number, {"Telegram number", "sis.control.number", FT_BOOLEAN, 8, TFS(&present_absent), SIS_CONTROL_NUMBER, NULL, HFILL}},
    {&hf_control_reaction, {"Kind", "sis.control.reaction", FT_BOOLEAN, 8, TFS(&command_reaction), SIS_CONTROL_REACTION, NULL, HFILL}},
    {&hf_control_reserved, {"Reserved", "sis.control.reserved", FT_BOOLEAN, 8, NULL, CONTROL_RESERVED, NULL, HFILL}},
    {&hf_control_warning, {"System warning of the sender", "sis.control.warning", FT_BOOLEAN, 8, NULL, CONTROL_WARNING, NULL, HFILL}},
    {&hf_control_error, {"System error of the sender", "sis.control.error", FT_BOOLEAN, 8, NULL, CONTROL_ERROR, NULL, HFILL}},
    {&hf_control_reserved_bits, {"Reserved", "sis.control.reserved_bits", FT_UINT8, BASE_HEX, NULL, CONTROL_STATUS, NULL, HFILL}},
    {&hf_control_status, {"Status", "sis.control.status", FT_UINT8, BASE_DEC, VALS(sis_control_status_ecodrive03), CONTROL_STATUS, NULL, HFILL}},
    {&hf_sender, {"Sender address", "sis.sender", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_receiver, {"Receiver address", "sis.receiver", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_subaddress, {"Subaddress", "sis.subaddress", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_number, {"Telegram number", "sis.number", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_talker, {"Talker", "sis.talker", FT_UINT8, BASE_DEC, NULL, 0, "Who really sends: a reaction keeps the command's addresses", HFILL}},
    {&hf_listener, {"Listener", "sis.listener", FT_UINT8, BASE_DEC, NULL, 0, "For whom it really is", HFILL}},
    {&hf_station, {"Station", "sis.station", FT_UINT8, BASE_DEC, NULL, 0, "Talker or listener", HFILL}},
};

static ei_register_info experts[] = {
    {&ei_start, {"sis.start.missing", PI_MALFORMED, PI_ERROR, "No start character 0x02", EXPFILL}},
    {&ei_checksum, {"sis.checksum.bad", PI_CHECKSUM, PI_ERROR, "Wrong checksum", EXPFILL}},
    {&ei_lengths_differ, {"sis.length.differ", PI_MALFORMED, PI_ERROR, "The two lengths differ: a bus does not answer this telegram, a point-to-point station answers with status 0xF2", EXPFILL}},
    {&ei_too_short, {"sis.length.short", PI_MALFORMED, PI_ERROR, "The telegram is cut", EXPFILL}},
    {&ei_too_long, {"sis.length.long", PI_PROTOCOL, PI_WARN, "Bytes follow the end of the telegram", EXPFILL}},
    {&ei_too_many, {"sis.telegrams.many", PI_UNDECODED, PI_NOTE, "More telegrams in a packet than are decoded: only those that begin in its first 32,768 bytes", EXPFILL}},
    {&ei_header_too_long, {"sis.length.header", PI_MALFORMED, PI_ERROR, "Subaddresses and telegram number do not fit into the length", EXPFILL}},
    {&ei_control_reserved, {"sis.control.reserved.set", PI_PROTOCOL, PI_NOTE, "Reserved bits of the telegram control are set (another edition? preference sis.edition)", EXPFILL}},
    {&ei_control_status, {"sis.control.status.set", PI_RESPONSE_CODE, PI_NOTE, "The status in the telegram control is not 'no error'", EXPFILL}},
    {&ei_control_error, {"sis.control.status.error", PI_RESPONSE_CODE, PI_WARN, "The status in the telegram control is an error", EXPFILL}},
    {&ei_system_warning, {"sis.control.warning.set", PI_RESPONSE_CODE, PI_NOTE, "The sender signals a system warning", EXPFILL}},
    {&ei_system_error, {"sis.control.error.set", PI_RESPONSE_CODE, PI_WARN, "The sender signals a system error", EXPFILL}},
    {&ei_service_reserved, {"sis.service.reserved", PI_PROTOCOL, PI_NOTE, "Reserved service", EXPFILL}},
    {&ei_sender_service, {"sis.sender.service_master", PI_PROTOCOL, PI_NOTE, "Address 127, for service and emergencies only: not to be used while other masters communicate", EXPFILL}},
    {&ei_sender_invalid, {"sis.sender.invalid", PI_PROTOCOL, PI_WARN, "A sender address is not above 127", EXPFILL}},
    {&ei_receiver_reserved, {"sis.receiver.reserved", PI_PROTOCOL, PI_WARN, "Receiver address that is not assigned or reserved (another edition? preference sis.edition)", EXPFILL}},
    {&ei_level_broadcast, {"sis.receiver.level_broadcast", PI_PROTOCOL, PI_WARN, "254 may only be the last address of the list", EXPFILL}},
    {&ei_reaction_unexpected, {"sis.reaction.unexpected", PI_PROTOCOL, PI_WARN, "A group or broadcast is not answered", EXPFILL}},
};

static const enum_val_t edition_choices[] = {
    {"IF02", "IF02 (SIS definition of 2004, IndraDrive)", SIS_EDITION_IF02},
    {"ECODRIVE03", "ECODRIVE03 (FGP-01VRS)", SIS_EDITION_ECODRIVE03},
    {NULL, NULL, 0},
};
/* clang-format on */

void
sis_packet_register(module_t *module)
{
    static int *trees[] = {&ett_sis, &ett_control};

    proto_register_field_array(proto_sis, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    expert_register_field_array(sis_experts, experts, array_length(experts));
    prefs_register_enum_preference(
        module, "edition", "Edition of the telegram header",
        "Address ranges, and bits 5 to 7 of the telegram control, differ between editions", &sis_edition,
        edition_choices, FALSE);
    sis_handle = register_dissector("sis", dissect_sis, proto_sis);
}

void
sis_packet_handoff(void)
{
    dissector_add_uint("sertap.framing", 0, sis_handle);
}
