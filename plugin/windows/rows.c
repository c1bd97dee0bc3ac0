/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A row for each packet (`tshark -q -z sis,rows`), for programs: docs/rows.md describes it byte for byte. It
 * comes from records and from what the dissectors tell (told.c): there is no tree. Only fields that are named
 * (`-z sis,rows,FIELD,FIELD...`) need one, with them alone. A field that nobody knows, or that is named
 * again, is left out. */
#include "parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

#include <epan/epan_dissect.h>
#include <epan/print.h>
#include <epan/stat_tap_ui.h>
#include <epan/tap.h>

#include "sis/access.h"
#include "sis/told.h"

#define NAME       "sis,rows"
#define VERSION    "1"
#define JOINT      '\x1f'    /* between several values of a field */
#define MOST_KINDS 2048      /* then their numbers begin anew: nobody has to remember more ... */
#define MOST_TEXT  (1 << 22) /* ... or if their texts are so long together */

/* What begins each entry. */
typedef struct {
    uint32_t length; /* of the entry */
    uint16_t is_row; /* else a kind: what packets have alike, as text */
    uint16_t kind;   /* its number, or that of the row */
} head_t;

/* A packet. So many telegrams follow, intervals, characters, and a text. Unknown times are NaN. */
typedef struct {
    head_t head;
    int64_t seconds; /* since 1970 */
    double relative; /* all others in s */
    double uncertainty;
    uint32_t nanoseconds;
    uint32_t number;
    uint16_t telegrams;
    uint16_t intervals;
    uint16_t characters;
    uint16_t reserved;
} row_t;

typedef struct {
    double silence;
    double reaction;
    double pause;
    double cycle;
    double load; /* % */
    uint32_t command_in;
    uint32_t position; /* of the pause */
} telegram_t;

_Static_assert(sizeof(row_t) == 48 && sizeof(telegram_t) == 48, "as docs/rows.md describes them");

typedef struct {
    int field;
    wmem_strbuf_t *values; /* of the present packet; NULL: none */
} column_t;

typedef struct {
    GHashTable *kinds; /* number by text */
    size_t text;       /* bytes of these */
    GArray *columns;   /* of fields of a tree */
    GString *row;      /* as it is written, at once: each call of stdio takes a lock */
    epan_dissect_t *packet;
} rows_t;

static void
free_rows(void *data)
{
    rows_t *rows = data;

    g_hash_table_destroy(rows->kinds);
    g_array_free(rows->columns, TRUE);
    g_string_free(rows->row, TRUE);
    g_free(rows);
}

static rows_t *
new_rows(void)
{
    rows_t *rows = g_new0(rows_t, 1);

    rows->kinds = g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    rows->columns = g_array_new(FALSE, TRUE, sizeof(column_t));
    rows->row = g_string_new(NULL);
    return rows;
}

static double
in_seconds(int64_t ns)
{
    return (double)ns / 1e9;
}

/* As often as characters have a flag. */
static void
say_flag(wmem_strbuf_t *kind, const char *name, const sertap_record_t *record, uint8_t flag)
{
    if (!(record->flags & flag))
        return;
    for (unsigned i = 0; i < record->timed; i++) {
        if (sertap_flags(record, i) & flag)
            sis_say_number(kind, name, 1);
    }
}

static void
say_record(wmem_strbuf_t *kind, packet_info *pinfo, const sertap_record_t *record)
{
    bool is_event = record->type == SERTAP_EVENT;

    sis_say_number(kind, "sertap.type", record->type);
    sis_say_number(kind, "sertap.line", record->line);
    sis_say_number(kind, "sertap.baud", record->baud);
    sis_say_text(kind, "sertap.format", sertap_format_text(pinfo->pool, record));
    sis_say_number(kind, "sertap.framing", record->framing);
    if (is_event)
        sis_say_number(kind, "sertap.event", record->event);
    if (sertap_is_loss(record))
        sis_say_number(kind, "sertap.event.expert", 1);
    if (is_event || (record->type != SERTAP_FRAME && record->type != SERTAP_BEFORE))
        sis_say_text(kind, "sertap.text",
                     (char *)tvb_get_string_enc(pinfo->pool, record->tvb, (int)record->data_offset,
                                                (int)record->values, is_event ? ENC_UTF_8 : ENC_ASCII));
    say_flag(kind, "sertap.same_read", record, SERTAP_SAME_READ);
    say_flag(kind, "sertap.interval.unknown", record, SERTAP_INTERVAL_UNKNOWN);
    say_flag(kind, "sertap.error.character", record, SERTAP_ERROR_CHARACTER);
    say_flag(kind, "sertap.error.break", record, SERTAP_ERROR_BREAK);
    say_flag(kind, "sertap.error.lost", record, SERTAP_ERROR_LOST);
    say_flag(kind, "sertap.error.unlocated", record, SERTAP_ERROR_UNLOCATED);
}

