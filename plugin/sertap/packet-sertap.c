/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The serial tap's link layer: one record a packet, with value, interval and flags of every character.
 *
 * The record is described field by field in docs/record.md. Nothing in this file knows what travels on the
 * line: the characters of a frame go to the dissector that table "sertap.framing" names.
 */
#include "parts.h"

#include <epan/decode_as.h>
#include <epan/expert.h>
#include <epan/proto_data.h>
#include <epan/tap.h>

#include "sertap/line.h"

#define RECORD_VERSION     1
#define RECORD_HEADER_SIZE 20
#define FRAMING_SIS        0

static dissector_table_t framing_table;
static int tap_sertap = -1;

/* The name of a flag at its character, and, for an error, the text about its record. */
typedef struct {
    uint8_t flag;
    int *hf;
    const char *text;
    expert_field *ei;
    const char *mark; /* with the number of its first character */
} flag_t;

static const flag_t flags[] = {
    {SERTAP_SAME_READ, &hf_sertap_same_read, "same read", NULL, NULL},
    {SERTAP_ERROR_CHARACTER, &hf_sertap_error_character, "parity or framing error",
     &ei_sertap_error_character_expert, "parity or framing error at character %u"},
    {SERTAP_ERROR_BREAK, &hf_sertap_error_break, "break", &ei_sertap_error_break_expert,
     "break at character %u"},
    {SERTAP_ERROR_LOST, &hf_sertap_error_lost, "characters lost before it", &ei_sertap_error_lost_expert,
     "the tap lost characters before character %u"},
    {SERTAP_ERROR_UNLOCATED, &hf_sertap_error_unlocated, "error somewhere in this read",
     &ei_sertap_error_unlocated_expert, "line error, place unknown"},
    {SERTAP_INTERVAL_UNKNOWN, &hf_sertap_interval_unknown, "interval unknown", NULL, NULL},
    {SERTAP_INTERVAL_SATURATED, &hf_sertap_interval_saturated, "interval longer than it can be stored", NULL,
     NULL},
};

/* "8E1" and its parts. */
static void
add_format(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, const sertap_record_t *record)
{
    const char *text =
        proto_field_is_referenced(tree, hf_sertap_format) ? sertap_format_text(pinfo->pool, record) : "";
    proto_item *ti = proto_tree_add_string(tree, hf_sertap_format, tvb, 8, 3, text);
    proto_tree *subtree = proto_item_add_subtree(ti, ett_sertap_format);

    proto_tree_add_item(subtree, hf_sertap_format_data_bits, tvb, 8, 1, ENC_BIG_ENDIAN);
    proto_tree_add_item(subtree, hf_sertap_format_parity, tvb, 9, 1, ENC_BIG_ENDIAN);
    proto_tree_add_item(subtree, hf_sertap_format_stop, tvb, 10, 1, ENC_BIG_ENDIAN);
}

/* Unknown has no value: otherwise a filter for bad times would find it. */
static void
add_uncertainty(proto_tree *tree, packet_info *pinfo, tvbuff_t *tvb, uint32_t uncertainty)
{
    nstime_t shown = sertap_time(uncertainty);

    if (uncertainty == SERTAP_UNCERTAINTY_UNKNOWN)
        proto_tree_add_subtree(tree, tvb, 12, 4, ett_sertap_characters, NULL,
                               "Uncertainty of the times: unknown");
    else
        proto_tree_add_time_format_value(tree, hf_sertap_uncertainty, tvb, 12, 4, &shown, "%s",
                                         sertap_ms_text(pinfo->pool, uncertainty));
}

static void
show_header(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const sertap_record_t *record)
{
    proto_item *ti;

    proto_tree_add_item(tree, hf_sertap_type, tvb, 2, 1, ENC_BIG_ENDIAN);
    proto_tree_add_item(tree, hf_sertap_line, tvb, 3, 1, ENC_BIG_ENDIAN);
    ti = proto_tree_add_item(tree, hf_sertap_baud, tvb, 4, 4, ENC_BIG_ENDIAN);
    if (record->baud == 0)
        proto_item_append_text(ti, " (unknown)");
    add_format(tree, pinfo, tvb, record);
    proto_tree_add_item(tree, hf_sertap_framing, tvb, 11, 1, ENC_BIG_ENDIAN);
    add_uncertainty(tree, pinfo, tvb, record->uncertainty);
}

