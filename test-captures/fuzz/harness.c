/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Dissects a sequence of packets as Wireshark does with a capture: libFuzzer calls it with input after input.
 */

#define _GNU_SOURCE /* setresuid() */

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>
#include <glib.h>
#include <epan/column.h>
#include <epan/column-info.h>
#include <epan/conversation_filter.h>
#include <epan/decode_as.h>
#include <epan/dfilter/dfilter.h>
#include <epan/epan.h>
#include <epan/epan_dissect.h>
#include <epan/packet.h>
#include <epan/prefs.h>
#include <epan/tap.h>
#include <epan/timestamp.h>
#include <wiretap/wtap.h>
#include <wsutil/filesystem.h>
#include <wsutil/privileges.h>
#include <wsutil/wslog.h>

#include "preferences.h"
#include "sequence.h"
#include "taps.h"

#define START       1700000000 /* seconds */
#define NS_PER_S    1000000000
#define SERVER      4200u /* and the port after it, which only the heuristic knows */
#define CLIENT      50000u
#define IP_SIZE     20u
#define TCP_HEAD    (IP_SIZE + 20u)
#define TCP_LONGEST 60000u
#define LONGEST     60 /* seconds of processor time for an input; on a busy machine the clock says nothing */
#define COUNTED     10000u /* packets; an interrupted run prints no last count */