static void
say_limit(wmem_strbuf_t *kind, packet_info *pinfo, const char *limit, const char *verdict, int64_t ns,
          sis_verdict_t said)
{
    if (ns == 0)
        return;
    sis_say_text(kind, limit, sertap_decimal_text(pinfo->pool, ns, 1, 9, ""));
    sis_say_number(kind, verdict, said);
}

static void
say_telegram(wmem_strbuf_t *kind, packet_info *pinfo, const sis_telegram_t *telegram)
{
    const sis_timing_t *timing = &telegram->timing;

    if (telegram->is_good)
        sis_say_number(kind, "sis.checksum.status", 1);
    sis_say_number(kind, "sis.control.reaction", telegram->is_reaction);
    if (pref_sis_edition == SIS_EDITION_IF02)
        sis_say_number(kind, "sis.control.error", (telegram->control & SIS_CONTROL_ERROR) != 0);
    else if (telegram->is_reaction)
        sis_say_number(kind, "sis.control.status", telegram->control >> 5);
    sis_say_number(kind, "sis.service", telegram->service);
    sis_say_number(kind, "sis.talker", telegram->talker);
    sis_say_number(kind, "sis.listener", telegram->listener);
    say_limit(kind, pinfo, "sis.trs.limit", "sis.trs.verdict", timing->trs, timing->trs_verdict);
    if (timing->longest.interval.at > 0)
        say_limit(kind, pinfo, "sis.tza.limit", "sis.tza.verdict", timing->tza, timing->longest.verdict);
    say_limit(kind, pinfo, "sis.tmas.limit", "sis.tmas.verdict", timing->tmas, timing->tmas_verdict);
}

/* A line for the packet and what belongs to no telegram, and one for each telegram. */
static const char *
kind_of(packet_info *pinfo, const sertap_record_t *record)
{
    wmem_strbuf_t *kind = wmem_strbuf_new(pinfo->pool, "");
    const char *interface = compat_interface_name(pinfo);
    const sis_part_t *part;

    if (interface != NULL)
        sis_say_text(kind, "frame.interface_name", interface);
    if (record != NULL)
        say_record(kind, pinfo, record);
    for (part = sis_parts(pinfo); part != NULL; part = part->next) {
        if (!part->is_telegram)
            wmem_strbuf_append(kind, wmem_strbuf_get_str(part->said));
    }
    for (part = sis_parts(pinfo); part != NULL; part = part->next) {
        if (!part->is_telegram)
            continue;
        wmem_strbuf_append(kind, "\nsis.start=1\t");
        if (part->telegram != NULL)
            say_telegram(kind, pinfo, part->telegram);
        wmem_strbuf_append(kind, wmem_strbuf_get_str(part->said));
    }
    return wmem_strbuf_get_str(kind);
}

static void
append(GString *row, const void *bytes, size_t length)
{
    g_string_append_len(row, bytes, (gssize)length);
}

/* The number of a kind; it is written if it is new. */
static uint16_t
kind_number(rows_t *rows, const char *kind)
{
    void *known;
    head_t head = {.length = (uint32_t)(sizeof head + strlen(kind))};

    if (g_hash_table_lookup_extended(rows->kinds, kind, NULL, &known))
        return (uint16_t)GPOINTER_TO_UINT(known);
    if (g_hash_table_size(rows->kinds) == MOST_KINDS || rows->text > MOST_TEXT) {
        g_hash_table_remove_all(rows->kinds);
        rows->text = 0;
    }
    rows->text += head.length;
    head.kind = (uint16_t)g_hash_table_size(rows->kinds);
    g_hash_table_insert(rows->kinds, g_strdup(kind), GUINT_TO_POINTER(head.kind));
    append(rows->row, &head, sizeof head);
    append(rows->row, kind, head.length - sizeof head);
    return head.kind;
}

/* The longest pause inside a telegram; of one that cannot be told, the longest interval of its record. */
static double
pause_of(const sis_longest_t *longest, const sertap_record_t *alone)
{
    const sis_interval_t *interval = &longest->interval;

    if (interval->at > 0 && (interval->is_exact || interval->is_saturated))
        return in_seconds(interval->recorded);
    if (interval->at > 0 && interval->span.most != SIS_ANY_TIME)
        return in_seconds(interval->span.most);
    return alone != NULL && alone->interval_max_at > 0 ? in_seconds(alone->interval_max) : NAN;
}

