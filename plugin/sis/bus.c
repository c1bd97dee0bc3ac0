/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Settings of the bus, for each slave and for all (chapter 6). A value counts as set with the slave's good
 * reaction, or at once if nobody answers; subservice 0xFF makes the set values valid. */

#include "sis/bus.h"

#include "sis/address.h"

/* Of one station, or of all. */
typedef struct {
    sis_settings_t told;  /* accepted_in is 0 */
    sis_settings_t valid; /* as far as this station accepted them */
} station_t;

/* A timed test of a baud rate (chapter 6.1, subservice 0x08). */
typedef struct {
    sis_setting_t rate;
    int64_t end; /* ns since 1970 */
} test_t;

struct sis_told {
    station_t *stations[256];
    test_t tests[256];
    const sis_settings_t *known[256]; /* sis_bus_settings() of each; NULL: to be made */
    uint32_t limits_in;               /* the event that brought the user's limits; 0: none */
};

/* The settings of the bus; made when the first is set. */
static struct sis_told *
told_of(sis_bus_t *bus)
{
    if (bus->told == NULL)
        bus->told = wmem_new0(wmem_file_scope(), struct sis_told);
    return bus->told;
}

/* When a station is first told something, the values for all hold for it so far. */
static station_t *
find_station(struct sis_told *told, uint8_t address)
{
    const station_t *all = told->stations[SIS_ALL_STATIONS];

    if (told->stations[address] == NULL) {
        told->stations[address] = wmem_new0(wmem_file_scope(), station_t);
        if (all != NULL)
            told->stations[address]->valid = all->valid;
    }
    return told->stations[address];
}

static void
forget_known(struct sis_told *told)
{
    memset(told->known, 0, sizeof told->known);
}

/* Makes the set values for a station or for all valid, if they are newer. A new rate ends a test. */
static void
accept(station_t *station, test_t *test, const station_t *all, uint32_t frame)
{
    for (unsigned kind = 0; kind < SIS_SETTINGS; kind++) {
        sis_setting_t setting = station->told.of[kind];

        if (all->told.of[kind].set_in > setting.set_in)
            setting = all->told.of[kind];
        if (setting.set_in <= station->valid.of[kind].set_in)
            continue;
        setting.accepted_in = frame;
        station->valid.of[kind] = setting;
        if (kind == SIS_BAUD)
            test->end = 0;
    }
}

static void
accept_of(struct sis_told *told, uint8_t address, uint32_t frame)
{
    const station_t *all = find_station(told, SIS_ALL_STATIONS);

    for (unsigned i = 0; i < array_length(told->stations); i++) {
        if (told->stations[i] != NULL && (address == SIS_ALL_STATIONS || address == i))
            accept(told->stations[i], &told->tests[i], all, frame);
    }
}

static const struct {
    uint8_t subservice;
    sis_setting_kind_t kind;
} kinds[] = {
    {SIS_SET_TRS, SIS_TRS},
    {SIS_SET_TZA, SIS_TZA},
    {SIS_SET_TMAS, SIS_TMAS},
    {SIS_SET_BAUD_RATE, SIS_BAUD},
};

/* `now`: the end of the telegram that makes this valid. */
static void
learn(struct sis_told *told, uint8_t address, const sis_request_t *request, uint32_t command, uint32_t frame,
      int64_t now)
{
    sis_setting_t setting = {.value = request->setting, .set_in = command};

    forget_known(told);
    find_station(told, address);
    if (request->subservice == SIS_ACCEPT)
        accept_of(told, address, frame);
    if (request->subservice == SIS_TEST_BAUD)
        told->tests[address] = (test_t){setting, now + request->test_ms * INT64_C(1000000)};
    for (unsigned i = 0; i < array_length(kinds); i++) {
        if (kinds[i].subservice == request->subservice)
            find_station(told, address)->told.of[kinds[i].kind] = setting;
    }
}

static bool
is_broadcast(sis_address_kind_t kind)
{
    return kind == SIS_LEVEL_BROADCAST || kind == SIS_GLOBAL_BROADCAST;
}

