/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the parts of the plugin register with Wireshark. register.c calls these; each stands in the file whose
 * name it has. */

#ifndef SIS_PARTS_H
#define SIS_PARTS_H

#include "compat.h"

void sertap_register(void); /* packet-sertap.c */
void sertap_handoff(void);
void sertap_line_register(void);

void sis_parameters_register(void);
void sis_address_register(void);
void sis_asked_register(void);
void sis_routes_register(void);
void sis_told_register(void);
void sis_exchange_register(void);
void sis_pieces_register(void);
void sis_packet_register(void);
void sis_packet_handoff(void);
void sis_export_register(void);
void sis_transports_handoff(void);

void sisascii_register(void);
void sisascii_handoff(void);
void sisascii_dialogue_register(void);

void synax_arcnet7f_register(void);
void synax_arcnet7f_handoff(void);
void synax_synaxpk_register(void);
void synax_synaxpk_handoff(void);
void rk512i_register(void);
void rk512_3964r_register(void);
void rk512_3964r_handoff(void);
void synax_synaxobj_handoff(void);
void synax_synaxpcp_register(void);
void synax_synaxpd_register(void);
void synax_synaxpd_handoff(void);

void windows_characters_register(void);
void windows_export_register(void);
void windows_filters_register(void);
void windows_response_times_register(void);
void windows_rows_register(void);
void windows_stations_register(void);
void windows_telegrams_register(void);

#endif
