/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The characters of a serial line that come over TCP: units (telegrams, lines) are split over segments and
 * packed into them. */

#ifndef SIS_SEGMENTS_H
#define SIS_SEGMENTS_H

#include "compat.h"

#include <epan/dissectors/packet-tcp.h>

/* Dissects each unit. `length_of` says how long the one at an offset is, or 0 if more bytes are needed;
 * `data` is for both. */
int sis_segments_dissect(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree,
                         unsigned (*length_of)(packet_info *, tvbuff_t *, int, void *),
                         dissector_t dissect_unit, void *data);

/* Notes whether a segment begins with a negotiation of Telnet. Also for one that nobody dissects yet. */
void sis_segments_look(tvbuff_t *tvb, packet_info *pinfo);

/* Gives a connection to a dissector from this packet on: earlier bytes were something else, in the second
 * pass, too. `dissect` is that of the handle. */
compat_bool sis_recognize(tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree, dissector_handle_t handle,
                          dissector_t dissect);

/* Begins the info of a unit. There may be text: of another unit of this packet, or of TCP, which ends with a
 * space. */
void sis_separate(packet_info *pinfo);

#endif
