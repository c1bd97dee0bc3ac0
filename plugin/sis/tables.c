/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Tables of the timing: intervals by talker (`tshark -z sis,tza`), and the bus by station (`tshark -z
 * sis,bus`). The first row is the sum of all. */

#include "sis/tables.h"

#include <math.h>

#include <epan/stat_tap_ui.h>
#include <epan/tap.h>

#include "sertap/line.h"
#include "sis/exchange.h"
#include "sis/quantiles.h"

#define NS_PER_MS 1e6
#define NS_PER_US INT64_C(1000)

#define ALL -1 /* instead of a station */

/* Chapter 10.1: an operator terminal's cycle, and the silence after which its link is lost. */
#define CYCLE_NS   INT64_C(100000000)
#define SILENCE_NS INT64_C(200000000)

/* Histogram of the intervals: the upper bounds of the columns in ms. */
static const double bins_ms[] = {1, 2, 5, 10, 20, 50, 1e9};

enum {
    TZA_TALKER,
    TZA_TELEGRAMS,
    TZA_CHARACTERS,
    TZA_P50,
    TZA_P99,
    TZA_LONGEST,
    TZA_EXCEEDED,
    TZA_UNRESOLVED,
    TZA_ONE_READ,
    TZA_BINS,
    TZA_COLUMNS = TZA_BINS + array_length(bins_ms)
};

enum {
    BUS_STATION,
    BUS_TELEGRAMS,
    BUS_REPEATS, /* what went wrong stands first */
    BUS_UNANSWERED,
    BUS_TZA,
    BUS_TRS,
    BUS_DAMAGED,
    BUS_LINE,
    BUS_CHARACTERS,
    BUS_LOAD,
    BUS_SILENCE,
    BUS_SILENCES,
    BUS_CYCLES,
    BUS_COLUMNS
};

/* clang-format off: a value is as wide as its column's name, so that tshark writes columns */
static stat_tap_table_item tza_columns[TZA_COLUMNS] = {
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Talker ", "%-7s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Telegrams", "%9u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Characters", "%10u"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "p50 in ms", "%9s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "p99 in ms", "%9s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Longest in ms", "%13s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "TzA exceeded", "%12u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Unresolved", "%10u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "In one read", "%11u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Under 1 ms", "%10u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "1 to 2 ms", "%9u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "2 to 5 ms", "%9u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "5 to 10 ms", "%10u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "10 to 20 ms", "%11u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "20 to 50 ms", "%11u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "50 ms and more", "%14u"},
};

static stat_tap_table_item bus_columns[BUS_COLUMNS] = {
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Station ", "%-8s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Telegrams", "%9u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Repeats", "%7u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Unanswered", "%10u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "TzA exceeded", "%12u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "TrS exceeded", "%12u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Damaged", "%7u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Line errors", "%11u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Characters", "%10u"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Load in %", "%9s"},
    {TABLE_ITEM_STRING, TAP_ALIGN_RIGHT, "Longest silence in ms", "%21s"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Silences > 200 ms", "%17u"},
    {TABLE_ITEM_UINT, TAP_ALIGN_RIGHT, "Cycles > 100 ms", "%15u"},
};
/* clang-format on */

/* Sums of a row beside its columns. */
typedef struct {
    int station;
    sis_quantiles_t intervals;
    uint64_t busy;      /* ns */
    int64_t begin, end; /* in the first row: of all characters, ns since 1970; 0: none yet */
    GHashTable *lines;  /* in the first row: the set of lines seen */
} row_t;

static stat_tap_table *
table_of(void *data)
{
    return g_array_index(((stat_data_t *)data)->stat_tap_data->tables, stat_tap_table *, 0);
}

static row_t *
row_at(const stat_tap_table *table, unsigned number)
{
    return stat_tap_get_field_data(table, number, 0)->user_data.ptr_value;
}

static unsigned
add_row(stat_tap_table *table, int station, const stat_tap_table_item *columns)
{
    stat_tap_table_item_type items[MAX((int)TZA_COLUMNS, (int)BUS_COLUMNS)] = {0};
    unsigned number = table->num_elements;
    row_t *row = g_new0(row_t, 1);

    for (unsigned i = 0; i < table->num_fields; i++) {
        items[i].type = columns[i].type;
        if (i > 0 && columns[i].type == TABLE_ITEM_STRING)
            items[i].value.string_value = g_strdup("");
    }
    row->station = station;
    row->lines = g_hash_table_new(NULL, NULL);
    sis_quantiles_init(&row->intervals);
    items[0].user_data.ptr_value = row;
    items[0].value.string_value = station == ALL ? g_strdup("All") : g_strdup_printf("%3d", station);
    stat_tap_init_table_row(table, number, table->num_fields, items);
    return number;
}

