/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the bus said about parameters: names, units, attributes, limits. */
#include "parameters/learned.h"

#include "kept.h"
#include "parameters/values.h"
#include "protocol/limits.h"

KEPT_KEY(sis_parameter_t, 8 + 2 + 2 + 2 + 2)
KEPT_KEY(sis_place_t, 8 + 1 + 1)

/* Devices of one type. */
typedef struct {
    const sis_place_t *places[SIS_MOST_TWINS];
    unsigned count;
} type_t;

/* The types of a device; NULL: not told. */
typedef struct {
    sis_place_t place;
    type_t *types[SIS_IDENTITIES];
} device_t;

struct sis_learned {
    wmem_map_t *known;                 /* by sis_parameter_t */
    wmem_map_t *devices;               /* device_t by sis_place_t */
    wmem_map_t *types[SIS_IDENTITIES]; /* type_t by text */
};

sis_learned_t *
sis_learned_new(void)
{
    sis_learned_t *learned = wmem_new(wmem_file_scope(), sis_learned_t);

    learned->known = wmem_map_new(wmem_file_scope(), hash_sis_parameter_t, are_equal_sis_parameter_t);
    learned->devices = wmem_map_new(wmem_file_scope(), hash_sis_place_t, are_equal_sis_place_t);
    for (unsigned i = 0; i < SIS_IDENTITIES; i++)
        learned->types[i] = wmem_map_new(wmem_file_scope(), wmem_str_hash, g_str_equal);
    return learned;
}

const sis_known_t *
sis_learned_find(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident)
{
    sis_parameter_t key = {*place, ident};

    return wmem_map_lookup(learned->known, &key);
}

static type_t *
type_of(wmem_map_t *types, const char *text)
{
    type_t *type = wmem_map_lookup(types, text);

    if (type == NULL) {
        type = wmem_new0(wmem_file_scope(), type_t);
        wmem_map_insert(types, wmem_strdup(wmem_file_scope(), text), type);
    }
    return type;
}

void
sis_learned_identity(sis_learned_t *learned, const sis_place_t *place, sis_identity_t what, const char *text)
{
    device_t *device = kept_value(learned->devices, place, sizeof *place, sizeof *device);
    type_t *type = type_of(learned->types[what], text);

    if (device->types[what] == type)
        return;
    device->types[what] = type;
    if (type->count < SIS_MOST_TWINS)
        type->places[type->count++] = wmem_memdup(wmem_file_scope(), place, sizeof *place);
}

sis_twin_t
sis_learned_twin(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident)
{
    const device_t *device = wmem_map_lookup(learned->devices, place), *other;

    for (unsigned what = 0; device != NULL && what < SIS_IDENTITIES; what++) {
        const type_t *type = device->types[what];

        for (unsigned i = 0; type != NULL && i < type->count; i++) {
            const sis_known_t *known = sis_learned_find(learned, type->places[i], ident);

            other = wmem_map_lookup(learned->devices, type->places[i]);
            if (known != NULL && other->types[what] == type && !are_equal_sis_place_t(place, type->places[i]))
                return (sis_twin_t){known, type->places[i]};
        }
    }
    return (sis_twin_t){NULL, NULL};
}

/* Takes over a text that is there. The user's table goes before a twin. */
static void
take_over(const char **text, sis_source_t *from, const char *other, sis_source_t other_from)
{
    if (other == NULL || (other_from == SIS_FROM_TWIN && *from == SIS_FROM_TABLE))
        return;
    *text = other;
    *from = other_from;
}

static void
take_over_all(sis_known_t *known, const sis_known_t *other, sis_source_t from)
{
    take_over(&known->name, &known->name_from, other->name, from);
    take_over(&known->unit, &known->unit_from, other->unit, from);
    take_over(&known->minimum, &known->minimum_from, other->minimum, from);
    take_over(&known->maximum, &known->maximum_from, other->maximum, from);
    if (other->attribute_from == SIS_FROM_NOWHERE ||
        (from == SIS_FROM_TWIN && known->attribute_from == SIS_FROM_TABLE))
        return;
    known->attribute = other->attribute;
    known->attribute_from = from;
}

