/* SPDX-License-Identifier: GPL-2.0-or-later */
/* All protocols and what belongs to them: the only file that knows all others. Wireshark's make-plugin-reg.py
 * finds the first two functions by their names; the end of the file is what Wireshark looks for in a plugin.
 */

#include "parts.h"
#include "protocol/fields.h"

#include <ws_symbol_export.h>

void proto_register_sis(void);
void proto_reg_handoff_sis(void);

void
proto_register_sis(void)
{
    protocol_register();
    sertap_register();
    sertap_line_register();
    sis_address_register();
    sis_asked_register();
    sis_parameters_register();
    sis_packet_register();
    sis_routes_register();
    sis_told_register();
    sis_exchange_register();
    sis_pieces_register();
    sis_export_register();
    synax_arcnet7f_register();
    synax_synaxpk_register();
    rk512i_register();
    rk512_3964r_register();
    synax_synaxpcp_register();
    synax_synaxpd_register();
    sisascii_register();
    sisascii_dialogue_register();
    windows_characters_register();
    windows_export_register();
    windows_filters_register();
    windows_response_times_register();
    windows_rows_register();
    windows_stations_register();
    windows_telegrams_register();
}

void
proto_reg_handoff_sis(void)
{
    sertap_handoff();
    sis_packet_handoff();
    sis_transports_handoff();
    rk512_3964r_handoff();
    synax_arcnet7f_handoff();
    synax_synaxpk_handoff();
    synax_synaxobj_handoff();
    synax_synaxpd_handoff();
    sisascii_handoff();
}

WS_DLL_PUBLIC_DEF const char plugin_version[] = PLUGIN_VERSION;
WS_DLL_PUBLIC_DEF const int plugin_want_major = WIRESHARK_VERSION_MAJOR;
WS_DLL_PUBLIC_DEF const int plugin_want_minor = WIRESHARK_VERSION_MINOR;

WS_DLL_PUBLIC void plugin_register(void);
#ifdef COMPAT_PLUGIN_DESCRIBE
WS_DLL_PUBLIC uint32_t plugin_describe(void);

uint32_t
plugin_describe(void)
{
    return WS_PLUGIN_DESC_DISSECTOR;
}
#endif

void
plugin_register(void)
{
    static proto_plugin sis = {.register_protoinfo = proto_register_sis,
                               .register_handoff = proto_reg_handoff_sis};

    proto_register_plugin(&sis);
}
