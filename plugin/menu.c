/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The submenu *Statistics > SIS*: each entry opens the window of `wireshark -z NAME`. Two statistics are not
 * here: Wireshark cannot open a tree of counts by its name, but puts it into the same submenu (4.4 on). */
#include "parts.h"

#include <epan/plugin_if.h>
#include <epan/stat_tap_ui.h>

#include "protocol/fields.h"

static const struct {
    const char *title, *name;
} entries[] = {
    {"SIS bus by station", "sis,bus"},
    {"SIS intervals by talker (TzA)", "sis,tza"},
    {"SIS parameters", "sis,parameters"},
    {"SIS service response time", "sis,srt"},
    {"RK512I service response time", "rk512i,srt"},
    {"SISASCII service response time", "sisascii,srt"},
};

static void
open_window(ext_menubar_gui_type gui _U_, void *object _U_, void *name)
{
    if (process_stat_cmd_arg(name))
        start_requested_stats();
}

void
menu_register(void)
{
    ext_menu_t *menu =
        ext_menubar_set_parentmenu(ext_menubar_register_menu(proto_sis, "SIS", TRUE), "Statistics");

    for (unsigned i = 0; i < array_length(entries); i++)
        ext_menubar_add_entry(menu, entries[i].title, entries[i].title, open_window, (char *)entries[i].name);
}
