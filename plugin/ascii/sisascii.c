/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The ASCII protocol of ECODRIVE and IndraDrive, a line or a prompt a packet, as MPH-02 (p. 10-86 to 10-91)
 * and public clients for DKCxx.3 drives have it. BCD:21 opens the connection to drive 21, whose prompt is
 * E21:>. S-0-0051,7,R reads, and S-0-0044,7,W,VALUE writes an element; after ">" each element of a list
 * follows a "?", and "<" ends it. "#" and four digits are an error. */

#include "ascii/dialogue.h"

#include <epan/tap.h>

#include "parameters/ident.h"
#include "parameters/values.h"
#include "items.h"
#include "parts.h"
#include "protocol/limits.h"
#include "sis/access.h"
#include "sis/segments.h"
#include "sis/told.h"

#define MOST_DIGITS      3
#define LARGEST_ADDRESS  255u
#define ERROR_DIGITS     4
#define SHOWN_CHARACTERS 80u
#define MS               INT64_C(1000000)

static int sisascii_tap = -1;
static dissector_handle_t tcp_handle;

/* A line being decoded. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *tree;
    proto_item *root;
    sisascii_said_t said;
    const sisascii_unit_t *unit;
    sis_times_t times;
    unsigned length;      /* in bytes, without its end */
    wmem_strbuf_t *words; /* behind the kind */
    wmem_strbuf_t *marks; /* and what is wrong, for the packet list */
} line_t;

/* A drive between two words: BCD:21, E21:>. */
static bool
take_drive(sisascii_said_t *said, sisascii_kind_t kind, const char *before, const char *behind)
{
    unsigned at = (unsigned)strlen(before), digits;
    unsigned long address;

    if (!g_str_has_prefix(said->text, before))
        return false;
    digits = (unsigned)strspn(said->text + at, "0123456789");
    address = strtoul(said->text + at, NULL, 10);
    if (digits == 0 || digits > MOST_DIGITS || address > LARGEST_ADDRESS ||
        strcmp(said->text + at + digits, behind) != 0)
        return false;
    said->kind = kind;
    said->at = at;
    said->drive = (uint8_t)address;
    return true;
}

/* S-0-0051,7,R or S-0-0044,7,W,VALUE; r and w may be small. */
static bool
take_access(sisascii_said_t *said)
{
    const char *at = sis_ident_parse(said->text, &said->ident);
    bool is_write;

    if (at == NULL || at[0] != ',' || at[1] < '1' || at[1] > '7' || at[2] != ',')
        return false;
    is_write = g_ascii_toupper(at[3]) == 'W' && at[4] == ',';
    if (!is_write && (g_ascii_toupper(at[3]) != 'R' || at[4] != '\0'))
        return false;
    said->kind = is_write ? SISASCII_WRITE : SISASCII_READ;
    said->at = (unsigned)(at + 1 - said->text);
    said->element = (sis_element_t)(at[1] - '0');
    said->value_at = said->at + 4;
    return true;
}

/* #7008 */
static void
take_error(sisascii_said_t *said)
{
    if (said->text[0] != '#' || strspn(said->text + 1, "0123456789abcdefABCDEF") != ERROR_DIGITS ||
        said->text[1 + ERROR_DIGITS] != '\0')
        return;
    said->kind = SISASCII_ERROR;
    said->at = 1;
    said->error = (uint16_t)strtoul(said->text + 1, NULL, 16);
}

static void
read_line(sisascii_said_t *said)
{
    if (strcmp(said->text, "?") == 0)
        said->kind = SISASCII_ASKS;
    else if (!take_drive(said, SISASCII_OPEN, "BCD:", "") && !take_drive(said, SISASCII_PROMPT, "E", ":>") &&
             !take_access(said))
        take_error(said);
}

/* "-12.5", but not "0013": that is a code. */
static bool
is_number(const char *text)
{
    size_t digits, decimals;

    text += *text == '-';
    digits = strspn(text, "0123456789");
    if (digits == 0 || (digits > 1 && text[0] == '0'))
        return false;
    text += digits;
    if (*text != '.')
        return *text == '\0';
    decimals = strspn(++text, "0123456789");
    return decimals > 0 && text[decimals] == '\0';
}

/* The command with the parameter: of an element, the write that began its list; NULL: it has none. */
static const sisascii_command_t *
access_of(const sisascii_command_t *command)
{
    if (command != NULL && command->list != NULL)
        command = command->list;
    return command != NULL && command->said.kind != SISASCII_OPEN ? command : NULL;
}

