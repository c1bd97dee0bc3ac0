/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Several telegrams in a packet: which of its fields are whose. */

#ifndef SIS_PACKED_H
#define SIS_PACKED_H

#include <epan/packet.h>

/* Tells the fields of a telegram, unless it is the first of its packet. Call it last. */
void sis_tell_packed(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree);

#endif