/* Reads the header of a record, offsets 0 to 19. False if nothing after it can be decoded. */
static bool
dissect_header(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, sertap_record_t *record)
{
    unsigned there = tvb_reported_length(tvb);
    uint8_t version, size;
    proto_item *ti;

    if (there == 0) {
        expert_add_info(pinfo, proto_tree_get_parent(tree), &ei_sertap_truncated);
        return false;
    }
    version = compat_get_uint8(tvb, 0);
    ti = proto_tree_add_item(tree, hf_sertap_version, tvb, 0, 1, ENC_BIG_ENDIAN);

    if (version != RECORD_VERSION) {
        expert_add_info(pinfo, ti, &ei_sertap_version_unknown);
        return false;
    }
    if (there < RECORD_HEADER_SIZE) {
        expert_add_info(pinfo, ti, &ei_sertap_truncated);
        return false;
    }
    size = compat_get_uint8(tvb, 1);
    ti = proto_tree_add_item(tree, hf_sertap_header_length, tvb, 1, 1, ENC_BIG_ENDIAN);
    if (size < RECORD_HEADER_SIZE) {
        expert_add_info(pinfo, ti, &ei_sertap_header_length_short);
        return false;
    }
    if (there < size) {
        expert_add_info(pinfo, ti, &ei_sertap_truncated);
        return false;
    }
    tvb_ensure_bytes_exist(tvb, 0, size); /* throws where the capture has cut the header */

    record->type = compat_get_uint8(tvb, 2);
    record->line = compat_get_uint8(tvb, 3);
    record->baud = tvb_get_ntohl(tvb, 4);
    record->data_bits = compat_get_uint8(tvb, 8);
    record->parity = compat_get_uint8(tvb, 9);
    record->stop_half_bits = compat_get_uint8(tvb, 10);
    record->framing = compat_get_uint8(tvb, 11);
    record->uncertainty = tvb_get_ntohl(tvb, 12);
    record->declared = tvb_get_ntohs(tvb, 16);
    record->event = tvb_get_ntohs(tvb, 18);
    record->data_offset = size;
    if (proto_field_is_referenced(tree, proto_sertap))
        show_header(tvb, pinfo, tree, record);
    return true;
}

/* Compares the count with the bytes of the record; whatever is complete is still decoded. */
static void
check_count(tvbuff_t *tvb, packet_info *pinfo, proto_item *ti, sertap_record_t *record)
{
    unsigned bytes = tvb_reported_length(tvb) - record->data_offset;
    unsigned captured = tvb_captured_length_remaining(tvb, record->data_offset);
    unsigned per_character = record->type == SERTAP_EVENT ? 1 : 6;
    unsigned expected = record->declared * per_character;

    /* The three arrays follow one another: missing bytes at the end are first missing from the flags. */
    record->count = MIN(bytes, record->declared);
    record->values = MIN(captured, record->declared);
    if (record->type != SERTAP_EVENT && captured > record->declared * 5)
        record->timed = MIN(captured - record->declared * 5, record->declared);
    if (bytes < expected) {
        expert_add_info(pinfo, ti, &ei_sertap_truncated);
    } else if (bytes > expected) {
        expert_add_info(pinfo, ti, &ei_sertap_count_wrong);
    }
    record->times_offset = record->data_offset + record->declared;
    record->flags_offset = record->times_offset + record->declared * 4;
}

static const char *
interval_text(packet_info *pinfo, int64_t interval, bool is_known)
{
    const char *text = sertap_ms_text(pinfo->pool, interval);

    return is_known ? text : wmem_strconcat(pinfo->pool, "more than ", text, NULL);
}

/* "Character 12: 0x3c": a record has hundreds, and printf() would take a third of the time. */
static const char *
character_text(wmem_allocator_t *scope, unsigned number, uint8_t value, const char *interval)
{
    static const char hexadecimal[] = "0123456789abcdef";
    char text[] = "Character 00000: 0x00", *digit = text + strlen("Character 0000");

    text[19] = hexadecimal[value >> 4];
    text[20] = hexadecimal[value & 15];
    for (; number > 0; number /= 10)
        *digit-- = (char)('0' + number % 10);
    memmove(text + strlen("Character "), digit + 1, strlen(digit + 1) + 1);
    return interval != NULL ? wmem_strconcat(scope, text, ", after ", interval, NULL)
                            : wmem_strdup(scope, text);
}