/* When the command was sent. */
static sis_known_t
known_of(const sisascii_command_t *access)
{
    sis_place_t place = sisascii_place(access);

    return sis_learned_or_from_tables(access->known, access->twin, access->has_drive ? &place : NULL,
                                      access->said.ident);
}

static const char *
with_unit(wmem_allocator_t *pool, const char *value, const sis_known_t *known)
{
    bool has_unit = known->unit != NULL && known->unit[0] != '\0';

    return has_unit ? wmem_strdup_printf(pool, "%s %s", value, known->unit) : value;
}

/* A value of bits is hexadecimal (0x0010, 10h) or binary (11b), or its attribute says which. False: it is
 * neither, or has more than 64 bits. */
static bool
read_bits(const char *text, const sis_known_t *known, uint64_t *raw)
{
    sis_format_t format =
        known->attribute_from == SIS_FROM_NOWHERE ? SIS_FORMAT_TEXT : known->attribute >> 20 & 7;
    bool has_prefix = g_str_has_prefix(text, "0x");
    bool is_hexadecimal = has_prefix || g_str_has_suffix(text, "h") || format == SIS_FORMAT_HEXADECIMAL;
    bool is_binary = g_str_has_suffix(text, "b") || format == SIS_FORMAT_BINARY;
    size_t digits;

    if (has_prefix)
        text += 2;
    digits = strspn(text, is_hexadecimal ? "0123456789abcdefABCDEF" : "01");
    if (!(is_hexadecimal || is_binary) || digits == 0 || digits > (is_hexadecimal ? 16 : 64) ||
        (text[digits] != '\0' && strcmp(text + digits, is_hexadecimal ? "h" : "b") != 0))
        return false;
    *raw = g_ascii_strtoull(text, NULL, is_hexadecimal ? 16 : 2);
    return true;
}

/* Operating data and limits have the unit of the parameter. */
static void
show_value(line_t *line, unsigned offset, const sisascii_command_t *access, const sis_known_t *known)
{
    const char *value = line->said.text + offset;
    unsigned length = line->length - offset;
    bool is_value = access->said.element >= SIS_ELEMENT_MINIMUM && is_number(value);
    const char *shown = is_value ? with_unit(line->pinfo->pool, value, known) : value;
    proto_item *item;
    uint64_t raw;

    item = proto_tree_add_string(line->tree, hf_sis_value, line->tvb, offset, length, shown);
    wmem_strbuf_append_printf(line->words, " = %s", shown);
    if (access->said.element >= SIS_ELEMENT_MINIMUM && read_bits(value, known, &raw))
        sis_add_named_bits(item, line->tvb, offset, length, raw, known->bits);
    if (is_value)
        proto_item_set_generated(
            proto_tree_add_double_format_value(line->tree, hf_sis_value_number, line->tvb, offset, length,
                                               g_ascii_strtod(value, NULL), "%s", value));
}

/* The parameter of a command, or of the command that a line belongs to. */
static void
show_parameter(line_t *line, const sisascii_command_t *access, const sis_known_t *known, bool is_here)
{
    sis_ident_place_t place = {0, 0, SIS_NO_TYPE_BYTE, 0, ENC_NA}; /* its text is no ident of bytes */
    sis_element_t element = access->said.element;
    proto_item *item;

    sis_add_ident(line->tree, line->pinfo->pool, line->tvb, &place, access->said.ident, known);
    item = proto_tree_add_uint(line->tree, hf_sisascii_element, line->tvb, is_here ? line->said.at : 0,
                               is_here, element);
    if (!is_here)
        proto_item_set_generated(item);
    if (line->unit->kind == SISASCII_ECHO)
        return;
    wmem_strbuf_append_printf(line->words, " %s", sis_ident_text(line->pinfo->pool, access->said.ident));
    if (known->name != NULL)
        wmem_strbuf_append_printf(line->words, " (%s)", known->name);
    if (element != SIS_ELEMENT_DATA)
        wmem_strbuf_append_printf(
            line->words, ", %s",
            wmem_ascii_strdown(line->pinfo->pool, val_to_str_const(element, sis_elements, ""), -1));
}

/* Codes of its own, else those of parameter services. */
static const char *
error_text(uint32_t code)
{
    const char *text = try_val_to_str(code, sis_errors_ascii);

    return text != NULL ? text : val_to_str_const(code, sis_errors_parameter, "Not defined");
}

