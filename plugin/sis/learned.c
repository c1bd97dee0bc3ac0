/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus has said about the parameters of a telegram's station. Every command keeps what was known
 * when it was sent, so that all passes show the same. */
#include "sis/learned.h"

#include "parameters/text.h"

sis_learned_t *
sis_learned_of(sis_bus_t *bus)
{
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

sis_place_t
sis_station_of(const sis_body_t *body, uint8_t device)
{
    const sis_exchange_t *exchange = exchange_of(body);

    return exchange != NULL ? sis_station_place(exchange, device) : (sis_place_t){0};
}

/* First pass: what is known when a command is sent. */
static void
look_up(sis_request_t *request, const sis_exchange_t *exchange, const sis_place_t *place, sis_ident_t ident)
{
    sis_learned_t *learned = sis_learned_of(exchange->stream->bus);
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
sis_station_identify(const sis_body_t *body, sis_identity_t what, tvbuff_t *tvb)
{
    const sis_exchange_t *exchange = exchange_of(body);
    unsigned length = tvb_captured_length(tvb);
    sis_place_t place;

    if (body->pinfo->fd->visited || exchange == NULL || body->asked == NULL || body->is_cut || length == 0)
        return;
    place = sis_station_place(exchange, body->asked->device);
    sis_learned_identity(sis_learned_of(exchange->stream->bus), &place, what,
                         sis_text(body->pinfo->pool, tvb, 0, length));
}

void
sis_station_complete(const sis_body_t *body, sis_ident_t ident, uint8_t device, sis_known_t *known)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_place_t place;

    if (!body->pinfo->fd->visited || exchange == NULL)
        return;
    place = sis_station_place(exchange, device);
    sis_learned_complete(sis_learned_of(exchange->stream->bus), &place, ident, known);
}

void
sis_station_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element, tvbuff_t *tvb,
                  const char *shown)
{
    const sis_exchange_t *exchange = exchange_of(body);
    sis_fact_t fact;
    sis_place_t place;

    if (body->pinfo->fd->visited || exchange == NULL ||
        !sis_fact_read(&fact, body->pinfo->pool, element, tvb, shown))
        return;
    place = sis_station_place(exchange, device);
    sis_learned_add(sis_learned_of(exchange->stream->bus), &place, ident, &fact);
}