/* Settings through a router are for another line. A slave reacts to 0xFF with the new values already. */
void
sis_bus_learn(sis_body_t *body)
{
    const sis_telegram_t *telegram = body->telegram;
    const sis_request_t *first = body->is_reaction ? body->asked : body->request, *request = first;
    sis_exchange_t *exchange = body->record != NULL ? body->record->exchange : NULL;
    bool is_for_all = is_broadcast(sis_receiver_kind(telegram->receiver));
    struct sis_told *told;
    uint8_t address;

    if (body->pinfo->fd->visited || exchange == NULL || request == NULL || telegram->subaddress_count > 0 ||
        (is_for_all ? body->is_reaction : !body->is_reaction))
        return;
    if (body->is_reaction && (body->status != 0 || body->record->reaction_before != 0))
        return;
    told = told_of(exchange->stream->bus);
    address = is_for_all ? SIS_ALL_STATIONS : exchange->path[0];
    for (; request != NULL; request = request == first ? first->list : request->next) {
        if (!request->has_setting)
            continue;
        learn(told, address, request, exchange->command_in, body->pinfo->num, telegram->times.end);
        if (body->is_reaction && request->subservice == SIS_ACCEPT)
            body->record->settings = sis_bus_settings(exchange->stream->bus, address, telegram->times.begin);
    }
}

/* "TzA = 8 ms" in a text; 0: it is not there, or no time that a bus can be told. */
static uint32_t
find_limit(const char *text, const char *name)
{
    const char *found = strstr(text, name);
    uint64_t value = 0;

    if (found != NULL && g_ascii_isdigit(found[strlen(name)]))
        value = g_ascii_strtoull(found + strlen(name), NULL, 10);
    return value <= UINT16_MAX ? (uint32_t)value : 0;
}

static void
learn_limit(struct sis_told *told, sis_setting_kind_t kind, uint32_t value)
{
    for (unsigned i = 0; i < array_length(told->stations); i++) {
        station_t *station = told->stations[i];
        sis_setting_t *valid = station != NULL ? &station->valid.of[kind] : NULL;

        if (valid != NULL && (valid->set_in == 0 || valid->is_by_user))
            *valid = (sis_setting_t){value, told->limits_in, told->limits_in, true};
    }
}

void
sis_bus_learn_limits(sis_bus_t *bus, const sertap_limits_t *limits)
{
    static const struct {
        const char *name;
        sis_setting_kind_t kind;
    } names[] = {{"TzA = ", SIS_TZA}, {"TrS = ", SIS_TRS}};
    struct sis_told *told;

    if (limits->told_in == 0 || (bus->told != NULL && bus->told->limits_in == limits->told_in))
        return;
    told = told_of(bus);
    told->limits_in = limits->told_in;
    forget_known(told);
    find_station(told, SIS_ALL_STATIONS);
    for (unsigned i = 0; i < array_length(names); i++) {
        uint32_t value = find_limit(limits->text, names[i].name);

        if (value != 0)
            learn_limit(told, names[i].kind, value);
    }
}

static const sis_settings_t *
make_settings(struct sis_told *told, uint8_t address)
{
    const station_t *all = told->stations[SIS_ALL_STATIONS], *own = told->stations[address];
    sis_settings_t *settings = wmem_new0(wmem_file_scope(), sis_settings_t);

    if (own != NULL || all != NULL)
        *settings = own != NULL ? own->valid : all->valid;
    if (told->tests[SIS_ALL_STATIONS].end != 0)
        settings->of[SIS_BAUD] = told->tests[SIS_ALL_STATIONS].rate;
    if (told->tests[address].end != 0)
        settings->of[SIS_BAUD] = told->tests[address].rate;
    return settings;
}

static void
end_tests(struct sis_told *told, uint8_t address, int64_t now)
{
    if (told->tests[address].end != 0 && now > told->tests[address].end) {
        told->tests[address].end = 0;
        forget_known(told);
    }
}

const sis_settings_t *
sis_bus_settings(const sis_bus_t *bus, uint8_t address, int64_t now)
{
    struct sis_told *told = bus->told;

    if (told == NULL)
        return NULL;
    end_tests(told, address, now);
    end_tests(told, SIS_ALL_STATIONS, now);
    if (told->known[address] == NULL)
        told->known[address] = make_settings(told, address);
    return told->known[address];
}