static unsigned
find_row(stat_tap_table *table, int station, const stat_tap_table_item *columns)
{
    for (unsigned i = 0; i < table->num_elements; i++) {
        if (row_at(table, i)->station == station)
            return i;
    }
    return add_row(table, station, columns);
}

static void
count(const stat_tap_table *table, unsigned row, unsigned column, unsigned by)
{
    stat_tap_get_field_data(table, row, column)->value.uint_value += by;
}

/* Decimals are text, because the windows of 4.0 and 4.4 always show six of them, with a comma in some
 * locales. `digits` is in units of the last one. The text is made again only if it changes; user_data is
 * its number. */
static void
set_decimal(const stat_tap_table *table, unsigned row, unsigned column, unsigned decimals, int64_t digits)
{
    stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);
    char *text;

    if (item->value.string_value[0] != '\0' && item->user_data.float_value == digits)
        return;
    text = sertap_decimal_text(NULL, digits, 1, decimals);
    g_free((char *)item->value.string_value);
    item->value.string_value = g_strdup_printf("%9s", text);
    item->user_data.float_value = (double)digits;
    wmem_free(NULL, text);
}

static void
set_ms(const stat_tap_table *table, unsigned row, unsigned column, int64_t ns)
{
    set_decimal(table, row, column, 3, (ns + NS_PER_US / 2) / NS_PER_US);
}

/* Empty where no interval has an exact time. */
static void
set_quantile(const stat_tap_table *table, unsigned row, unsigned column, const sis_quantiles_t *quantiles,
             const sis_quantile_t *quantile)
{
    if (quantiles->count > 0)
        set_ms(table, row, column, sis_quantile_ns(quantiles, quantile));
}

static bool
raise_to(const stat_tap_table *table, unsigned row, unsigned column, int64_t ns)
{
    const stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);

    if ((double)ns <= item->user_data.float_value * NS_PER_US)
        return false;
    set_ms(table, row, column, ns);
    return true;
}

/* "<=12.000": an upper bound; the true time is unknown. */
static void
mark_as_bound(const stat_tap_table *table, unsigned row, unsigned column)
{
    stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);
    char *text = (char *)item->value.string_value;

    item->value.string_value = g_strdup_printf("<=%s", g_strchug(text));
    g_free(text);
}

static void
raise_longest(const stat_tap_table *table, unsigned row, const sis_interval_t *longest)
{
    if (longest->at == 0 || (!longest->is_exact && longest->span.most == SIS_ANY_TIME))
        return;
    if (raise_to(table, row, TZA_LONGEST, longest->is_exact ? longest->recorded : longest->span.most) &&
        !longest->is_exact)
        mark_as_bound(table, row, TZA_LONGEST);
}

static void
init_table(stat_tap_table_ui *ui, const char *title)
{
    stat_tap_table *table = stat_tap_find_table(ui, title);

    if (table != NULL) {
        if (ui->stat_tap_reset_table_cb != NULL)
            ui->stat_tap_reset_table_cb(table);
        return;
    }
    table = stat_tap_init_table(title, (int)ui->nfields, 0, NULL);
    stat_tap_add_table(ui, table);
    add_row(table, ALL, ui->fields);
}

static void
reset_item(stat_tap_table_item_type *item)
{
    if (item->type == TABLE_ITEM_STRING) {
        g_free((char *)item->value.string_value);
        item->value.string_value = g_strdup("");
        item->user_data.float_value = 0;
    } else {
        memset(&item->value, 0, sizeof item->value);
    }
}

/* Resets everything; the rows stay. */
static void
reset_table(stat_tap_table *table)
{
    for (unsigned i = 0; i < table->num_elements; i++) {
        row_t *row = row_at(table, i);

        sis_quantiles_init(&row->intervals);
        row->busy = row->begin = row->end = 0;
        g_hash_table_remove_all(row->lines);
        for (unsigned column = 1; column < table->num_fields; column++)
            reset_item(stat_tap_get_field_data(table, i, column));
    }
}

static void
free_row(row_t *row)
{
    g_hash_table_destroy(row->lines);
    g_free(row);
}

static void
free_item(stat_tap_table *table _U_, unsigned row _U_, unsigned column, stat_tap_table_item_type *item)
{
    if (item->type == TABLE_ITEM_STRING)
        g_free((char *)item->value.string_value);
    if (column == 0)
        free_row(item->user_data.ptr_value);
}

static bool
is_same_read(const sis_times_t *times, unsigned character)
{
    return character < times->count &&
           compat_get_uint8(times->record->tvb, times->record->flags_offset + times->first + character) &
               SERTAP_SAME_READ;
}