static void
add_flags(proto_tree *tree, proto_item *character, tvbuff_t *tvb, unsigned offset, uint8_t flag)
{
    proto_tree_add_uint(tree, hf_sertap_flags, tvb, offset, 1, flag);
    for (unsigned i = 0; flag != 0 && i < array_length(flags); i++) {
        if (!(flag & flags[i].flag))
            continue;
        proto_item_append_text(character, ", %s", flags[i].text);
        proto_tree_add_boolean(tree, *flags[i].hf, tvb, offset, 1, flags[i].flag);
    }
}

/* A character says nothing if it has no flag and came about as long after the one before it as it takes
 * itself, `usual`: then it is there for filters, and hidden. Returns whether it is. */
static bool
add_character(proto_tree *tree, packet_info *pinfo, const sertap_record_t *record, unsigned at, int64_t usual)
{
    unsigned data_at = record->data_offset + at, time_at = record->times_offset + 4 * at;
    uint8_t value = compat_get_uint8(record->tvb, data_at), flag = sertap_flags(record, at);
    int64_t interval = sertap_interval(record, at);
    bool is_usual = at > 0 && flag == 0 && 2 * ABS(interval - usual) < usual;
    bool is_known = at == 0 ? record->is_silence_known : !(flag & SERTAP_INTERVAL_SATURATED);
    nstime_t since = sertap_time(interval);
    proto_item *ti = proto_tree_add_uint(tree, hf_sertap_character, record->tvb, data_at, 1, value);
    proto_tree *subtree = proto_item_add_subtree(ti, ett_sertap_character);

    if (is_usual) {
        proto_item_set_hidden(ti);
        proto_tree_add_time(subtree, hf_sertap_interval, record->tvb, time_at, 4, &since);
    } else {
        const char *text = flag & SERTAP_INTERVAL_UNKNOWN ? NULL : interval_text(pinfo, interval, is_known);

        proto_item_set_text(ti, "%s", character_text(pinfo->pool, at + 1, value, text));
        if (text != NULL)
            proto_tree_add_time_format_value(subtree, hf_sertap_interval, record->tvb, time_at, 4, &since,
                                             "%s", text);
    }
    add_flags(subtree, ti, record->tvb, record->flags_offset + at, flag);
    return is_usual;
}

static void
add_interval_max(proto_tree *tree, packet_info *pinfo, const sertap_record_t *record)
{
    unsigned at = record->interval_max_at;
    nstime_t longest = sertap_time(record->interval_max);
    uint8_t flag;
    proto_item *ti;

    if (!proto_field_is_referenced(tree, hf_sertap_interval_max))
        return;
    flag = sertap_flags(record, at);
    ti = proto_tree_add_time_format_value(
        tree, hf_sertap_interval_max, record->tvb, record->times_offset + 4 * at, 4, &longest,
        "%s, before character %u",
        interval_text(pinfo, record->interval_max, !(flag & SERTAP_INTERVAL_SATURATED)), at + 1);
    proto_item_set_generated(ti);
    if (record->uncertainty != SERTAP_UNCERTAINTY_UNKNOWN)
        proto_item_append_text(ti, " (times uncertain by %s)",
                               sertap_ms_text(pinfo->pool, record->uncertainty));
}

/* Whether the characters are displayed or filtered. Usually a large file needs neither, and a record has
 * five items for each character. Flags that no character has are no reason. */
static bool
are_characters_wanted(proto_tree *tree, const sertap_record_t *record)
{
    static int *const fields[] = {&hf_sertap_character, &hf_sertap_interval, &hf_sertap_flags};

    for (unsigned i = 0; i < array_length(fields); i++) {
        if (proto_field_is_referenced(tree, *fields[i]))
            return true;
    }
    for (unsigned i = 0; i < array_length(flags); i++) {
        if (record->flags & flags[i].flag && proto_field_is_referenced(tree, *flags[i].hf))
            return true;
    }
    return false;
}

static void
add_characters(proto_tree *tree, packet_info *pinfo, const sertap_record_t *record)
{
    unsigned length = record->flags_offset + record->timed - record->data_offset, usual = 0;
    int64_t character = sertap_character_ns(record);
    proto_tree *subtree;
    proto_item *ti;

    subtree = proto_tree_add_subtree_format(tree, record->tvb, record->data_offset, length,
                                            ett_sertap_characters, &ti, "%u character%s", record->timed,
                                            plurality(record->timed, "", "s"));
    for (unsigned i = 0; i < record->timed; i++)
        usual += add_character(subtree, pinfo, record, i, character);
    if (usual > 0)
        proto_item_append_text(ti, ", %u of %u intervals of about one character (%s)", usual,
                               record->timed - 1, sertap_ms_text(pinfo->pool, character));
}

