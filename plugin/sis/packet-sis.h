/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The dissector of telegrams. */

#ifndef SIS_PACKET_SIS_H
#define SIS_PACKET_SIS_H

#include "compat.h"

extern dissector_handle_t sis_handle; /* all telegrams of the data, one after the other */

/* The dissector of that handle. */
int sis_dissect_packet(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, void *data);

/* One telegram; `tvb` begins with it and has nothing of the next. Adds to the info column. */
void sis_dissect_telegram(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree);

#endif
