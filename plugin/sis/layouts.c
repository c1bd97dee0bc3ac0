/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Which services have the same layout (chapters 2.1 and 8). */

#include "sis/layouts.h"

/* Preferences. */
static compat_bool clc_as_sercos = false;
static compat_bool ecodrive_phases = false;

/* Product groups have services of their own in the layout of 0x1x (chapter 8). Those of the CLC are
 * documented only as similar; the phase services of ECODRIVE were never seen. */
uint8_t
sis_general_service(uint8_t service)
{
    uint8_t low = service & 0x0F, group = service & 0xF0;
    bool is_phase = low == 0x2 || low == 0xD, is_parameter = low <= 0x1 || low >= 0xE;

    if ((group == 0x80 && (is_parameter || (is_phase && ecodrive_phases))) ||
        (group == 0x90 && (is_parameter || is_phase)) ||
        (group == 0xC0 && (is_parameter || is_phase) && clc_as_sercos))
        return 0x10 | low;
    return service;
}

/* The other product groups need no status (chapter 2.1), and their bodies are not documented. */
bool
sis_has_status(uint8_t service)
{
    return service <= 0x1F || (service >= 0x80 && service <= 0x9F) || sis_general_service(service) != service;
}

bool
sis_has_control_byte(uint8_t service)
{
    uint8_t general = sis_general_service(service);

    return general == 0x10 || general == 0x11 || general == 0x1E || general == 0x1F;
}

void
sis_layouts_register(module_t *module)
{
    prefs_register_bool_preference(
        module, "clc_as_sercos", "Decode services 0xC0 to 0xCF like 0x10 to 0x1F",
        "The CLC's services are said to be close to the SERCOS services; their layout is "
        "not documented",
        &clc_as_sercos);
    prefs_register_bool_preference(
        module, "ecodrive_phases", "Decode services 0x82 and 0x8D like 0x12 and 0x1D",
        "Reading and switching the phase of an ECODRIVE this way is not confirmed", &ecodrive_phases);
}