/* One item and one mark for each kind of error, however many characters have it. */
static void
report_errors(packet_info *pinfo, proto_item *ti, const sertap_record_t *record)
{
    for (unsigned i = 0; i < array_length(flags); i++) {
        unsigned character = record->first_at[g_bit_nth_lsf(flags[i].flag, -1)] + 1;

        if (flags[i].ei == NULL || !(record->flags & flags[i].flag))
            continue;
        expert_add_info(pinfo, ti, flags[i].ei);
        col_append_fstr(pinfo->cinfo, COL_INFO, "  [%s]",
                        wmem_strdup_printf(pinfo->pool, flags[i].mark, character));
    }
}

static void
dissect_event(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const sertap_record_t *record)
{
    const char *name = val_to_str_const(record->event, sis_sertap_events, "Event of a later version");
    const char *text = tvb_format_text(pinfo->pool, tvb, record->data_offset, record->values);
    proto_item *ti = proto_tree_add_item(tree, hf_sertap_event, tvb, 18, 2, ENC_BIG_ENDIAN);

    proto_tree_add_item(tree, hf_sertap_text, tvb, record->data_offset, record->values, ENC_UTF_8);
    if (sertap_is_loss(record))
        expert_add_info_format(pinfo, ti, &ei_sertap_event_expert, "%s", name);
    col_add_fstr(pinfo->cinfo, COL_INFO, "%s: %s", name, text);
}

/* Whether these characters are readable text. */
static bool
is_text(tvbuff_t *tvb, unsigned offset, unsigned length)
{
    unsigned readable = 0;

    for (unsigned i = 0; i < length; i++) {
        uint8_t c = compat_get_uint8(tvb, offset + i);

        readable += g_ascii_isprint(c) || g_ascii_isspace(c);
    }
    return readable * 4 >= length * 3;
}

/* As hex and as text: a drive sends ASCII until SIS is selected. */
static void
dissect_other(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const sertap_record_t *record)
{
    unsigned offset = record->data_offset, values = record->values, shown = MIN(values, 24);
    const char *more = shown < record->count ? " ..." : "";

    col_add_fstr(pinfo->cinfo, COL_INFO, "%u other character%s", record->count,
                 plurality(record->count, "", "s"));
    if (values == 0)
        return;
    proto_tree_add_item(tree, hf_sertap_data, tvb, offset, values, ENC_NA);
    proto_tree_add_item(tree, hf_sertap_text, tvb, offset, values, ENC_ASCII);
    col_append_fstr(pinfo->cinfo, COL_INFO, "  %s%s",
                    tvb_bytes_to_str_punct(pinfo->pool, tvb, offset, shown, ' '), more);
    if (is_text(tvb, offset, shown))
        col_append_fstr(pinfo->cinfo, COL_INFO, "  \"%s\"%s",
                        tvb_format_text(pinfo->pool, tvb, offset, shown), more);
}

/* If somebody looks at the bytes, they have a data source of their own, without the record around them. */
static tvbuff_t *
frame_characters(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, const sertap_record_t *record)
{
    tvbuff_t *part = tvb_new_subset_length_caplen(tvb, record->data_offset, (int)record->values,
                                                  (int)record->count),
             *own;

    if (tree == NULL || record->values == 0 || !proto_field_is_referenced(tree, hf_sertap_data))
        return part;
    own = tvb_new_child_real_data(tvb, tvb_memdup(pinfo->pool, part, 0, record->values), record->values,
                                  (int)record->count);
    add_new_data_source(pinfo, own, "Characters");
    return own;
}

/* From before a file, only telegrams of SIS explain something. */
static bool
is_framed(const sertap_record_t *record)
{
    return record->values > 0 && (record->type == SERTAP_FRAME || record->framing == FRAMING_SIS);
}

