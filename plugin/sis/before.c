/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What was told before a file began: facts, one in a line. The tap heard them and writes them into an event
 * where a file continues another. What is heard afterwards replaces them. The lines are those of
 * capture/sistap/tap/sis/told.py:
 *
 *     3 TzA 5 ms                                          all TrS 40 ms not accepted
 *     3 baud rate 19200 Bd for 500000000 ns               (the rest of a timed test)
 *     3/2 device 1 S-0-0036 attribute 0x04220001          ... name Velocity command value
 *     3/2 device 1 S-0-0036 minimum 00 2d 31 01           (bytes)
 *     3/2 device 1 type key DKC02.3-040-7-FW              ... firmware FWA-ECODR3-SMT-02VRS-MS
 *
 * Any other line is shown and ignored. */
#include "kept.h"
#include "parts.h"

#include "parameters/ident.h"
#include "parameters/values.h"
#include "sis/bus.h"
#include "sis/station.h"

#define KEPT_FACTS 1 /* of a packet, next to the records of its telegrams */

#define LONGEST_LIMIT 512u                  /* bytes of a minimum or maximum */
#define LONGEST_TEST  UINT64_C(65535000000) /* ns */

/* The text of an event. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    sis_bus_t *bus;
} event_t;

/* What a fact is about. */
typedef struct {
    sis_place_t place;
    sis_ident_t ident;
} subject_t;

static bool
take_word(const char **at, const char *word)
{
    if (!g_str_has_prefix(*at, word))
        return false;
    *at += strlen(word);
    return true;
}

static bool
take_number(const char **at, uint64_t most, uint64_t *value)
{
    char *end;

    if (!g_ascii_isdigit(**at))
        return false;
    *value = g_ascii_strtoull(*at, &end, 10); /* too large a number becomes the largest */
    *at = end;
    return *value <= most;
}

/* "00 2d 31 01". NULL: it is something else. */
static tvbuff_t *
read_bytes(const event_t *event, const char *text)
{
    uint8_t *bytes = wmem_alloc(event->pinfo->pool, LONGEST_LIMIT);
    unsigned length = 0;

    do {
        if (length == LONGEST_LIMIT || !g_ascii_isxdigit(text[0]) || !g_ascii_isxdigit(text[1]))
            return NULL;
        bytes[length++] = (uint8_t)(g_ascii_xdigit_value(text[0]) << 4 | g_ascii_xdigit_value(text[1]));
        text += 2;
    } while (*text++ == ' ');
    return text[-1] == '\0' ? tvb_new_child_real_data(event->tvb, bytes, length, (int)length) : NULL;
}

static bool
read_name(const event_t *event _U_, const subject_t *subject _U_, sis_fact_t *fact)
{
    return fact->text[0] != '\0';
}

static bool
read_unit(const event_t *event _U_, const subject_t *subject _U_, sis_fact_t *fact)
{
    return fact->text[0] == '\0' || take_word(&fact->text, " ");
}

static bool
read_attribute(const event_t *event _U_, const subject_t *subject _U_, sis_fact_t *fact)
{
    const char *digits = fact->text;

    if (!take_word(&digits, "0x") || strlen(digits) != 8 || strspn(digits, "0123456789abcdef") != 8)
        return false;
    fact->attribute = (uint32_t)g_ascii_strtoull(digits, NULL, 16);
    return true;
}

/* Shown as the attribute says that is known by now. */
static bool
read_limit(const event_t *event, const subject_t *subject, sis_fact_t *fact)
{
    const sis_known_t *said = sis_learned_find(sis_learned_of(event->bus), &subject->place, subject->ident);
    sis_known_t known = sis_learned_or_from_tables(said, NULL, &subject->place, subject->ident);
    sis_element_data_t data = {read_bytes(event, fact->text), ENC_LITTLE_ENDIAN, true, &subject->place};

    if (data.tvb == NULL)
        return false;
    fact->text = sis_add_element(NULL, event->pinfo, &data, fact->element, &subject->ident, &known);
    return true;
}

static const struct {
    const char *word;
    sis_element_t element;
    bool (*read)(const event_t *event, const subject_t *subject, sis_fact_t *fact);
} elements[] = {
    {" name ", SIS_ELEMENT_NAME, read_name},
    {" unit", SIS_ELEMENT_UNIT, read_unit}, /* it may be empty */
    {" attribute ", SIS_ELEMENT_ATTRIBUTE, read_attribute},
    {" minimum ", SIS_ELEMENT_MINIMUM, read_limit},
    {" maximum ", SIS_ELEMENT_MAXIMUM, read_limit},
};

/* " name Velocity command value". */
static bool
take_element(const event_t *event, const char *at, const subject_t *subject)
{
    sis_fact_t fact = {0};
    unsigned i = 0;

    while (i < array_length(elements) && !take_word(&at, elements[i].word))
        i++;
    if (i == array_length(elements))
        return false;
    fact.element = elements[i].element;
    fact.text = at;
    if (!elements[i].read(event, subject, &fact))
        return false;
    if (fact.text != NULL)
        sis_learned_add(sis_learned_of(event->bus), &subject->place, subject->ident, &fact);
    return true;
}