int LLVMFuzzerInitialize(int *count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
void plugin_register(void);

struct packet_provider_data {
    nstime_t start;
};

/* A capture as it is dissected. */
typedef struct {
    const sequence_t *sequence;
    epan_t *session;
    frame_data *frames;
    wtap_rec *records;
    GByteArray **packets; /* with the heads of their roads */
    nstime_t elapsed;
    const frame_data *reference, *previous;
    uint32_t sum;
} capture_t;

static const char *const names[ROAD_SYNAXPD + 1] = {
    "sertap", "sis", "3964r", "rk512i", "arcnet7f", "synaxpk", "synaxpcp", "synaxpd",
};

static column_info columns;
static dfilter_t *filter;
static uint64_t packets_done;

static void
print_count(void)
{
    fprintf(stderr, "stat::packets: %" G_GUINT64_FORMAT "\n", packets_done);
}

static const nstime_t *
start_time(struct packet_provider_data *provider, uint32_t number G_GNUC_UNUSED)
{
    return &provider->start;
}

static void
append(GByteArray *bytes, uint32_t value, unsigned size)
{
    while (size-- > 0)
        g_byte_array_append(bytes, &(uint8_t){(uint8_t)(value >> 8 * size)}, 1);
}

/* Of link type 252: the dissector's name, filled up to four bytes, and the end of the list. */
static int
add_name(GByteArray *bytes, const char *name)
{
    uint32_t size = ((uint32_t)strlen(name) + 3) / 4 * 4;
    uint8_t filled[16] = {0};

    memcpy(filled, name, strlen(name));
    append(bytes, 12, 2);
    append(bytes, size, 2);
    g_byte_array_append(bytes, filled, size);
    append(bytes, 0, 4);
    return WTAP_ENCAP_WIRESHARK_UPPER_PDU;
}

/* Four directions: to and from two servers. Each counts its bytes in `next`. */
static int
add_tcp(GByteArray *bytes, const packet_t *packet, uint32_t *next)
{
    uint32_t is_answer = packet->interface & 1, port = SERVER + (packet->interface >> 1 & 1);
    uint32_t *number = &next[packet->interface & 3], length = MIN(packet->length, TCP_LONGEST);

    if (packet->quirks & QUIRK_LOST)
        *number += 5;
    if (packet->quirks & QUIRK_AGAIN)
        *number -= 3;
    append(bytes, 0x45000000 | (TCP_HEAD + length), 4);
    append(bytes, 0, 4);
    append(bytes, 0x40060000, 4); /* TTL 64, TCP, no checksum */
    append(bytes, 0x0A000001 + is_answer, 4);
    append(bytes, 0x0A000002 - is_answer, 4);
    append(bytes, is_answer ? port : CLIENT, 2);
    append(bytes, is_answer ? CLIENT : port, 2);
    append(bytes, *number, 4);
    append(bytes, 0, 4);
    append(bytes, 0x5018FFFF, 4); /* five words, PSH and ACK, window */
    append(bytes, 0, 4);
    *number += length;
    return WTAP_ENCAP_RAW_IP;
}

static int
add_head(GByteArray *bytes, const packet_t *packet, uint32_t *next)
{
    switch (packet->road) {
    case ROAD_USER0:
        return WTAP_ENCAP_USER0;
    case ROAD_RTAC:
        return WTAP_ENCAP_RTAC_SERIAL;
    case ROAD_TCP:
        return add_tcp(bytes, packet, next);
    default:
        return add_name(bytes, names[packet->road]);
    }
}

/* Times wrap around: any time that 64 bits can say comes up. */
static void
step(nstime_t *time, const packet_t *packet)
{
    int64_t ns = packet->quirks & QUIRK_SECONDS ? 0 : packet->step;
    int64_t seconds = packet->quirks & QUIRK_SECONDS ? packet->step : ns / NS_PER_S;

    time->nsecs += (int)(ns % NS_PER_S);
    time->secs = (time_t)((uint64_t)time->secs + (uint64_t)seconds);
    if (time->nsecs < 0 || time->nsecs >= NS_PER_S) {
        int carry = time->nsecs < 0 ? -1 : 1;

        time->nsecs -= carry * NS_PER_S;
        time->secs = (time_t)((uint64_t)time->secs + (uint64_t)carry);
    }
}

static void
make_record(wtap_rec *record, const packet_t *packet, int encapsulation, uint32_t length)
{
    wtap_rec_init(record);
    record->rec_type = REC_TYPE_PACKET;
    record->presence_flags = WTAP_HAS_TS | WTAP_HAS_CAP_LEN | WTAP_HAS_INTERFACE_ID | WTAP_HAS_SECTION_NUMBER;
    record->rec_header.packet_header.interface_id = packet->interface & 3;
    record->rec_header.packet_header.len = length;
    record->rec_header.packet_header.caplen = packet->quirks & QUIRK_CUT ? length - length / 3 : length;
    record->rec_header.packet_header.pkt_encap = encapsulation;
}

/* What reading the file gives. */
static capture_t
capture_open(const sequence_t *sequence)
{
    static const struct packet_provider_funcs functions = {.get_frame_ts = start_time};
    static struct packet_provider_data provider = {{START, 0}};
    unsigned count = sequence->packets->len, section = 0;
    uint32_t next[4] = {1000, 2000, 3000, 4000};
    nstime_t now = {START, 0};
    capture_t capture = {.sequence = sequence,
                         .session = epan_new(&provider, &functions),
                         .frames = g_new0(frame_data, count),
                         .records = g_new0(wtap_rec, count),
                         .packets = g_new0(GByteArray *, count)};

    for (unsigned i = 0; i < count; i++) {
        const packet_t *packet = sequence_packet(sequence, i);
        GByteArray *bytes = capture.packets[i] = g_byte_array_new();
        int encapsulation = add_head(bytes, packet, next);

        g_byte_array_append(bytes, packet->bytes,
                            packet->road == ROAD_TCP ? MIN(packet->length, TCP_LONGEST) : packet->length);
        make_record(&capture.records[i], packet, encapsulation, bytes->len);
        step(&now, packet);
        capture.records[i].ts = now;
        capture.records[i].section_number = section += !!(packet->quirks & QUIRK_SECTION);
        frame_data_init(&capture.frames[i], i + 1, &capture.records[i], 0, 0);
    }
    return capture;
}

static void
capture_close(capture_t *capture)
{
    for (unsigned i = 0; i < capture->sequence->packets->len; i++) {
        frame_data_destroy(&capture->frames[i]);
        wtap_rec_cleanup(&capture->records[i]);
        g_byte_array_free(capture->packets[i], TRUE);
    }
    g_free(capture->frames);
    g_free(capture->records);
    g_free(capture->packets);
    epan_free(capture->session);
}

/* strstr() tells libFuzzer what is looked for, and libFuzzer puts it into a telegram. So nothing here is
 * traced. */
__attribute__((no_sanitize("coverage"))) static gboolean
holds(const char *text, const char *word)
{
    for (; *text; text++) {
        size_t same = 0;

        while (word[same] && text[same] == word[same])
            same++;
        if (!word[same])
            return TRUE;
    }
    return FALSE;
}

/* What no packet may do: g_error() ends the run, and libFuzzer keeps the input. */
static void
check_text(const char *text)
{
    if (holds(text, "[Malformed Packet")) /* a dissector bug aborts by itself: see `run` */
        g_error("%s", text);
    if (!g_utf8_validate(text, -1, NULL))
        g_error("no UTF-8 in the packet list");
    for (; *text; text++)
        if ((unsigned char)*text < 0x20 || *text == 0x7F)
            g_error("control character 0x%02x in the packet list", (unsigned)*text);
}

/* The dialog of Decode As, for our tables alone. */
static void
ask_decode_as(const decode_as_t *table, packet_info *pinfo)
{
    char text[MAX_DECODE_AS_PROMPT_LEN];

    if (!g_str_has_prefix(table->table_name, "sertap"))
        return;
    for (unsigned i = 0; i < table->num_items; i++) {
        if (table->values[i].label_func != NULL)
            table->values[i].label_func(pinfo, text);
        for (unsigned j = 0; j < table->values[i].num_values; j++)
            (void)table->values[i].build_values[j](pinfo);
    }
}

/* What the menus do with the chosen packet. */
static void
use_menus(epan_dissect_t *edt)
{
    for (GList *at = packet_conv_filter_list; at != NULL; at = at->next) {
        const conversation_filter_t *conversation = (const conversation_filter_t *)at->data;

        if (conversation->is_filter_valid(&edt->pi))
            g_free(conversation->build_filter_string(&edt->pi));
    }
    for (GList *at = decode_as_list; at != NULL; at = at->next)
        ask_decode_as((const decode_as_t *)at->data, &edt->pi);
    dfilter_apply_edt(filter, edt);
}

static void
dissect(capture_t *capture, unsigned number, bool has_tree, bool has_taps)
{
    frame_data *frame = &capture->frames[number];
    GByteArray *bytes = capture->packets[number];
    uint32_t captured = capture->records[number].rec_header.packet_header.caplen;
    tvbuff_t *tvb = tvb_new_real_data(bytes->data, captured, (int)bytes->len);
    epan_dissect_t *edt = epan_dissect_new(capture->session, has_tree, has_tree);

    if (has_tree)
        epan_dissect_prime_with_dfilter(edt, filter);
    frame_data_set_before_dissect(frame, &capture->elapsed, &capture->reference, capture->previous);
    (has_taps ? epan_dissect_run_with_taps : epan_dissect_run)(
        edt, WTAP_FILE_TYPE_SUBTYPE_UNKNOWN, &capture->records[number], tvb, frame, &columns);
    epan_dissect_fill_in_columns(edt, FALSE, TRUE);
    check_text(col_get_text(&columns, COL_INFO));
    if (has_tree)
        use_menus(edt);
    frame_data_set_after_dissect(frame, &capture->sum);
    capture->previous = frame;
    epan_dissect_free(edt);
}

static void
pass(capture_t *capture, bool has_tree, bool has_taps, bool is_backwards)
{
    unsigned count = capture->sequence->packets->len;

    capture->elapsed = (nstime_t){0, 0};
    capture->reference = capture->previous = NULL;
    capture->sum = 0;
    if (has_taps)
        taps_open();
    for (unsigned i = 0; i < count; i++)
        dissect(capture, is_backwards ? count - 1 - i : i, has_tree, has_taps);
    if (has_taps)
        taps_close();
}

/* libFuzzer keeps the input. */
static void
hang(int number G_GNUC_UNUSED)
{
    abort();
}

static void
watch(int seconds)
{
    struct itimerval left = {.it_value = {.tv_sec = seconds}};

    setitimer(ITIMER_VIRTUAL, &left, NULL);
}

int
LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sequence_t sequence = sequence_read(data, size);
    bool is_backwards = sequence.way & WAY_BACKWARDS;
    capture_t capture;

    watch(LONGEST);
    preferences_set(sequence.preferences);
    capture = capture_open(&sequence);
    pass(&capture, sequence.way & WAY_TREE_FIRST, sequence.way & WAY_TAPS_FIRST, false);
    if (!(sequence.way & WAY_ONCE))
        pass(&capture, true, !is_backwards, is_backwards);
    preferences_set(sequence.changed);
    capture_close(&capture);
    packets_done += sequence.packets->len;
    if (packets_done / COUNTED != (packets_done - sequence.packets->len) / COUNTED)
        print_count();
    sequence_free(&sequence);
    watch(0);
    return 0;
}