static void
dissect_frame(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, const sertap_record_t *record)
{
    tvbuff_t *payload = frame_characters(tvb, pinfo, parent, record);

    if (is_framed(record) && compat_try_uint(framing_table, record->framing, payload, pinfo, parent, NULL))
        return;
    col_add_fstr(pinfo->cinfo, COL_INFO, "%u character%s", record->count, plurality(record->count, "", "s"));
    if (record->values > 0)
        call_data_dissector(payload, pinfo, parent);
}

/* What travels on the line is only learned from. */
static void
dissect_before(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, proto_item *root,
               const sertap_record_t *record)
{
    expert_add_info(pinfo, root, &ei_sertap_before);
    dissect_frame(tvb, pinfo, parent, record);
    col_prepend_fstr(pinfo->cinfo, COL_INFO, "Before this file: ");
}

static int
dissect_sertap(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    sertap_record_t *record = wmem_new0(pinfo->pool, sertap_record_t);
    proto_item *root = proto_tree_add_item(parent, proto_sertap, tvb, 0, -1, ENC_NA), *ti;
    proto_tree *tree = proto_item_add_subtree(root, ett_sertap);

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SERTAP");
    col_clear(pinfo->cinfo, COL_INFO);
    record->tvb = tvb;
    if (!dissect_header(tvb, pinfo, tree, record)) {
        col_set_str(pinfo->cinfo, COL_INFO, "Record that cannot be read");
        return tvb_captured_length(tvb);
    }

    p_add_proto_data(pinfo->pool, pinfo, proto_sertap, 0, record); /* for sertap_record() */
    ti = proto_tree_add_item(tree, hf_sertap_count, tvb, 16, 2, ENC_BIG_ENDIAN);
    check_count(tvb, pinfo, ti, record);
    proto_item_append_text(root, ", %s",
                           val_to_str_const(record->type, sis_sertap_types, "type of a later version"));
    if (record->type != SERTAP_EVENT)
        sertap_record_survey(record);
    if (!pinfo->fd->visited)
        sertap_line_note(pinfo, record);
    sertap_line_find_silence(pinfo, record);
    if (record->type != SERTAP_BEFORE) /* before a dissector finds that the capture has cut it */
        tap_queue_packet(tap_sertap, pinfo, record);
    if (record->type == SERTAP_EVENT) {
        dissect_event(tvb, pinfo, tree, record);
    } else {
        if (tree && record->interval_max_at > 0)
            add_interval_max(tree, pinfo, record);
        if (tree && record->timed > 0 && are_characters_wanted(tree, record))
            add_characters(tree, pinfo, record);
        if (record->type == SERTAP_FRAME)
            dissect_frame(tvb, pinfo, parent, record);
        else if (record->type == SERTAP_BEFORE)
            dissect_before(tvb, pinfo, parent, root, record);
        else
            dissect_other(tvb, pinfo, tree, record);
        report_errors(pinfo, root, record); /* after the info column has its text */
    }
    /* Throws where the capture has cut the packet, and Wireshark says so. */
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb));
    return tvb_captured_length(tvb);
}

static void *
framing_value(packet_info *pinfo)
{
    const sertap_record_t *record = sertap_record(pinfo);

    return GUINT_TO_POINTER(record != NULL ? record->framing : 0);
}

static void
framing_prompt(packet_info *pinfo, char *result)
{
    snprintf(result, MAX_DECODE_AS_PROMPT_LEN, "Framing %u as", GPOINTER_TO_UINT(framing_value(pinfo)));
}

static void
register_decode_as_framing(void)
{
    static build_valid_func values[] = {framing_value};
    static decode_as_value_t value = {framing_prompt, 1, values};
    static decode_as_t decode_as = {
        .name = "sertap",
        .table_name = "sertap.framing",
        .num_items = 1,
        .values = &value,
        .populate_list = decode_as_default_populate_list,
        .reset_value = decode_as_default_reset,
        .change_value = decode_as_default_change,
    };

    register_decode_as(&decode_as);
}

/* Other protocols of such lines, cut by silence. */
void
sertap_handoff(void)
{
    dissector_handle_t modbus = find_dissector("mbrtu");

    if (modbus != NULL)
        dissector_add_for_decode_as("sertap.framing", modbus);
}

void
sertap_register(void)
{
    framing_table =
        register_dissector_table("sertap.framing", "Serial framing", proto_sertap, FT_UINT8, BASE_DEC);
    register_decode_as_framing();
    register_dissector("sertap", dissect_sertap, proto_sertap);
    tap_sertap = register_tap("sertap");
}
