/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus has said about the parameters of a telegram's station. Every command keeps what was known
 * when it was sent, so that all passes show the same. */
#include "sis/station.h"

sis_learned_t *
sis_learned_of(sis_bus_t *bus)
{
    if (bus->learned == NULL)
        bus->learned = sis_learned_new();
    return bus->learned;
}

static const sis_exchange_t *
exchange_of(const sis_body_t *body)
{
    return body->record != NULL ? body->record->exchange : NULL;
}

/* What was learned on the bus of an exchange. */
static sis_learned_t *
learned_by(const sis_exchange_t *exchange)
{
    return sis_learned_of(exchange->stream->bus);
}

sis_place_t
sis_station_of(const sis_body_t *body, uint8_t device)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_place_t place = {.device = device};

    if (exchange == NULL)
        return (sis_place_t){0};
    place.path_length = exchange->path_length;
    memcpy(place.path, exchange->path, sizeof place.path);
    return place;
}

/* First pass: what is known when a command is sent. */
static void
look_up(sis_request_t *request, const sis_exchange_t *exchange, const sis_place_t *place, sis_ident_t ident)
{
    sis_learned_t *learned = learned_by(exchange);
    sis_twin_t twin = sis_learned_twin(learned, place, ident);

    request->known = sis_learned_find(learned, place, ident);
    request->twin = twin.known != NULL ? wmem_memdup(wmem_file_scope(), &twin, sizeof twin) : NULL;
}

sis_known_t
sis_station_known(sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_place_t place = sis_station_of(body, device);
    sis_request_t found = {0};
    const sis_request_t *request = body->asked != NULL ? body->asked : &found;

    if (body->asked == NULL && exchange != NULL)
        look_up(&found, exchange, &place, ident);
    if (body->request != NULL) {
        body->request->known = request->known;
        body->request->twin = request->twin;
    }
    return sis_learned_or_from_tables(request->known, request->twin, &place, ident);
}

void
sis_station_complete(const sis_body_t *body, sis_known_t *known)
{
    sis_place_t place = sis_station_of(body, body->asked->device);

    sis_learned_complete(body->pinfo, learned_by(body->record->exchange), &place, body->asked->ident, known);
}

void
sis_station_identify(const sis_body_t *body, sis_identity_t what)
{
    sis_place_t place;

    if (body->asked == NULL || body->is_cut || body->text == NULL)
        return;
    place = sis_station_of(body, body->asked->device);
    sis_learned_identity(learned_by(body->record->exchange), &place, what, body->text);
}

void
sis_station_learn(sis_body_t *body)
{
    const sis_request_t *asked = body->asked;
    sis_place_t place = sis_station_of(body, asked->device);
    sis_fact_t fact;

    if (sis_fact_read(&fact, body->pinfo->pool, (sis_element_t)asked->element, body->data, body->text))
        sis_learned_add(learned_by(body->record->exchange), &place, asked->ident, &fact);
}