/* As `-d rtacser.data,sis -d tcp.port==4200,sis`; a link type of the user is SIS. */
static void
decode_as(void)
{
    dissector_handle_t sis = find_dissector("sis");

    dissector_change_payload("rtacser.data", sis);
    dissector_change_uint("tcp.port", SERVER, sis);
    dissector_change_uint("wtap_encap", WTAP_ENCAP_USER0, sis);
}

/* Started by root, Wireshark would read its own tables of names and not the empty folder that `run` names:
 * that takes a second for each capture. It asks here, once, who has started it. */
static void
start_as_nobody(void)
{
    uid_t user = geteuid();
    gid_t group = getegid();

    if (user == 0 && (setresgid(65534, 65534, group) != 0 || setresuid(65534, 65534, user) != 0))
        g_error("cannot become nobody");
    init_process_policies();
    if (user == 0 && (setresuid(user, user, user) != 0 || setresgid(group, group, group) != 0))
        g_error("cannot become root again");
}

int
LLVMFuzzerInitialize(int *count G_GNUC_UNUSED, char ***arguments)
{
    char *error;
    e_prefs *settings;

    signal(SIGVTALRM, hang);
    start_as_nobody();
    ws_log_init("fuzz", NULL);
    g_free(configuration_init((*arguments)[0], NULL));
    wtap_init(FALSE);
    timestamp_set_type(TS_RELATIVE);
    timestamp_set_precision(TS_PREC_AUTO);
    timestamp_set_seconds_type(TS_SECONDS_DEFAULT);
    plugin_register();
    if (!epan_init(NULL, NULL, FALSE))
        g_error("libwireshark does not start");
    settings = epan_load_settings();
    prefs_apply_all();
    build_column_format_array(&columns, settings->num_cols, TRUE);
    decode_as();
    if (freopen("/dev/null", "w", stdout) == NULL) /* rows go there */
        g_error("no /dev/null");
    taps_begin();
    if (!dfilter_compile("sis.reaction_time > 0.05 || sis.parameter == \"S-0-0036\" || sertap.interval || "
                         "sis.value contains \"1\" || sis.value.number > 1 || sis.error || synaxpk",
                         &filter, &error))
        g_error("filter: %s", error);
    atexit(print_count);
    return 0;
}
