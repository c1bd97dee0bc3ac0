/* SPDX-License-Identifier: GPL-2.0-or-later */
/* All protocols and what belongs to them: the only file that knows all others. Wireshark's make-plugin-reg.py
 * finds these functions by their names. */

#include "parameters/fields.h"
#include "parameters/ident.h"
#include "parameters/parameters.h"
#include "parameters/values.h"
#include "sertap/line.h"
#include "sertap/packet-sertap.h"
#include "sertap/statistics.h"
#include "sis/access-table.h"
#include "sis/access.h"
#include "sis/address.h"
#include "sis/dispatch.h"
#include "sis/export.h"
#include "sis/follow.h"
#include "sis/layouts.h"
#include "sis/packet-sis.h"
#include "sis/sequence.h"
#include "sis/services/services.h"
#include "sis/statistics.h"
#include "sis/tables.h"
#include "sis/timing.h"
#include "sis/transports.h"
#include "synax/3964r.h"
#include "synax/arcnet7f.h"
#include "synax/fields.h"
#include "synax/head.h"
#include "synax/pieces.h"
#include "synax/rk512i.h"
#include "synax/statistics.h"
#include "synax/synaxobj.h"
#include "synax/synaxpcp.h"
#include "synax/synaxpd.h"
#include "synax/synaxpk.h"

void proto_register_sertap(void);
void proto_reg_handoff_sertap(void);
void proto_register_sis(void);
void proto_reg_handoff_sis(void);
void proto_register_synax(void);
void proto_reg_handoff_synax(void);

void
proto_register_sertap(void)
{
    sertap_register();
    sertap_line_register();
    sertap_statistics_register();
}

void
proto_reg_handoff_sertap(void)
{
    sertap_handoff();
}

/* Services in the order of the specification. */
static void
register_services(void)
{
    sis_identification_register();
    sis_cancel_register();
    sis_flash_register();
    sis_initialization_register();
    sis_parameter_register();
    sis_phase_register();
}

/* In the order of the preferences in their dialog. */
static void
register_preferences(module_t *module)
{
    sis_packet_register(module);
    sis_layouts_register(module);
    sis_parameters_register(module);
    sis_timing_register(module);
    sis_transports_register(module);
}

void
proto_register_sis(void)
{
    sis_fields_register(); /* the protocol: before all others */
    sis_parameter_fields_register();
    sis_ident_register();
    sis_values_register();
    sis_address_register();
    register_preferences(prefs_register_protocol(proto_sis, NULL));
    register_services();
    sis_dispatch_register();
    sis_routes_register();
    sis_exchange_register();
    sis_sequence_register();
    sis_access_register();
    sis_export_register();
    sis_statistics_register();
    sis_tables_register();
    sis_access_table_register();
    sis_follow_register();
}

void
proto_reg_handoff_sis(void)
{
    sis_packet_handoff();
    sis_transports_handoff();
}

void
proto_register_synax(void)
{
    synax_fields_register(); /* before all others */
    synax_head_register();
    synax_pieces_register();
    synax_arcnet7f_register();
    synax_synaxpk_register();
    synax_rk512i_register();
    synax_3964r_register();
    synax_statistics_register();
    synaxobj_register();
    synaxpcp_register();
    synaxpd_register();
}

void
proto_reg_handoff_synax(void)
{
    synax_3964r_handoff();
    synax_arcnet7f_handoff();
    synax_synaxpk_handoff();
    synaxobj_handoff();
    synaxpd_handoff();
}
