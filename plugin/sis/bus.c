/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Settings of the bus, for each slave and for all (chapter 6). A value counts as set with the slave's good
 * reaction, or at once if nobody answers; subservice 0xFF makes the set values valid. */
#include "sis/bus.h"

#include "sis/address.h"

/* A timed test of a baud rate (chapter 6.1, subservice 0x08). */
typedef struct {
    sis_setting_t rate;
    int64_t end; /* ns since 1970; 0: no test */
} test_t;

/* Of one station, or of all. */
typedef struct station {
    struct station *next;
    uint8_t address;
    sis_settings_t told;  /* accepted_in is 0 */
    sis_settings_t valid; /* as far as this station accepted them */
    test_t test;
    const sis_settings_t *known; /* sis_bus_settings(); NULL: to be made */
} station_t;

/* A TCP connection is a bus of its own, and a capture may have very many: a list costs less than an array. */
struct sis_told {
    station_t all;      /* and after it those that were told something themselves */
    uint32_t limits_in; /* the event that brought the user's limits; 0: none */
    uint32_t last_order;
};

/* The settings of the bus; made when the first is set. */
static struct sis_told *
told_of(sis_bus_t *bus)
{
    if (bus->told == NULL) {
        bus->told = wmem_new0(wmem_file_scope(), struct sis_told);
        bus->told->all.address = SIS_ALL_STATIONS;
    }
    return bus->told;
}

/* For a station that was told nothing itself, what all were told holds. */
static station_t *
find_station(struct sis_told *told, uint8_t address)
{
    station_t *station = &told->all;

    while (station != NULL && station->address != address)
        station = station->next;
    return station != NULL ? station : &told->all;
}

/* When a station is first told something, the values for all hold for it so far. */
static station_t *
make_station(struct sis_told *told, uint8_t address)
{
    station_t *station = find_station(told, address);

    if (address == SIS_ALL_STATIONS || station != &told->all)
        return station;
    station = wmem_new0(wmem_file_scope(), station_t);
    station->address = address;
    station->valid = told->all.valid;
    station->next = told->all.next;
    told->all.next = station;
    return station;
}

static void
forget_known(struct sis_told *told)
{
    for (station_t *station = &told->all; station != NULL; station = station->next)
        station->known = NULL;
}

/* Makes the set values for a station or for all valid, if they are newer. A new rate ends a test. */
static void
accept(station_t *station, const station_t *all, uint32_t frame)
{
    for (unsigned kind = 0; kind < SIS_SETTINGS; kind++) {
        sis_setting_t setting = station->told.of[kind];

        if (all->told.of[kind].order > setting.order)
            setting = all->told.of[kind];
        if (setting.order <= station->valid.of[kind].order)
            continue;
        setting.accepted_in = frame;
        station->valid.of[kind] = setting;
        if (kind == SIS_BAUD)
            station->test.end = 0;
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
    sis_setting_t setting = {.value = request->setting, .set_in = command, .order = ++told->last_order};
    station_t *station = make_station(told, address);

    forget_known(told);
    for (station_t *each = &told->all; each != NULL && request->subservice == SIS_ACCEPT; each = each->next) {
        if (each == station || station == &told->all)
            accept(each, &told->all, frame);
    }
    if (request->subservice == SIS_TEST_BAUD)
        station->test = (test_t){setting, now + request->test_ms * INT64_C(1000000)};
    for (unsigned i = 0; i < array_length(kinds); i++) {
        if (kinds[i].subservice == request->subservice)
            station->told.of[kinds[i].kind] = setting;
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
    const sis_request_t *first = sis_request_of(body), *request = first;
    const sis_exchange_t *exchange = body->record->exchange;
    bool is_for_all = is_broadcast(sis_receiver_kind(telegram->receiver));
    struct sis_told *told;
    uint8_t address;

    if (request == NULL || telegram->subaddress_count > 0 ||
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
    for (unsigned i = 0; i < array_length(names); i++) {
        uint32_t value = find_limit(limits->text, names[i].name);

        for (station_t *station = &told->all; station != NULL && value != 0; station = station->next) {
            sis_setting_t *valid = &station->valid.of[names[i].kind];

            if (valid->set_in == 0 || valid->is_by_user)
                *valid = (sis_setting_t){value, limits->told_in, limits->told_in, 0, true};
        }
    }
}

static const sis_settings_t *
make_settings(const station_t *station, const station_t *all)
{
    sis_settings_t *settings = wmem_new(wmem_file_scope(), sis_settings_t);

    *settings = station->valid;
    if (all->test.end != 0)
        settings->of[SIS_BAUD] = all->test.rate;
    if (station->test.end != 0)
        settings->of[SIS_BAUD] = station->test.rate;
    return settings;
}

static void
end_test(struct sis_told *told, test_t *test, int64_t now)
{
    if (test->end != 0 && now > test->end) {
        test->end = 0;
        forget_known(told);
    }
}

const sis_settings_t *
sis_bus_settings(const sis_bus_t *bus, uint8_t address, int64_t now)
{
    struct sis_told *told = bus->told;
    station_t *station;

    if (told == NULL)
        return NULL;
    station = find_station(told, address);
    end_test(told, &station->test, now);
    end_test(told, &told->all.test, now);
    if (station->known == NULL)
        station->known = make_settings(station, &told->all);
    return station->known;
}