sis_known_t
sis_learned_or_from_tables(const sis_known_t *said, const sis_twin_t *twin, const sis_place_t *place,
                           sis_ident_t ident)
{
    sis_known_t known = sis_known_from_tables(place, ident);

    if (twin != NULL && twin->known != NULL) {
        known.twin = twin->place;
        take_over_all(&known, twin->known, SIS_FROM_TWIN);
    }
    if (said != NULL)
        take_over_all(&known, said, SIS_FROM_BUS);
    return known;
}

bool
sis_fact_read(sis_fact_t *fact, wmem_allocator_t *pool, sis_element_t element, tvbuff_t *tvb,
              const char *shown)
{
    *fact = (sis_fact_t){.element = element};
    switch (element) {
    case SIS_ELEMENT_NAME:
        fact->text = sis_element_text(pool, tvb);
        return fact->text[0] != '\0'; /* no name at all; an empty unit says that there is none */
    case SIS_ELEMENT_UNIT:
        fact->text = sis_element_text(pool, tvb);
        return true;
    case SIS_ELEMENT_ATTRIBUTE:
        if (tvb_captured_length(tvb) != 4)
            return false;
        fact->attribute = tvb_get_letohl(tvb, 0);
        return true;
    case SIS_ELEMENT_MINIMUM:
    case SIS_ELEMENT_MAXIMUM:
        fact->text = shown;
        return shown != NULL;
    default:
        return false;
    }
}

/* True if the text differs from the one before; then it is kept. */
static bool
update_text(const char **known, const char *text)
{
    if (g_strcmp0(*known, text) == 0)
        return false;
    *known = wmem_strdup(wmem_file_scope(), text);
    return true;
}

static bool
update_attribute(sis_known_t *known, uint32_t attribute)
{
    if (known->attribute_from == SIS_FROM_BUS && known->attribute == attribute)
        return false;
    if (known->attribute_from == SIS_FROM_NOWHERE)
        known->first_attribute = attribute;
    known->attribute = attribute;
    known->attribute_from = SIS_FROM_BUS;
    return true;
}

/* True if this says something new. */
static bool
update(sis_known_t *known, const sis_fact_t *fact)
{
    switch (fact->element) {
    case SIS_ELEMENT_NAME:
        known->name_from = SIS_FROM_BUS;
        return update_text(&known->name, fact->text);
    case SIS_ELEMENT_UNIT:
        known->unit_from = SIS_FROM_BUS;
        return update_text(&known->unit, fact->text);
    case SIS_ELEMENT_ATTRIBUTE:
        return update_attribute(known, fact->attribute);
    case SIS_ELEMENT_MINIMUM:
        known->minimum_from = SIS_FROM_BUS;
        return update_text(&known->minimum, fact->text);
    case SIS_ELEMENT_MAXIMUM:
        known->maximum_from = SIS_FROM_BUS;
        return update_text(&known->maximum, fact->text);
    default:
        return false;
    }
}

void
sis_learned_add(sis_learned_t *learned, const sis_place_t *place, sis_ident_t ident, const sis_fact_t *fact)
{
    sis_parameter_t key = {*place, ident};
    const sis_known_t *before = wmem_map_lookup(learned->known, &key);
    sis_known_t known = {0};

    if (before != NULL)
        known = *before;
    if (update(&known, fact))
        wmem_map_insert(learned->known, wmem_memdup(wmem_file_scope(), &key, sizeof key),
                        wmem_memdup(wmem_file_scope(), &known, sizeof known));
}

void
sis_learned_complete(const packet_info *pinfo, sis_learned_t *learned, const sis_place_t *place,
                     sis_ident_t ident, sis_known_t *known)
{
    const sis_known_t *later = pinfo->fd->visited ? sis_learned_find(learned, place, ident) : NULL;

    if (later == NULL)
        return;
    if (known->attribute_from == SIS_FROM_NOWHERE) {
        known->attribute = later->first_attribute;
        known->attribute_from = later->attribute_from;
    }
    if (known->name_from == SIS_FROM_NOWHERE) {
        known->name = later->name;
        known->name_from = later->name_from;
    }
    if (known->unit_from == SIS_FROM_NOWHERE) {
        known->unit = later->unit;
        known->unit_from = later->unit_from;
    }
}
