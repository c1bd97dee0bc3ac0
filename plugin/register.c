/* SPDX-License-Identifier: GPL-2.0-or-later */
/* All protocols and what belongs to them: the only file that knows all others. Wireshark's make-plugin-reg.py
 * finds these functions by their names. */

#include "parts.h"
#include "protocol/fields.h"

void proto_register_sertap(void);
void proto_reg_handoff_sertap(void);
void proto_register_sis(void);
void proto_reg_handoff_sis(void);
void proto_register_synax(void);
void proto_reg_handoff_synax(void);

void
proto_register_sertap(void)
{
    protocol_register_sertap();
    sertap_register();
    sertap_line_register();
    sertap_statistics_register();
}

void
proto_reg_handoff_sertap(void)
{
    sertap_handoff();
}

void
proto_register_sis(void)
{
    protocol_register_sis();
    sis_address_register();
    sis_parameters_register();
    sis_packet_register();
    sis_routes_register();
    sis_exchange_register();
    sis_pieces_register();
    sis_export_register();
    sis_statistics_register();
    sis_tables_register();
    sis_access_register();
    sis_access_table_register();
    sis_follow_register();
    sis_rows_register();
    menu_register();
}

void
proto_reg_handoff_sis(void)
{
    sis_packet_handoff();
    sis_before_handoff();
    sis_transports_handoff();
}

void
proto_register_synax(void)
{
    protocol_register_synax();
    protocol_register_arcnet7f();
    protocol_register_synaxpk();
    protocol_register_rk512i();
    protocol_register_3964r();
    protocol_register_synaxobj();
    protocol_register_synaxpcp();
    protocol_register_synaxpd();
    protocol_register_sisascii();
    synax_pieces_register();
    synax_arcnet7f_register();
    synax_synaxpk_register();
    synax_rk512i_register();
    synax_3964r_register();
    synax_synaxobj_register();
    synax_synaxpcp_register();
    synax_synaxpd_register();
    sisascii_register();
    sisascii_exchange_register();
    sisascii_statistics_register();
}

void
proto_reg_handoff_synax(void)
{
    synax_3964r_handoff();
    synax_arcnet7f_handoff();
    synax_synaxpk_handoff();
    synax_synaxobj_handoff();
    synax_synaxpd_handoff();
    sisascii_handoff();
}
