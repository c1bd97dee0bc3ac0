/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Station addresses: their kinds in the two editions (fig. 2-9; ECODRIVE03 fig. 1-7), and Wireshark's address
 * type. */
#include "sis/address.h"

#include <epan/address_types.h>

#include "parts.h"

typedef struct {
    uint8_t last; /* the entry covers the addresses after the one before it, up to this one */
    sis_address_kind_t kind;
} address_kind_t;

static const address_kind_t receivers_if02[] = {
    {126, SIS_STATION}, {127, SIS_NOT_ASSIGNED},    {128, SIS_POINT_TO_POINT},   {199, SIS_RESERVED},
    {253, SIS_GROUP},   {254, SIS_LEVEL_BROADCAST}, {255, SIS_GLOBAL_BROADCAST},
};

static const address_kind_t receivers_ecodrive03[] = {
    {127, SIS_STATION},
    {254, SIS_GROUP},
    {255, SIS_GLOBAL_BROADCAST},
};

static const address_kind_t senders_if02[] = {
    {126, SIS_STATION},
    {127, SIS_SERVICE_MASTER},
    {255, SIS_NO_SENDER},
};

static const address_kind_t senders_ecodrive03[] = {
    {127, SIS_STATION},
    {255, SIS_NO_SENDER},
};

static const struct {
    const address_kind_t *receivers, *senders;
} editions[] = {
    [SIS_EDITION_IF02] = {receivers_if02, senders_if02},
    [SIS_EDITION_ECODRIVE03] = {receivers_ecodrive03, senders_ecodrive03},
};

static int station_type = -1;
static uint8_t stations[256];    /* each at its own index: an address points to one */
static const char *numbers[256]; /* as text */

/* Every table ends at 255, so the search ends, too. */
static sis_address_kind_t
kind_of(const address_kind_t *table, uint8_t address)
{
    while (address > table->last)
        table++;
    return table->kind;
}

sis_address_kind_t
sis_receiver_kind(uint8_t receiver)
{
    return kind_of(editions[pref_sis_edition].receivers, receiver);
}

sis_address_kind_t
sis_sender_kind(uint8_t sender)
{
    return kind_of(editions[pref_sis_edition].senders, sender);
}

bool
sis_is_answered(uint8_t receiver)
{
    return sis_receiver_kind(receiver) < SIS_GROUP;
}

const char *
sis_number_text(uint8_t station)
{
    return numbers[station];
}

/* The number stands in all columns and statistics, and filters need it; the word says whose it is. */
const char *
sis_station_text(wmem_allocator_t *scope, uint8_t station)
{
    static const char *const words[] = {
        [SIS_POINT_TO_POINT] = "point-to-point",
        [SIS_GROUP] = "group",
        [SIS_LEVEL_BROADCAST] = "all on this level",
        [SIS_GLOBAL_BROADCAST] = "all",
    };
    sis_address_kind_t kind = sis_receiver_kind(station);

    if (kind >= array_length(words) || words[kind] == NULL)
        return numbers[station];
    return wmem_strconcat(scope, numbers[station], " (", words[kind], ")", NULL);
}

#define ADDRESS_TEXT_SIZE 4 /* "255" */

/* AddrValueToString: numbers only, because filters are made of this text. The returned length includes the
 * end of the string. */
static int
address_to_text(const address *addr, char *buffer, int size)
{
    return (int)g_strlcpy(buffer, numbers[*(const uint8_t *)addr->data], size) + 1;
}

static int
address_text_length(const address *addr _U_)
{
    return ADDRESS_TEXT_SIZE;
}

static int
address_length(void)
{
    return 1;
}

/* The field for "Apply as Filter" on the column. */
static const char *
address_filter(const address *addr _U_, compat_bool is_source)
{
    return is_source ? "sis.talker" : "sis.listener";
}

/* A TCP segment keeps its IP addresses: TCP's reassembly needs them to find the stream. */
void
sis_set_addresses(packet_info *pinfo, uint8_t talker, uint8_t listener)
{
    if (pinfo->net_src.type != AT_NONE)
        return;

    set_address(&pinfo->net_src, station_type, 1, &stations[talker]);
    set_address(&pinfo->net_dst, station_type, 1, &stations[listener]);
    copy_address_shallow(&pinfo->src, &pinfo->net_src);
    copy_address_shallow(&pinfo->dst, &pinfo->net_dst);
}

void
sis_address_register(void)
{
    for (unsigned i = 0; i < array_length(numbers); i++) {
        stations[i] = (uint8_t)i;
        numbers[i] = wmem_strdup_printf(wmem_epan_scope(), "%u", i);
    }
    station_type =
        address_type_dissector_register("AT_SIS", "SIS station", address_to_text, address_text_length, NULL,
                                        address_filter, address_length, NULL, NULL);
}
