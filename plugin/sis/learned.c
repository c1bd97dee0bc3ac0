/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus has said about the parameters of a telegram's station. Every command keeps what was known
 * when it was sent, so that all passes show the same. */

#include "sis/learned.h"

static sis_learned_t *
learned_of(const sis_exchange_t *exchange)
{
    sis_bus_t *bus = exchange->stream->bus;

    if (bus->learned == NULL)
        bus->learned = sis_learned_new();
    return bus->learned;
}

sis_place_t
sis_station_place(const sis_exchange_t *exchange, uint8_t device)
{
    sis_place_t place = {.path_length = exchange->path_length, .device = device};

    memcpy(place.path, exchange->path, sizeof place.path);
    return place;
}

static const sis_exchange_t *
exchange_of(const sis_body_t *body)
{
    return body->record != NULL ? body->record->exchange : NULL;
}

static const sis_known_t *
find(const sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_place_t place;

    if (exchange == NULL)
        return NULL;
    place = sis_station_place(exchange, device);
    return sis_learned_find(learned_of(exchange), &place, ident);
}

sis_known_t
sis_station_known(sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    const sis_known_t *said = body->asked != NULL ? body->asked->known : find(body, ident, device);

    if (body->request != NULL)
        body->request->known = said;
    return sis_learned_or_from_tables(said, ident);
}

void
sis_station_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element, tvbuff_t *tvb,
                  const char *shown)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_place_t place;

    if (body->pinfo->fd->visited || exchange == NULL)
        return;
    place = sis_station_place(exchange, device);
    sis_learned_add(learned_of(exchange), body->pinfo->pool, &place, ident, element, tvb, shown);
}