static uint32_t
command_of(const sis_telegram_t *telegram)
{
    const sis_record_t *record = telegram->record;

    if (record == NULL || !telegram->is_good || !telegram->is_reaction)
        return 0;
    return record->exchange != NULL ? record->exchange->command_in : sis_rare(record, 0)->damaged_in;
}

/* `alone`: the record, if it has no other telegram. */
static telegram_t
telegram_of(const sis_telegram_t *telegram, packet_info *pinfo, const sertap_record_t *alone)
{
    static const sis_timing_t none;
    const sis_timing_t *timing = telegram != NULL ? &telegram->timing : &none;
    sis_longest_t longest = timing->longest;
    const sis_record_t *record = telegram != NULL && !telegram->is_before ? telegram->record : NULL;
    const sis_cycle_t *cycle = record != NULL ? sis_rare(record, 0)->cycle : NULL;
    telegram_t told = {NAN, NAN, NAN, NAN, NAN, 0, 0};

    /* Without a limit nobody has looked for it yet. */
    if (longest.interval.at == 0 && record != NULL && telegram->times.record != NULL)
        longest = sis_longest(pinfo->pool, &telegram->times, timing->tza, (sis_from_t)pref_sis_tza_from);
    told.pause = pause_of(&longest, alone);
    told.position = longest.interval.at;
    if (timing->has_silence)
        told.silence = in_seconds(timing->silence);
    if (timing->has_reaction_time)
        told.reaction = in_seconds(record->exchange->reaction_time);
    if (cycle != NULL && sis_is_measured(cycle->ns, &telegram->times))
        told.cycle = in_seconds(cycle->ns);
    if (record != NULL && record->load >= 0)
        told.load = record->load;
    if (telegram != NULL)
        told.command_in = command_of(telegram);
    return told;
}

static uint16_t
append_telegrams(GString *row, packet_info *pinfo, const sertap_record_t *record)
{
    uint16_t count = 0;
    const sis_part_t *part;

    for (part = sis_parts(pinfo); part != NULL; part = part->next)
        count += part->is_telegram;
    for (part = sis_parts(pinfo); part != NULL; part = part->next) {
        telegram_t told = telegram_of(part->telegram, pinfo, count == 1 ? record : NULL);

        if (part->is_telegram)
            append(row, &told, sizeof told);
    }
    return count;
}

static uint16_t
append_intervals(GString *row, const sertap_record_t *record)
{
    uint16_t count = 0;

    for (unsigned i = 0; i < record->timed; i++) {
        double interval = in_seconds(sertap_interval(record, i));

        if (sertap_flags(record, i) & SERTAP_INTERVAL_UNKNOWN)
            continue;
        append(row, &interval, sizeof interval);
        count++;
    }
    return count;
}

/* Each telegram but the first begins a column. */
static void
append_accesses(GString *row, packet_info *pinfo)
{
    bool is_first = true;

    for (const sis_part_t *part = sis_parts(pinfo); part != NULL; part = part->next) {
        unsigned count = part->accesses != NULL ? wmem_array_get_count(part->accesses) : 0;

        if (part->is_telegram && !is_first)
            g_string_append_c(row, '\t');
        is_first &= !part->is_telegram;
        for (unsigned i = 0; i < count; i++) {
            const sis_access_t **access = wmem_array_index(part->accesses, i);

            g_string_append(row, sis_access_text(pinfo, *access));
            g_string_append_c(row, JOINT);
        }
    }
}

static void
take_values(proto_node *node, void *data)
{
    rows_t *rows = data;
    const field_info *field = PNODE_FINFO(node);

    for (unsigned i = 0; field != NULL && i < rows->columns->len; i++) {
        column_t *column = &g_array_index(rows->columns, column_t, i);
        char *value;

        if (column->field != field->hfinfo->id)
            continue;
        value = get_node_field_value(PNODE_FINFO(node), rows->packet);
        if (column->values == NULL)
            column->values = wmem_strbuf_new(rows->packet->pi.pool, "");
        else
            wmem_strbuf_append_c(column->values, JOINT);
        if (value != NULL) /* Wireshark has none for a text that stands for no bytes */
            sis_append_escaped(column->values, value);
        g_free(value);
    }
    proto_tree_children_foreach(node, take_values, rows);
}

static void
append_columns(rows_t *rows)
{
    if (rows->columns->len > 0)
        proto_tree_children_foreach(rows->packet->tree, take_values, rows);
    for (unsigned i = 0; i < rows->columns->len; i++) {
        column_t *column = &g_array_index(rows->columns, column_t, i);

        if (column->values != NULL)
            g_string_append(rows->row, wmem_strbuf_get_str(column->values));
        g_string_append_c(rows->row, '\t');
        column->values = NULL;
    }
}