static void
show_error(line_t *line)
{
    const char *text = error_text(line->said.error);
    proto_item *item =
        proto_tree_add_uint_format_value(line->tree, hf_sis_error, line->tvb, line->said.at, ERROR_DIGITS,
                                         line->said.error, "%s (0x%04x)", text, line->said.error);

    expert_add_info_format(line->pinfo, item, &ei_sis_status_execution_error, "error 0x%04x: %s",
                           line->said.error, text);
    wmem_strbuf_append_printf(line->words, ": 0x%04x %s", line->said.error, text);
}

/* Which drive a line is for; at that place if it says so itself. */
static void
show_drive(line_t *line)
{
    const sisascii_said_t *said = &line->said;
    sisascii_kind_t kind = line->unit->kind;
    bool is_here = kind == SISASCII_OPEN || kind == SISASCII_PROMPT;
    unsigned length = is_here ? (unsigned)strspn(said->text + said->at, "0123456789") : 0;
    uint8_t drive = is_here ? said->drive : line->unit->drive;
    proto_item *item;

    if (!is_here && !line->unit->has_drive)
        return;
    item =
        proto_tree_add_uint(line->tree, hf_sisascii_drive, line->tvb, is_here ? said->at : 0, length, drive);
    if (is_here)
        wmem_strbuf_append_printf(line->words, " %u", drive);
    else
        proto_item_set_generated(item);
    proto_item_set_hidden(add_generated(line->tree, hf_sis_station, line->tvb, drive));
}

static void
show_line(line_t *line)
{
    const sisascii_unit_t *unit = line->unit;
    const sisascii_command_t *access = access_of(unit->command);
    sis_known_t known;

    if (access != NULL && unit->kind != SISASCII_PROMPT) {
        known = known_of(access);
        show_parameter(line, access, &known, line->said.kind == access->said.kind);
    }
    if (unit->number > 0)
        add_generated(line->tree, hf_sisascii_index, line->tvb, unit->number);
    switch (unit->kind) {
    case SISASCII_WRITE:
        if (strcmp(line->said.text + line->said.value_at, ">") == 0)
            wmem_strbuf_append(line->words, ", a list");
        else
            show_value(line, line->said.value_at, access, &known);
        break;
    case SISASCII_ANSWER:
    case SISASCII_ELEMENT:
        show_value(line, 0, access, &known);
        break;
    case SISASCII_ERROR:
        show_error(line);
        break;
    case SISASCII_TEXT:
    case SISASCII_ECHO:
        proto_tree_add_string(line->tree, hf_sisascii_text, line->tvb, 0, line->length, line->said.text);
        wmem_strbuf_append_printf(line->words, " \"%s\"", line->said.text);
        break;
    default:
        break;
    }
}

static void
show_verdict(line_t *line, unsigned limit_ms, const char *source)
{
    sis_verdict_t verdict = sis_judge(line->unit->asked.span, limit_ms * MS);
    proto_item *item;

    sertap_add_time(line->tree, hf_sis_trs_limit, line->tvb, limit_ms * MS,
                    wmem_strdup_printf(line->pinfo->pool, "%u ms%s", limit_ms, source));
    if (source[0] != '\0')
        add_link(line->tree, hf_sis_trs_set_in, line->tvb, line->unit->limit.set_in);
    item = add_generated(line->tree, hf_sis_trs_verdict, line->tvb, verdict);
    sis_tell(line->pinfo, hf_sis_trs_verdict, verdict);
    if (verdict == SIS_TIME_EXCEEDED) {
        expert_add_info(line->pinfo, item, &ei_sis_trs_exceeded);
        wmem_strbuf_append(line->marks, "  [TrS exceeded]");
    } else if (verdict == SIS_TIME_UNRESOLVED) {
        expert_add_info(line->pinfo, item, &ei_sis_trs_unresolved);
    }
}

static bool
is_measured(const line_t *line)
{
    return line->unit->asked.request_in != 0 && sis_is_measured(line->unit->asked.elapsed, &line->times);
}

/* How long the drive took. No document has a limit, so it is the user's. */
static void
show_time(line_t *line)
{
    int64_t elapsed = line->unit->asked.elapsed;
    unsigned preference = pref_sis_trs_ms;

    if (line->unit->asked.request_in == 0)
        return;
    if (is_measured(line)) {
        sertap_add_ms(line->tree, hf_sis_reaction_time, line->tvb, line->pinfo->pool, elapsed);
        sertap_add_column_ms(line->tree, hf_sis_reaction_time_ms, line->tvb, elapsed);
    }
    if (line->times.record == NULL)
        return;
    if (preference > 0)
        show_verdict(line, preference, "");
    else if (line->unit->limit.value > 0)
        show_verdict(line, line->unit->limit.value, ", told by the user");
}

