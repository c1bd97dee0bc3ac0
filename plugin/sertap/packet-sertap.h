/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The dissector of the serial tap's records. */

#ifndef SERTAP_PACKET_SERTAP_H
#define SERTAP_PACKET_SERTAP_H

/* Protocol, fields, the table "sertap.framing" and the tap "sertap". */
void sertap_register(void);

void sertap_handoff(void);

#endif