static row_t
begin_row(packet_info *pinfo, const sertap_record_t *record)
{
    row_t row = {.number = pinfo->num, .uncertainty = NAN};

    if (pinfo->presence_flags & PINFO_HAS_TS) {
        row.seconds = pinfo->abs_ts.secs;
        row.nanoseconds = (uint32_t)pinfo->abs_ts.nsecs;
        row.relative = ((double)pinfo->rel_ts.secs * 1e9 + pinfo->rel_ts.nsecs) / 1e9;
    }
    if (record != NULL && record->uncertainty != SERTAP_UNCERTAINTY_UNKNOWN)
        row.uncertainty = in_seconds(record->uncertainty);
    return row;
}

static tap_packet_status
packet(void *data, packet_info *pinfo, epan_dissect_t *edt, const void *tapped _U_, tap_flags_t flags _U_)
{
    rows_t *rows = data;
    const sertap_record_t *record = sertap_record(pinfo);
    row_t row = begin_row(pinfo, record);
    size_t begin;

    rows->packet = edt;
    row.head.is_row = true;
    row.head.kind = kind_number(rows, kind_of(pinfo, record));
    begin = rows->row->len;
    append(rows->row, &row, sizeof row);
    row.telegrams = append_telegrams(rows->row, pinfo, record);
    if (record != NULL && record->timed > 0) {
        row.intervals = append_intervals(rows->row, record);
        row.characters = (uint16_t)record->timed;
        append(rows->row, tvb_get_ptr(record->tvb, (int)record->data_offset, (int)record->timed),
               record->timed);
    }
    append_columns(rows);
    append_accesses(rows->row, pinfo);
    row.head.length = (uint32_t)(rows->row->len - begin);
    memcpy(rows->row->str + begin, &row, sizeof row);
    fwrite(rows->row->str, 1, rows->row->len, stdout);
    g_string_truncate(rows->row, 0);
    return TAP_PACKET_DONT_REDRAW;
}

static void
finish(void *data _U_)
{
    if (fflush(stdout) != 0 || ferror(stdout))
        fprintf(stderr, NAME ": rows are missing in standard output: %s\n", g_strerror(errno));
}

/* The filter holds for every packet. It names the fields that the tree must have, so that they are made. */
static void
add_column(rows_t *rows, const char *name, GString *filter)
{
    const header_field_info *field = proto_registrar_get_byname(name);

    if (field == NULL)
        return;
    for (unsigned i = 0; i < rows->columns->len; i++) {
        if (g_array_index(rows->columns, column_t, i).field == field->id)
            return;
    }
    g_array_append_val(rows->columns, ((column_t){field->id, NULL}));
    if (filter->len == 0)
        g_string_printf(filter, "!%s", name);
    g_string_append_printf(filter, " || %s", name);
    printf("\t%s", name);
}

/* Through the other tap nothing comes: it says that this reads what is told. */
static void
listen(rows_t *rows, char *const *names)
{
    GString *filter = g_string_new(NULL);
    GString *error;

#ifdef _WIN32
    _setmode(_fileno(stdout), _O_BINARY); /* else a byte 0A would come as 0D 0A */
#endif
    printf(NAME " " VERSION);
    for (; *names != NULL; names++)
        add_column(rows, *names, filter);
    printf("\n");
    error = register_tap_listener("sis.told", rows->row, NULL, TL_REQUIRES_NOTHING, NULL, NULL, NULL, NULL);
    if (error == NULL)
        error = register_tap_listener("frame", rows, filter->len > 0 ? filter->str : NULL,
                                      filter->len > 0 ? TL_REQUIRES_PROTO_TREE : TL_REQUIRES_NOTHING, NULL,
                                      packet, finish, free_rows);
    g_string_free(filter, TRUE);
    if (error == NULL)
        return;
    fprintf(stderr, "%s: %s\n", NAME, error->str);
    g_string_free(error, TRUE);
    free_rows(rows);
}

static compat_stat_begun
begin(const char *asked, void *data _U_)
{
    char **names = g_strsplit(asked + strlen(NAME), ",", 0);

    listen(new_rows(), names);
    g_strfreev(names);
    COMPAT_STAT_BEGUN(true);
}

static stat_tap_ui ui = {
    .group = REGISTER_PACKET_STAT_GROUP_UNSORTED,
    .title = "SIS rows",
    .cli_string = NAME,
    .tap_init_cb = begin,
};

void
windows_rows_register(void)
{
    register_stat_tap_ui(&ui, NULL);
}