static void
show_command(line_t *line, const sisascii_command_t *command)
{
    add_link(line->tree, hf_sis_reaction_in, line->tvb, command->asked->answer_in);
    add_link(line->tree, hf_sis_repeat_of, line->tvb, command->repeat_of);
    add_link(line->tree, hf_sis_unanswered_before, line->tvb, command->unanswered_before);
    add_link(line->tree, hf_sis_next_command_in, line->tvb, command->next_in);
    if (command->repeat_of != 0) {
        expert_add_info(line->pinfo, line->root, &ei_sis_command_repeat);
        sis_tell(line->pinfo, hf_sis_repeat_of, command->repeat_of);
        wmem_strbuf_append(line->marks, "  [repeat]");
    }
    if (command->next_in != 0) {
        expert_add_info(line->pinfo, line->root, &ei_sis_command_unanswered);
        sis_tell_expert(line->pinfo, &ei_sis_command_unanswered);
        wmem_strbuf_append(line->marks, "  [no reaction]");
    }
}

static void
show_links(line_t *line)
{
    const sisascii_command_t *command = line->unit->command;

    if (command == NULL)
        return;
    if (line->unit->is_command) {
        show_command(line, command);
        return;
    }
    add_link(line->tree, hf_sis_command_in, line->tvb, command->asked->frame);
    show_time(line);
}

/* The line that ends an answer completes a read or write of operating data. */
static void
tell_access(const line_t *line)
{
    const sisascii_command_t *command = access_of(line->unit->command);
    wmem_allocator_t *pool = line->pinfo->pool;
    sis_access_t *access;

    if (line->unit->kind != SISASCII_PROMPT || command == NULL || !command->has_drive ||
        command->said.element != SIS_ELEMENT_DATA || !sis_access_is_wanted(line->tree))
        return;
    access = wmem_new0(pool, sis_access_t);
    access->is_write = command->said.kind == SISASCII_WRITE;
    access->place = sisascii_place(command);
    access->ident = command->said.ident;
    access->known = known_of(command);
    sis_learned_complete(line->pinfo, sis_learned_of(sis_exchange_bus(line->pinfo)), &access->place,
                         command->said.ident, &access->known);
    if (command->has_error) {
        access->error = wmem_strdup_printf(pool, "0x%04x %s", command->error, error_text(command->error));
    } else if (command->count > 0) {
        const char *value = wmem_strbuf_get_str(command->value);

        access->text = value;
        access->is_number = command->count == 1 && is_number(value);
        if (access->is_number)
            value = with_unit(pool, value, &access->known);
        access->value = sis_text_shortened(pool, value, SHOWN_CHARACTERS);
    }
    sis_access_tell(access, line->tvb, line->pinfo, line->tree);
}

/* Latin-1, as drives write "°C". */
static bool
is_text(uint8_t character)
{
    return (character >= ' ' && character <= '~') || character == '\t' || character >= 0xA0;
}

static bool
is_end(uint8_t character)
{
    return character == '\r' || character == '\n';
}

/* A prompt has no end of line; 0: none begins here. */
static unsigned
prompt_length(const uint8_t *text, unsigned there)
{
    unsigned at = 1;

    if (text[0] == '?')
        return 1;
    while (at < there && at <= MOST_DIGITS && g_ascii_isdigit(text[at]))
        at++;
    return text[0] == 'E' && at > 1 && at + 1 < there && text[at] == ':' && text[at + 1] == '>' ? at + 2 : 0;
}

/* For sis_segments_dissect(). Who ends lines with CR alone waits for the answer, so LF is not waited for. A
 * line that the capture has cut has the rest of the segment. */
static unsigned
line_length(packet_info *pinfo, tvbuff_t *tvb, int offset, void *data _U_)
{
    unsigned there = MIN(tvb_captured_length_remaining(tvb, offset), SISASCII_MOST_LINE);
    const uint8_t *text = tvb_get_ptr(tvb, offset, there);
    unsigned length = prompt_length(text, there);

    if (length > 0)
        return length;
    while (length < there && is_text(text[length]))
        length++;
    if (length == SISASCII_MOST_LINE)
        return length;
    if (length == there)
        return pinfo->can_desegment ? 0 : tvb_reported_length_remaining(tvb, offset);
    if (is_end(text[length]))
        return length + 1 + (text[length] == '\r' && length + 1 < there && text[length + 1] == '\n');
    while (length < there && !is_text(text[length]) && !is_end(text[length]))
        length++;
    return length;
}

