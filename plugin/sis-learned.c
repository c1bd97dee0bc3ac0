/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus itself has said of its parameters. It is learned in the first pass; every command keeps what
 * was known when it was sent, so that all passes show the same. */

#include "sis-learned.h"

#include "sis-exchange.h"
#include "sis-values.h"

/* Station, device and parameter. */
static uint64_t
make_key(const sis_exchange_t *exchange, sis_ident_t ident, uint8_t device)
{
    return (uint64_t)exchange->station << 32 | (uint64_t)device << 24 | (uint64_t)ident.type << 16 |
           ident.number;
}

static const sis_known_t *
look_up(const sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    const sis_exchange_t *exchange = body->record != NULL ? body->record->exchange : NULL;
    uint64_t key;

    if (exchange == NULL)
        return NULL;
    key = make_key(exchange, ident, device);
    return wmem_map_lookup(exchange->stream->bus->learned, &key);
}

sis_known_t
sis_learned_known(sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    sis_known_t known = sis_known_from_tables(ident);
    const sis_known_t *learned = body->asked != NULL ? body->asked->known : look_up(body, ident, device);

    if (body->request != NULL)
        body->request->known = learned;
    if (learned == NULL)
        return known;
    if (learned->name_from != SIS_FROM_NOWHERE) {
        known.name = learned->name;
        known.name_from = learned->name_from;
    }
    if (learned->unit_from != SIS_FROM_NOWHERE) {
        known.unit = learned->unit;
        known.unit_from = learned->unit_from;
    }
    if (learned->attribute_from != SIS_FROM_NOWHERE) {
        known.attribute = learned->attribute;
        known.attribute_from = learned->attribute_from;
    }
    return known;
}

/* True if this says something new. */
static bool
update(sis_known_t *known, sis_element_t element, tvbuff_t *tvb)
{
    const char *text = sis_element_text(wmem_file_scope(), tvb);

    if (element == SIS_ELEMENT_NAME && g_strcmp0(known->name, text) != 0) {
        known->name = text;
        known->name_from = SIS_FROM_BUS;
        return true;
    }
    if (element == SIS_ELEMENT_UNIT && g_strcmp0(known->unit, text) != 0) {
        known->unit = text;
        known->unit_from = SIS_FROM_BUS;
        return true;
    }
    if (element == SIS_ELEMENT_ATTRIBUTE && tvb_captured_length(tvb) == 4) {
        uint32_t attribute = tvb_get_letohl(tvb, 0);
        bool is_new = known->attribute_from == SIS_FROM_NOWHERE || known->attribute != attribute;

        known->attribute = attribute;
        known->attribute_from = SIS_FROM_BUS;
        return is_new;
    }
    return false;
}

void
sis_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element, tvbuff_t *tvb)
{
    bool is_description =
        element == SIS_ELEMENT_NAME || element == SIS_ELEMENT_UNIT || element == SIS_ELEMENT_ATTRIBUTE;
    const sis_known_t *before = look_up(body, ident, device);
    sis_known_t known = {0};
    const sis_exchange_t *exchange;
    uint64_t *key;

    if (!is_description || body->pinfo->fd->visited || body->record == NULL || body->record->exchange == NULL)
        return;
    if (before != NULL)
        known = *before;
    if (!update(&known, element, tvb))
        return;
    exchange = body->record->exchange;
    key = wmem_new(wmem_file_scope(), uint64_t);
    *key = make_key(exchange, ident, device);
    wmem_map_insert(exchange->stream->bus->learned, key,
                    wmem_memdup(wmem_file_scope(), &known, sizeof known));
}
