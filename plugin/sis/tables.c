/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Tables of the timing: intervals by talker (`tshark -z sis,tza`), and the bus by station (`tshark -z
 * sis,bus`). The first row is the sum of all. */
#include "parts.h"

#include <math.h>

#include "sertap/line.h"
#include "sis/exchange.h"
#include "sis/table.h"

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

/* A value is as wide as its column's name, so that tshark writes columns. The first has room for the arrow of
 * the sorted column. */
/* clang-format off */
static stat_tap_table_item tza_columns[TZA_COLUMNS] = {
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Talker    ", "%-10s"},
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
    {TABLE_ITEM_STRING, TAP_ALIGN_LEFT, "Station    ", "%-11s"},
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

/* Quantiles: those of few intervals are exact. Those of more are from a histogram, in little memory. */
#define FEW                4096
#define BUCKETS_PER_OCTAVE 32 /* 32 for each doubling: a quantile is at most 3 % too large */
#define BUCKETS            (BUCKETS_PER_OCTAVE * 28)

/* The bucket of one quantile. Each value moves it by a few buckets at most. */
typedef struct {
    unsigned percent; /* share of the values that are not larger */
    unsigned bucket;
    uint64_t below; /* values in the buckets before */
} quantile_t;

typedef struct {
    uint64_t count;
    uint32_t largest;
    uint32_t few[FEW]; /* the first ones, sorted */
    uint32_t counts[BUCKETS];
    quantile_t p50, p99;
} quantiles_t;

static void
quantiles_init(quantiles_t *quantiles)
{
    memset(quantiles, 0, sizeof *quantiles);
    quantiles->p50.percent = 50;
    quantiles->p99.percent = 99;
}

/* Below 32 ns a bucket is 1 ns; above, the five bits after the first one select the bucket. */
static unsigned
bucket_of(uint32_t ns)
{
    int octave = g_bit_nth_msf(ns, -1) - 5;

    if (octave < 0)
        return ns;
    return (unsigned)(octave + 1) * BUCKETS_PER_OCTAVE + (ns >> octave) - BUCKETS_PER_OCTAVE;
}

static uint32_t
end_of_bucket(unsigned bucket)
{
    unsigned octave = bucket / BUCKETS_PER_OCTAVE, rest = bucket % BUCKETS_PER_OCTAVE;

    if (octave == 0)
        return bucket;
    return (uint32_t)((((uint64_t)rest + BUCKETS_PER_OCTAVE + 1) << (octave - 1)) - 1);
}

/* So many values are not larger than the quantile. */
static uint64_t
share_of(const quantiles_t *quantiles, const quantile_t *quantile)
{
    return (quantile->percent * quantiles->count + 99) / 100;
}

static void
move(quantile_t *quantile, const quantiles_t *quantiles, unsigned bucket)
{
    uint64_t wanted = share_of(quantiles, quantile);

    if (bucket < quantile->bucket)
        quantile->below++;
    while (quantile->below >= wanted)
        quantile->below -= quantiles->counts[--quantile->bucket];
    while (quantile->below + quantiles->counts[quantile->bucket] < wanted)
        quantile->below += quantiles->counts[quantile->bucket++];
}

static void
insert(uint32_t *sorted, unsigned count, uint32_t value)
{
    for (; count > 0 && sorted[count - 1] > value; count--)
        sorted[count] = sorted[count - 1];
    sorted[count] = value;
}

/* Takes an interval, in ns. */
static void
quantiles_add(quantiles_t *quantiles, uint32_t ns)
{
    unsigned bucket = bucket_of(ns);

    if (quantiles->count < FEW)
        insert(quantiles->few, (unsigned)quantiles->count, ns);
    quantiles->counts[bucket]++;
    quantiles->count++;
    quantiles->largest = MAX(quantiles->largest, ns);
    move(&quantiles->p50, quantiles, bucket);
    move(&quantiles->p99, quantiles, bucket);
}

/* In ns; rather too large than too small. There must be a value. */
static uint32_t
quantile_ns(const quantiles_t *quantiles, const quantile_t *quantile)
{
    if (quantiles->count <= FEW)
        return quantiles->few[share_of(quantiles, quantile) - 1];
    return MIN(end_of_bucket(quantile->bucket), quantiles->largest);
}

/* Sums of a row beside its columns. */
typedef struct {
    sis_row_t lines; /* in the first row: the set of lines seen */
    int station;
    quantiles_t intervals;
    uint64_t busy; /* ns */
    double span;   /* ns, in the first row: from the first character on; times that went back do not count */
    int64_t last;  /* in the first row: time of the last record, ns since 1970; 0: none yet */
    uint64_t duration; /* and how long it took, ns */
} row_t;

static unsigned
add_row(stat_tap_table *table, int station, const stat_tap_table_item *columns)
{
    row_t *row = g_new0(row_t, 1);
    unsigned number = sis_table_add_row(table, columns, row);
    char text[4];

    row->station = station;
    row->lines.hash = g_hash_table_new(NULL, NULL);
    quantiles_init(&row->intervals);
    snprintf(text, sizeof text, "%3d", station);
    sis_table_set_text(table, number, 0, station == ALL ? "All" : text);
    return number;
}

static unsigned
find_row(stat_tap_table *table, int station, const stat_tap_table_item *columns)
{
    for (unsigned i = 0; i < table->num_elements; i++) {
        if (((row_t *)sis_table_row(table, i))->station == station)
            return i;
    }
    return add_row(table, station, columns);
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

static int64_t
rounded_us(int64_t ns)
{
    return (ns + NS_PER_US / 2) / NS_PER_US;
}

static void
set_ms(const stat_tap_table *table, unsigned row, unsigned column, int64_t ns)
{
    set_decimal(table, row, column, 3, rounded_us(ns));
}

static bool
raise_to(const stat_tap_table *table, unsigned row, unsigned column, int64_t ns)
{
    const stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);

    if ((double)rounded_us(ns) <= item->user_data.float_value)
        return false;
    set_ms(table, row, column, ns);
    return true;
}

/* "<=12.000", ">4294.967": a bound; the true time is unknown. */
static void
mark_as_bound(const stat_tap_table *table, unsigned row, unsigned column, const char *sign)
{
    stat_tap_table_item_type *item = stat_tap_get_field_data(table, row, column);
    char *text = (char *)item->value.string_value;

    if (g_str_has_prefix(text, sign))
        return;
    item->value.string_value = g_strconcat(sign, g_strchug(text), NULL);
    g_free(text);
}

/* Empty where no interval has an exact time. An interval as long as can be stored may have been longer. */
static void
set_quantile(const stat_tap_table *table, unsigned row, unsigned column, const quantiles_t *quantiles,
             const quantile_t *quantile)
{
    uint32_t ns = quantiles->count > 0 ? quantile_ns(quantiles, quantile) : 0;

    if (quantiles->count > 0)
        set_ms(table, row, column, ns);
    if (ns == UINT32_MAX)
        mark_as_bound(table, row, column, ">");
}

static void
raise_longest(const stat_tap_table *table, unsigned row, const sis_interval_t *longest)
{
    bool is_recorded = longest->is_exact || longest->is_saturated;

    if (longest->at == 0 || (!is_recorded && longest->span.most == SIS_ANY_TIME))
        return;
    if (!raise_to(table, row, TZA_LONGEST, is_recorded ? longest->recorded : longest->span.most))
        return;
    if (longest->is_saturated)
        mark_as_bound(table, row, TZA_LONGEST, ">");
    else if (!longest->is_exact)
        mark_as_bound(table, row, TZA_LONGEST, "<=");
}

/* Resets everything; the rows stay. */
static void
reset_table(stat_tap_table *table)
{
    for (unsigned i = 0; i < table->num_elements; i++) {
        row_t *row = sis_table_row(table, i);

        quantiles_init(&row->intervals);
        row->busy = row->duration = 0;
        row->span = 0;
        row->last = 0;
        g_hash_table_remove_all(row->lines.hash);
        sis_table_reset_row(table, i, 1);
    }
}

static bool
is_same_read(const sis_times_t *times, unsigned character)
{
    return character < times->count &&
           compat_get_uint8(times->record->tvb, times->record->flags_offset + times->first + character) &
               SERTAP_SAME_READ;
}

/* The interval before a character: into the histogram if both characters were read alone. One between a read
 * of several and another read is in no column. */
static void
count_interval(const stat_tap_table *table, unsigned row, const sis_times_t *times, unsigned character)
{
    const sertap_record_t *record = times->record;
    unsigned at = times->first + character, bin = 0;
    uint32_t ns = tvb_get_ntohl(record->tvb, record->times_offset + 4 * at);

    if (compat_get_uint8(record->tvb, record->flags_offset + at) &
        (SERTAP_INTERVAL_UNKNOWN | SERTAP_ERROR_LOST))
        return;
    if (is_same_read(times, character)) {
        sis_table_count(table, row, TZA_ONE_READ, 1);
        return;
    }
    if (is_same_read(times, character - 1) || is_same_read(times, character + 1))
        return;
    while (ns >= bins_ms[bin] * NS_PER_MS)
        bin++;
    sis_table_count(table, row, TZA_BINS + bin, 1);
    quantiles_add(&((row_t *)sis_table_row(table, row))->intervals, ns);
}

static void
count_intervals(const stat_tap_table *table, unsigned row, const sis_telegram_t *telegram)
{
    const sis_interval_t *longest = &telegram->timing.longest.interval;
    const quantiles_t *intervals = &((row_t *)sis_table_row(table, row))->intervals;

    sis_table_count(table, row, TZA_TELEGRAMS, 1);
    sis_table_count(table, row, TZA_CHARACTERS, telegram->length);
    for (unsigned i = 1; i < telegram->times.count; i++)
        count_interval(table, row, &telegram->times, i);
    set_quantile(table, row, TZA_P50, intervals, &intervals->p50);
    set_quantile(table, row, TZA_P99, intervals, &intervals->p99);
    raise_longest(table, row, longest);
    if (telegram->timing.tza > 0 && telegram->timing.longest.verdict == SIS_TIME_EXCEEDED)
        sis_table_count(table, row, TZA_EXCEEDED, 1);
    if (telegram->timing.tza > 0 && telegram->timing.longest.verdict == SIS_TIME_UNRESOLVED)
        sis_table_count(table, row, TZA_UNRESOLVED, 1);
}

/* The sender of a damaged telegram is unknown. */
static tap_packet_status
tza_packet(void *data, packet_info *pinfo _U_, epan_dissect_t *edt _U_, const void *tapped,
           tap_flags_t flags _U_)
{
    const sis_telegram_t *telegram = tapped;
    stat_tap_table *table = sis_table_of(data);

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
        SERTAP_ERROR_CHARACTER | SERTAP_ERROR_BREAK | SERTAP_ERROR_LOST | SERTAP_ERROR_UNLOCATED;
    unsigned found = 0;

    for (unsigned i = first; record->flags & errors && i < first + count_; i++)
        found += (compat_get_uint8(record->tvb, record->flags_offset + i) & errors) != 0;
    return found;
}

static void
count_record(const stat_tap_table *table, packet_info *pinfo, const sertap_record_t *record)
{
    row_t *all = sis_table_row(table, 0);
    int64_t now = sertap_ns(&pinfo->abs_ts);

    sis_table_count(table, 0, BUS_CHARACTERS, record->count);
    sis_table_count(table, 0, BUS_LINE, line_errors(record, 0, record->timed));
    all->busy += (uint64_t)sertap_character_ns(record) * record->count;
    g_hash_table_add(all->lines.hash, GUINT_TO_POINTER(compat_interface(pinfo)));
    all->span += all->last == 0 ? sertap_character_ns(record) : MAX(sertap_elapsed(all->last, now), 0);
    all->last = now;
    all->duration = record->duration;
}

static void
count_timing(const stat_tap_table *table, unsigned row, const sis_telegram_t *telegram)
{
    const sis_timing_t *timing = &telegram->timing;
    const sis_exchange_t *exchange = telegram->record->exchange;

    if (timing->has_silence) {
        if (raise_to(table, row, BUS_SILENCE, timing->silence) && !timing->is_silence_known)
            mark_as_bound(table, row, BUS_SILENCE, ">");
        sis_table_count(table, row, BUS_SILENCES, timing->silence > SILENCE_NS);
    }
    if (timing->has_reaction_time)
        sis_table_count(table, row, BUS_CYCLES,
                        sertap_elapsed(exchange->command_end, telegram->times.end) +
                                exchange->command_duration >
                            CYCLE_NS);
    sis_table_count(table, row, BUS_TZA, timing->tza > 0 && timing->longest.verdict == SIS_TIME_EXCEEDED);
    sis_table_count(table, row, BUS_TRS, timing->trs > 0 && timing->trs_verdict == SIS_TIME_EXCEEDED);
}

static void
count_talker(stat_tap_table *table, const sis_telegram_t *telegram)
{
    unsigned row = find_row(table, telegram->talker, bus_columns);
    const sis_times_t *times = &telegram->times;

    sis_table_count(table, row, BUS_TELEGRAMS, 1);
    sis_table_count(table, row, BUS_CHARACTERS, telegram->length);
    count_timing(table, 0, telegram);
    count_timing(table, row, telegram);
    if (times->record == NULL)
        return;
    ((row_t *)sis_table_row(table, row))->busy += (uint64_t)times->character * times->count;
    sis_table_count(table, row, BUS_LINE, line_errors(times->record, times->first, times->count));
}

/* The station that the master had to ask again, or in vain. */
static void
count_asked(stat_tap_table *table, const sis_exchange_t *exchange)
{
    if (exchange->first != NULL) {
        sis_table_count(table, 0, BUS_REPEATS, 1);
        sis_table_count(table, find_row(table, exchange->path[0], bus_columns), BUS_REPEATS, 1);
    }
    if (exchange->gave_up != 0) {
        sis_table_count(table, 0, BUS_UNANSWERED, 1);
        sis_table_count(table, find_row(table, exchange->gave_up_station, bus_columns), BUS_UNANSWERED, 1);
    }
}

static void
count_telegram(stat_tap_table *table, const sis_telegram_t *telegram)
{
    const sis_exchange_t *exchange = telegram->record->exchange;

    sis_table_count(table, 0, BUS_TELEGRAMS, 1);
    if (telegram->times.record == NULL)
        sis_table_count(table, 0, BUS_CHARACTERS,
                        tvb_reported_length(telegram->tvb)); /* and what follows it */
    if (!telegram->is_good) {
        sis_table_count(table, 0, BUS_DAMAGED, 1);
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

/* For several lines, such as two directions, the mean. The files of a ring, read as one, have the same
 * lines. */
static void
set_loads(const stat_tap_table *table)
{
    const row_t *all = sis_table_row(table, 0);
    double span = all->span + (double)all->duration;
    unsigned lines = g_hash_table_size(all->lines.hash);

    if (span <= 0)
        return;
    for (unsigned i = 0; i < table->num_elements; i++)
        set_decimal(table, i, BUS_LOAD, 1,
                    permille(((row_t *)sis_table_row(table, i))->busy, span * (i == 0 ? lines : 1.0)));
}

/* Called for every packet, because the line's other characters have errors, too. */
static tap_packet_status
bus_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped _U_,
           tap_flags_t flags _U_)
{
    stat_tap_table *table = sis_table_of(data);
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
init_table(stat_tap_table_ui *ui, const char *title)
{
    stat_tap_table *table = sis_table_begin(ui, title);

    if (table != NULL)
        add_row(table, ALL, ui->fields);
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

static stat_tap_table_ui tza_table = {
    SIS_TABLE(tza_columns),
    .title = "SIS intervals by talker (TzA)",
    .tap_name = "sis",
    .cli_string = "sis,tza",
    .stat_tap_init_cb = init_tza,
    .packet_func = tza_packet,
    .stat_tap_reset_table_cb = reset_table,
};

static stat_tap_table_ui bus_table = {
    SIS_TABLE(bus_columns),
    .title = "SIS bus by station",
    .tap_name = "frame",
    .cli_string = "sis,bus",
    .stat_tap_init_cb = init_bus,
    .packet_func = bus_packet,
    .stat_tap_reset_table_cb = reset_table,
};

void
sis_tables_register(void)
{
    register_stat_tap_table_ui(&tza_table);
    register_stat_tap_table_ui(&bus_table);
}