static unsigned
length_without_end(tvbuff_t *tvb)
{
    unsigned length = tvb_captured_length(tvb);

    while (length > 0 && is_end(compat_get_uint8(tvb, length - 1)))
        length--;
    return length;
}

/* Cut by the capture, or noise of the line: it may have said something else. */
static bool
is_whole(tvbuff_t *tvb)
{
    unsigned length = tvb_captured_length(tvb);
    uint8_t last = length > 0 ? compat_get_uint8(tvb, length - 1) : '\n';

    return length == tvb_reported_length(tvb) && (is_text(last) || is_end(last));
}

static int
dissect_sisascii(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    static const sisascii_unit_t unknown = {.kind = SISASCII_TEXT};
    proto_item *root = proto_tree_add_item(parent, proto_sisascii, tvb, 0, -1, ENC_NA);
    line_t line = {.tvb = tvb,
                   .pinfo = pinfo,
                   .tree = proto_item_add_subtree(root, ett_sisascii),
                   .root = root,
                   .unit = &unknown};
    const char *kind;

    line.length = length_without_end(tvb);
    line.said.text = sis_text(pinfo->pool, tvb, 0, line.length);
    line.words = wmem_strbuf_new(pinfo->pool, "");
    line.marks = wmem_strbuf_new(pinfo->pool, "");
    line.times = sis_times(tvb, pinfo, tvb_reported_length(tvb), NULL);
    if (is_whole(tvb)) {
        read_line(&line.said);
        line.unit = sisascii_find(pinfo, &line.said, &line.times);
    }
    add_generated(line.tree, hf_sisascii_kind, tvb, line.unit->kind);
    sis_tell(pinfo, hf_sisascii_kind, line.unit->kind);
    show_drive(&line);
    show_line(&line);
    show_links(&line);
    tell_access(&line);
    if (is_measured(&line))
        tap_queue_packet(sisascii_tap, pinfo, line.unit);
    kind = val_to_str_const(line.unit->kind, sis_ascii_kinds, "");
    proto_item_append_text(root, ", %s%s", kind, wmem_strbuf_get_str(line.words));
    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SISASCII");
    col_clear(pinfo->cinfo, COL_INFO);
    sis_separate(pinfo);
    col_append_fstr(pinfo->cinfo, COL_INFO, "%s%s%s", kind, wmem_strbuf_get_str(line.words),
                    wmem_strbuf_get_str(line.marks));
    return tvb_captured_length(tvb);
}

/* LF alone may belong to the line before, whose CR ended it; an empty line says nothing. */
static int
dissect_tcp_line(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data)
{
    if (length_without_end(tvb) > 0) {
        dissect_sisascii(tvb, pinfo, tree, data);
        col_set_fence(pinfo->cinfo, COL_INFO);
        tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb)); /* Wireshark says that it is cut */
    }
    return tvb_captured_length(tvb);
}

static int
dissect_tcp(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data)
{
    return sis_segments_dissect(tvb, pinfo, tree, line_length, dissect_tcp_line, data);
}

/* A segment that begins with a whole command: no other protocol has such lines. */
static compat_bool
dissect_heuristic(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    bool is_asked = pref_sis_tcp_heuristic && tvb_captured_length(tvb) > 0;
    unsigned length = is_asked ? line_length(pinfo, tvb, 0, NULL) : 0;
    sisascii_said_t said = {0};

    if (length == 0 || length > tvb_captured_length(tvb) || !is_end(compat_get_uint8(tvb, length - 1)))
        return FALSE;
    said.text = sis_text(pinfo->pool, tvb, 0, length_without_end(tvb_new_subset_length(tvb, 0, length)));
    read_line(&said);
    return (said.kind == SISASCII_OPEN || said.kind == SISASCII_READ || said.kind == SISASCII_WRITE) &&
           sis_recognize(tvb, pinfo, tree, tcp_handle, dissect_tcp);
}

void
sisascii_register(void)
{
    sisascii_tap = register_tap("sisascii");
    register_dissector("sisascii", dissect_sisascii, proto_sisascii);
}

void
sisascii_handoff(void)
{
    dissector_add_uint("sertap.framing", 2, find_dissector("sisascii"));
    tcp_handle = create_dissector_handle(dissect_tcp, proto_sisascii);
    dissector_add_for_decode_as("tcp.port", tcp_handle);
    heur_dissector_add("tcp", dissect_heuristic, "SIS ASCII over TCP", "sisascii_tcp", proto_sisascii,
                       HEURISTIC_ENABLE);
}