/* The interval before a character: into the histogram if both characters were read alone. */
static void
count_interval(const stat_tap_table *table, unsigned row, const sis_times_t *times, unsigned character)
{
    const sertap_record_t *record = times->record;
    unsigned at = times->first + character, bin = 0;
    uint32_t ns = tvb_get_ntohl(record->tvb, record->times_offset + 4 * at);

    if (compat_get_uint8(record->tvb, record->flags_offset + at) &
        (SERTAP_INTERVAL_UNKNOWN | SERTAP_LOST_BEFORE))
        return;
    if (is_same_read(times, character - 1) || is_same_read(times, character) ||
        is_same_read(times, character + 1)) {
        count(table, row, TZA_ONE_READ, 1);
        return;
    }
    while (ns >= bins_ms[bin] * NS_PER_MS)
        bin++;
    count(table, row, TZA_BINS + bin, 1);
    sis_quantiles_add(&row_at(table, row)->intervals, ns);
}

static void
count_intervals(const stat_tap_table *table, unsigned row, const sis_telegram_t *telegram)
{
    const sis_interval_t *longest = &telegram->timing.longest.interval;
    const sis_quantiles_t *intervals = &row_at(table, row)->intervals;

    count(table, row, TZA_TELEGRAMS, 1);
    count(table, row, TZA_CHARACTERS, telegram->length);
    for (unsigned i = 1; i < telegram->times.count; i++)
        count_interval(table, row, &telegram->times, i);
    set_quantile(table, row, TZA_P50, intervals, &intervals->p50);
    set_quantile(table, row, TZA_P99, intervals, &intervals->p99);
    raise_longest(table, row, longest);
    if (telegram->timing.tza > 0 && telegram->timing.longest.verdict == SIS_TIME_EXCEEDED)
        count(table, row, TZA_EXCEEDED, 1);
    if (telegram->timing.tza > 0 && telegram->timing.longest.verdict == SIS_TIME_UNRESOLVED)
        count(table, row, TZA_UNRESOLVED, 1);
}

/* The sender of a damaged telegram is unknown. */
static tap_packet_status
tza_packet(void *data, packet_info *pinfo _U_, epan_dissect_t *edt _U_, const void *tapped,
           tap_flags_t flags _U_)
{
    const sis_telegram_t *telegram = tapped;
    stat_tap_table *table = table_of(data);

    if (!telegram->is_good || telegram->times.record == NULL)
        return TAP_PACKET_DONT_REDRAW;
    count_intervals(table, 0, telegram);
    count_intervals(table, find_row(table, telegram->talker, tza_columns), telegram);
    return TAP_PACKET_REDRAW;
}

/* Characters of a part of a record with an error. */
static unsigned
line_errors(const sertap_record_t *record, unsigned first, unsigned count_)
{
    const uint8_t errors =
        SERTAP_CHARACTER_ERROR | SERTAP_BREAK | SERTAP_LOST_BEFORE | SERTAP_UNLOCATED_ERROR;
    unsigned found = 0;

    for (unsigned i = first; record->flags & errors && i < first + count_; i++)
        found += (compat_get_uint8(record->tvb, record->flags_offset + i) & errors) != 0;
    return found;
}

static void
count_record(const stat_tap_table *table, packet_info *pinfo, const sertap_record_t *record)
{
    row_t *all = row_at(table, 0);
    int64_t begin = sertap_ns(&pinfo->abs_ts) - sertap_character_ns(record);

    count(table, 0, BUS_CHARACTERS, record->count);
    count(table, 0, BUS_LINE, line_errors(record, 0, record->timed));
    all->busy += (uint64_t)sertap_character_ns(record) * record->count;
    g_hash_table_add(all->lines, GUINT_TO_POINTER(sertap_line_number(pinfo)));
    if (all->begin == 0)
        all->begin = begin;
    all->end = sertap_ns(&pinfo->abs_ts) + (int64_t)record->duration;
}

static void
count_timing(const stat_tap_table *table, unsigned row, const sis_telegram_t *telegram)
{
    const sis_timing_t *timing = &telegram->timing;
    const sis_exchange_t *exchange = telegram->record->exchange;

    if (timing->has_silence) {
        raise_to(table, row, BUS_SILENCE, timing->silence);
        count(table, row, BUS_SILENCES, timing->silence > SILENCE_NS);
    }
    if (timing->has_reaction_time)
        count(table, row, BUS_CYCLES,
              sertap_elapsed(exchange->command_end, telegram->times.end) + exchange->command_duration >
                  CYCLE_NS);
    count(table, row, BUS_TZA, timing->tza > 0 && timing->longest.verdict == SIS_TIME_EXCEEDED);
    count(table, row, BUS_TRS, timing->trs > 0 && timing->trs_verdict == SIS_TIME_EXCEEDED);
}

