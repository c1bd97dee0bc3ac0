/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus said about parameters: names, units, attributes, limits. */

#include "parameters/learned.h"

#include "parameters/values.h"

/* A parameter of a device. */
typedef struct {
    sis_place_t place;
    uint8_t type;
    uint8_t zero;
    uint16_t number;
} learned_key_t;

_Static_assert(sizeof(learned_key_t) == 8 + 2 + 2 + 2, "the key is hashed byte by byte, so it has no gaps");

struct sis_learned {
    wmem_map_t *known; /* by learned_key_t */
};

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

sis_learned_t *
sis_learned_new(void)
{
    sis_learned_t *learned = wmem_new(wmem_file_scope(), sis_learned_t);

    learned->known = wmem_map_new(wmem_file_scope(), hash_key, are_keys_equal);
    return learned;
}

static learned_key_t
make_key(const sis_place_t *place, sis_ident_t ident)
{
    return (learned_key_t){.place = *place, .type = ident.type, .number = ident.number};
}

const sis_known_t *
sis_learned_find(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident)
{
    learned_key_t key = make_key(place, ident);

    return wmem_map_lookup(learned->known, &key);
}

sis_known_t
sis_learned_or_from_tables(const sis_known_t *said, sis_ident_t ident)
{
    sis_known_t known = sis_known_from_tables(ident);

    if (said == NULL)
        return known;
    known.minimum = said->minimum;
    known.maximum = said->maximum;
    if (said->name_from != SIS_FROM_NOWHERE) {
        known.name = said->name;
        known.name_from = said->name_from;
    }
    if (said->unit_from != SIS_FROM_NOWHERE) {
        known.unit = said->unit;
        known.unit_from = said->unit_from;
    }
    if (said->attribute_from != SIS_FROM_NOWHERE) {
        known.attribute = said->attribute;
        known.attribute_from = said->attribute_from;
    }
    return known;
}

/* True if the text differs from the one before; then it is kept. */
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
sis_learned_add(sis_learned_t *learned, wmem_allocator_t *pool, const sis_place_t *place, sis_ident_t ident,
                sis_element_t element, tvbuff_t *tvb, const char *shown)
{
    learned_key_t key = make_key(place, ident);
    const sis_known_t *before = wmem_map_lookup(learned->known, &key);
    sis_known_t known = {0};

    if (before != NULL)
        known = *before;
    if (update(&known, pool, element, tvb, shown))
        wmem_map_insert(learned->known, wmem_memdup(wmem_file_scope(), &key, sizeof key),
                        wmem_memdup(wmem_file_scope(), &known, sizeof known));
}
