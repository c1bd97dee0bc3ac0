/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What is known of a service before its bytes are read. The texts are in protocol/codes.toml, the layouts in
 * protocol/services.toml. */
#include "sis/names.h"

#include "protocol/services.h"

/* ECODRIVE03 has no DISC: what follows is reserved there. */
#define FIRST_DISC    0xE0
#define LAST_RESERVED 0xFF

/* Between 0x10 and this one, what has no name is reserved. */
#define LAST_GENERAL 0x7F

static const range_string *
service_entry(uint8_t service)
{
    int at = 0;

    if (pref_sis_edition == SIS_EDITION_ECODRIVE03 && service >= FIRST_DISC)
        service = LAST_RESERVED;
    try_rval_to_str_idx(service, sis_services, &at); /* the ranges leave out no service */
    return &sis_services[at];
}

const char *
sis_service_range_name(uint8_t service)
{
    return service_entry(service)->strptr;
}

const char *
sis_service_name(wmem_allocator_t *scope, uint8_t service)
{
    const range_string *entry = service_entry(service);

    if (entry->value_min == entry->value_max)
        return entry->strptr;
    return wmem_strdup_printf(scope, "%s 0x%02x", entry->strptr, service);
}

const value_string *
sis_subservices_of(uint8_t service)
{
    return sis_services_known[service].subservices;
}

bool
sis_may_answer_subservice(uint8_t service, uint8_t asked, uint8_t answered)
{
    const value_string *defined = sis_subservices_of(service);

    return defined == NULL || asked == answered || try_val_to_str(answered, defined) == NULL;
}

bool
sis_service_is_reserved(uint8_t service)
{
    const range_string *range = service_entry(service);

    return range->value_min < range->value_max &&
           (range->value_max == LAST_GENERAL || range->value_max == LAST_RESERVED);
}

uint8_t
sis_general_service(uint8_t service)
{
    const sis_service_t *known = &sis_services_known[service];

    return known->like == 0 || (known->condition != NULL && !*known->condition) ? service : known->like;
}

bool
sis_has_status(uint8_t service)
{
    return sis_services_known[service].has_status || sis_general_service(service) != service;
}

bool
sis_has_control_byte(uint8_t service)
{
    return sis_services_known[sis_general_service(service)].has_control;
}
