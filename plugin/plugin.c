/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What Wireshark looks for in a plugin. */

#include "compat.h"

#include <epan/proto.h>
#include <ws_symbol_export.h>

void proto_register_sertap(void);
void proto_reg_handoff_sertap(void);
void proto_register_sis(void);
void proto_reg_handoff_sis(void);
void proto_register_synax(void);
void proto_reg_handoff_synax(void);

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
    static proto_plugin sertap = {.register_protoinfo = proto_register_sertap,
                                  .register_handoff = proto_reg_handoff_sertap};
    static proto_plugin sis = {.register_protoinfo = proto_register_sis,
                               .register_handoff = proto_reg_handoff_sis};
    static proto_plugin synax = {.register_protoinfo = proto_register_synax,
                                 .register_handoff = proto_reg_handoff_synax};

    proto_register_plugin(&sertap);
    proto_register_plugin(&sis);
    proto_register_plugin(&synax);
}
