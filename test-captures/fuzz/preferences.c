/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "preferences.h"

#include <glib.h>
#include <epan/prefs.h>

/* The first value is the plugin's own. */
static const struct {
    const char *module, *name, *values[4];
} table[] = {
    {"sis", "edition", {"IF02", "ECODRIVE03", "IF02", "ECODRIVE03"}},
    {"sis", "clc_as_sercos", {"FALSE", "TRUE", "FALSE", "TRUE"}},
    {"sis", "ecodrive_phases", {"FALSE", "TRUE", "FALSE", "TRUE"}},
    {"sis", "tza_ms", {"0", "3", "1", "4294967295"}},
    {"sis", "trs_ms", {"0", "30", "1", "4294967295"}},
    {"sis", "tcp_heuristic", {"TRUE", "FALSE", "TRUE", "FALSE"}},
    {"3964r", "zvz_ms", {"0", "220", "1", "4294967295"}},
    {"3964r", "qvz_ms", {"0", "2000", "1", "4294967295"}},
    {"synaxpk", "layout", {"synax", "indradrive", "synax", "indradrive"}},
    {"synaxpk", "direction", {"guess", "master", "slave", "guess"}},
    {"synaxpd", "swap_bytes", {"FALSE", "TRUE", "FALSE", "TRUE"}},
    {"synaxpd", "swap_words", {"FALSE", "FALSE", "TRUE", "TRUE"}},
};

static void
set(const char *module, const char *name, const char *value)
{
    char *setting = g_strdup_printf("%s.%s:%s", module, name, value), *error = NULL;

    if (prefs_set_pref(setting, &error) != PREFS_SET_OK)
        g_error("no such preference: %s", setting);
    g_free(setting);
}

void
preferences_set(uint32_t choice)
{
    static uint32_t now = 0;

    if (choice == now)
        return;
    now = choice;
    for (unsigned i = 0; i < G_N_ELEMENTS(table); i++)
        set(table[i].module, table[i].name, table[i].values[choice >> 2 * i & 3]);
    for (unsigned i = 0; i < G_N_ELEMENTS(table); i++)
        prefs_apply(prefs_find_module(table[i].module));
}