/* "type key DKC02.3-040-7-FW", behind the device. */
static bool
take_identity(const event_t *event, const char *at, const sis_place_t *place)
{
    static const char *const words[] = {[SIS_TYPE_KEY] = "type key ", [SIS_FIRMWARE] = "firmware "};
    unsigned what = 0;

    while (what < SIS_IDENTITIES && !take_word(&at, words[what]))
        what++;
    if (what == SIS_IDENTITIES || *at == '\0')
        return false;
    sis_learned_identity(sis_learned_of(event->bus), place, (sis_identity_t)what, at);
    return true;
}

/* " device 1 S-0-0036 ...", behind the stations. */
static bool
take_parameter(const event_t *event, const char *at, sis_place_t place)
{
    subject_t subject = {.place = place};
    uint64_t device;

    if (!take_word(&at, " device ") || !take_number(&at, UINT8_MAX, &device) || !take_word(&at, " "))
        return false;
    subject.place.device = (uint8_t)device;
    if (take_identity(event, at, &subject.place))
        return true;
    at = sis_ident_parse(at, &subject.ident);
    return at != NULL && take_element(event, at, &subject);
}

static const struct {
    const char *word, *unit;
    uint32_t most;
    sis_setting_kind_t kind;
} kinds[] = {
    {" TrS ", " ms", UINT16_MAX, SIS_TRS},
    {" TzA ", " ms", UINT16_MAX, SIS_TZA},
    {" Tmas ", " ms", UINT16_MAX, SIS_TMAS},
    {" baud rate ", " Bd", UINT32_MAX, SIS_BAUD},
};

/* " TzA 5 ms". */
static bool
take_value(const char **at, sis_recalled_t *recalled)
{
    uint64_t value;
    unsigned i = 0;

    while (i < array_length(kinds) && !take_word(at, kinds[i].word))
        i++;
    if (i == array_length(kinds) || !take_number(at, kinds[i].most, &value) || !take_word(at, kinds[i].unit))
        return false;
    recalled->kind = kinds[i].kind;
    recalled->value = (uint32_t)value;
    return true;
}

/* " not accepted"; " for 500 ns" of a rate; or nothing. */
static bool
take_state(const event_t *event, const char **at, sis_recalled_t *recalled)
{
    uint64_t rest;

    recalled->is_accepted = !take_word(at, " not accepted");
    if (!recalled->is_accepted || recalled->kind != SIS_BAUD || !take_word(at, " for "))
        return true;
    if (!take_number(at, LONGEST_TEST, &rest) || !take_word(at, " ns"))
        return false;
    if (rest > 0)
        recalled->test_end = sertap_ns(&event->pinfo->abs_ts) + (int64_t)rest;
    return true;
}

/* " TzA 5 ms not accepted", behind a station or "all". */
static bool
take_setting(const event_t *event, const char *at, uint8_t address)
{
    sis_recalled_t recalled = {.address = address};

    if (!take_value(&at, &recalled) || !take_state(event, &at, &recalled) || *at != '\0')
        return false;
    sis_bus_recall(event->bus, &recalled, event->pinfo->num);
    return true;
}

/* First pass: learns from a line. False: it is no fact. */
static bool
take_fact(const event_t *event, const char *line)
{
    sis_place_t place = {0};

    if (take_word(&line, "all"))
        return take_setting(event, line, SIS_ALL_STATIONS);
    if (!sis_place_parse(&line, &place))
        return false;
    return take_parameter(event, line, place) ||
           (place.path_length == 1 && take_setting(event, line, place.path[0]));
}

/* Whether a line has only characters that the tap writes: those that sis_text() makes of Latin-1. */
static bool
is_plain(const char *line, unsigned length)
{
    for (const char *at = line; *at != '\0'; at = g_utf8_next_char(at)) {
        gunichar c = g_utf8_get_char(at);

        if (c < 0x20 || (c > 0x7E && c < 0xA0) || c == 0xAD || (c > 0xFF && c < 0x2400) || c > 0x2421)
            return false;
    }
    return strlen(line) == length; /* it has no NUL either */
}

static int
dissect_before(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data _U_)
{
    event_t event = {tvb, pinfo, sis_exchange_bus(pinfo)};
    unsigned *facts = kept_of_packet(pinfo, proto_sis, KEPT_FACTS, sizeof *facts), end;

    for (unsigned at = 0; at < tvb_reported_length(tvb); at = end + 1) {
        const char *line;

        if (!compat_find_uint8(tvb, at, '\n', &end))
            end = tvb_reported_length(tvb);
        if (end == at)
            continue;
        line = (const char *)tvb_get_string_enc(pinfo->pool, tvb, at, end - at, ENC_UTF_8);
        if (!pinfo->fd->visited)
            *facts += is_plain(line, end - at) && take_fact(&event, line);
        proto_tree_add_item(tree, hf_sis_told_before, tvb, at, end - at, ENC_UTF_8);
    }
    col_add_fstr(pinfo->cinfo, COL_INFO, "Told before: %u fact%s", *facts, plurality(*facts, "", "s"));
    return tvb_captured_length(tvb);
}

void
sis_before_handoff(void)
{
    dissector_add_uint("sertap.told", 0, create_dissector_handle(dissect_before, proto_sis));
}
