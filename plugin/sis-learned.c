/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus itself has said of its parameters. It is learned in the first pass; every command keeps what
 * was known when it was sent, so that all passes show the same. */

#include "sis-learned.h"

#include "sis-exchange.h"
#include "sis-values.h"

/* A parameter of a device behind a station, which may be behind routers. */
typedef struct {
    uint8_t path[8];
    uint8_t path_length; /* 3 is not 3/0 */
    uint8_t device;
    uint8_t type;
    uint8_t zero;
    uint16_t number;
} learned_key_t;

_Static_assert(sizeof(learned_key_t) == 8 + 4 + 2, "the key is hashed byte by byte, so it has no gaps");

static unsigned
hash_key(const void *key)
{
    return wmem_strong_hash(key, sizeof(learned_key_t));
}

static gboolean
are_keys_equal(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(learned_key_t)) == 0;
}

wmem_map_t *
sis_learned_new(void)
{
    return wmem_map_new(wmem_file_scope(), hash_key, are_keys_equal);
}

static learned_key_t
make_key(const sis_exchange_t *exchange, sis_ident_t ident, uint8_t device)
{
    learned_key_t key = {0};

    memcpy(key.path, exchange->path, sizeof key.path);
    key.path_length = exchange->path_length;
    key.device = device;
    key.type = ident.type;
    key.number = ident.number;
    return key;
}

static const sis_known_t *
look_up(const sis_body_t *body, sis_ident_t ident, uint8_t device)
{
    const sis_exchange_t *exchange = body->record != NULL ? body->record->exchange : NULL;
    learned_key_t key;

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
    known.minimum = learned->minimum;
    known.maximum = learned->maximum;
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

/* True if this is another text than before; then it is kept. */
static bool
update_text(const char **known, const char *text)
{
    if (text == NULL || g_strcmp0(*known, text) == 0)
        return false;
    *known = wmem_strdup(wmem_file_scope(), text);
    return true;
}

static bool
update_attribute(sis_known_t *known, tvbuff_t *tvb)
{
    uint32_t attribute;

    if (tvb_captured_length(tvb) != 4)
        return false;
    attribute = tvb_get_letohl(tvb, 0);
    if (known->attribute_from == SIS_FROM_BUS && known->attribute == attribute)
        return false;
    known->attribute = attribute;
    known->attribute_from = SIS_FROM_BUS;
    return true;
}

/* True if this says something new. */
static bool
update(sis_known_t *known, wmem_allocator_t *pool, sis_element_t element, tvbuff_t *tvb, const char *shown)
{
    const char *name;

    switch (element) {
    case SIS_ELEMENT_NAME:
        name = sis_element_text(pool, tvb);
        if (name[0] == '\0') /* no name at all; an empty unit says that there is none */
            return false;
        known->name_from = SIS_FROM_BUS;
        return update_text(&known->name, name);
    case SIS_ELEMENT_UNIT:
        known->unit_from = SIS_FROM_BUS;
        return update_text(&known->unit, sis_element_text(pool, tvb));
    case SIS_ELEMENT_ATTRIBUTE:
        return update_attribute(known, tvb);
    case SIS_ELEMENT_MINIMUM:
        return update_text(&known->minimum, shown);
    case SIS_ELEMENT_MAXIMUM:
        return update_text(&known->maximum, shown);
    default:
        return false;
    }
}

void
sis_learn(sis_body_t *body, sis_ident_t ident, uint8_t device, sis_element_t element, tvbuff_t *tvb,
          const char *shown)
{
    const sis_exchange_t *exchange = body->record != NULL ? body->record->exchange : NULL;
    const sis_known_t *before = look_up(body, ident, device);
    sis_known_t known = {0};
    learned_key_t key;

    if (body->pinfo->fd->visited || exchange == NULL)
        return;
    if (before != NULL)
        known = *before;
    if (!update(&known, body->pinfo->pool, element, tvb, shown))
        return;
    key = make_key(exchange, ident, device);
    wmem_map_insert(exchange->stream->bus->learned, wmem_memdup(wmem_file_scope(), &key, sizeof key),
                    wmem_memdup(wmem_file_scope(), &known, sizeof known));
}