static void
count_talker(stat_tap_table *table, const sis_telegram_t *telegram)
{
    unsigned row = find_row(table, telegram->talker, bus_columns);
    const sis_times_t *times = &telegram->times;

    count(table, row, BUS_TELEGRAMS, 1);
    count(table, row, BUS_CHARACTERS, telegram->length);
    count_timing(table, 0, telegram);
    count_timing(table, row, telegram);
    if (times->record == NULL)
        return;
    row_at(table, row)->busy += (uint64_t)sertap_character_ns(times->record) * times->count;
    count(table, row, BUS_LINE, line_errors(times->record, times->first, times->count));
}

/* The station that the master had to ask again, or in vain. */
static void
count_asked(stat_tap_table *table, const sis_exchange_t *exchange)
{
    if (exchange->first != NULL) {
        count(table, 0, BUS_REPEATS, 1);
        count(table, find_row(table, exchange->path[0], bus_columns), BUS_REPEATS, 1);
    }
    if (exchange->gave_up != 0) {
        count(table, 0, BUS_UNANSWERED, 1);
        count(table, find_row(table, exchange->gave_up_station, bus_columns), BUS_UNANSWERED, 1);
    }
}

static void
count_telegram(stat_tap_table *table, const sis_telegram_t *telegram)
{
    const sis_exchange_t *exchange = telegram->record->exchange;

    count(table, 0, BUS_TELEGRAMS, 1);
    if (telegram->times.record == NULL)
        count(table, 0, BUS_CHARACTERS, tvb_reported_length(telegram->tvb)); /* and what follows it */
    if (!telegram->is_good) {
        count(table, 0, BUS_DAMAGED, 1);
        return;
    }
    count_talker(table, telegram);
    if (exchange != NULL && !telegram->is_reaction)
        count_asked(table, exchange);
}

#define MOST_PERMILLE 1e9 /* that a damaged capture can claim */

static int64_t
permille(uint64_t busy, double span)
{
    return (int64_t)MIN(round(1000.0 * busy / span), MOST_PERMILLE);
}

/* For several lines, such as two directions, the mean. */
static void
set_loads(const stat_tap_table *table)
{
    const row_t *all = row_at(table, 0);
    int64_t span = sertap_elapsed(all->begin, all->end);
    unsigned lines = g_hash_table_size(all->lines);

    if (span <= 0)
        return;
    for (unsigned i = 0; i < table->num_elements; i++)
        set_decimal(table, i, BUS_LOAD, 1, permille(row_at(table, i)->busy, span * (i == 0 ? lines : 1.0)));
}

/* Called for every packet, because the line's other characters have errors, too. */
static tap_packet_status
bus_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped _U_,
           tap_flags_t flags _U_)
{
    stat_tap_table *table = table_of(data);
    const sertap_record_t *record = sertap_record(pinfo);
    const sis_telegram_t *telegram = sis_packet(pinfo)->last;

    if (record != NULL && record->type != SERTAP_EVENT)
        count_record(table, pinfo, record);
    for (; telegram != NULL; telegram = telegram->before)
        count_telegram(table, telegram);
    set_loads(table);
    return TAP_PACKET_REDRAW;
}

static void
init_tza(stat_tap_table_ui *ui)
{
    init_table(ui, "SIS intervals by talker");
}

static void
init_bus(stat_tap_table_ui *ui)
{
    init_table(ui, "SIS bus by station");
}

static tap_param parameters[] = {{PARAM_FILTER, "filter", "Filter", NULL, TRUE}};

static stat_tap_table_ui tza_table = {
    .group = REGISTER_PACKET_STAT_GROUP_UNSORTED,
    .title = "SIS intervals by talker (TzA)",
    .tap_name = "sis",
    .cli_string = "sis,tza",
    .stat_tap_init_cb = init_tza,
    .packet_func = tza_packet,
    .stat_tap_reset_table_cb = reset_table,
    .stat_tap_free_table_item_cb = free_item,
    .nfields = array_length(tza_columns),
    .fields = tza_columns,
    .nparams = array_length(parameters),
    .params = parameters,
};

static stat_tap_table_ui bus_table = {
    .group = REGISTER_PACKET_STAT_GROUP_UNSORTED,
    .title = "SIS bus by station",
    .tap_name = "frame",
    .cli_string = "sis,bus",
    .stat_tap_init_cb = init_bus,
    .packet_func = bus_packet,
    .stat_tap_reset_table_cb = reset_table,
    .stat_tap_free_table_item_cb = free_item,
    .nfields = array_length(bus_columns),
    .fields = bus_columns,
    .nparams = array_length(parameters),
    .params = parameters,
};

void
sis_tables_register(void)
{
    register_stat_tap_table_ui(&tza_table);
    register_stat_tap_table_ui(&bus_table);
}
