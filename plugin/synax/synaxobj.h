/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Objects of SYNAX200 (chapter 2) that Interbus PCP, DeviceNet and Profibus FMS read and write: SIS telegrams
 * in data exchange objects, and diagnosis words. */

#ifndef SYNAX_SYNAXOBJ_H
#define SYNAX_SYNAXOBJ_H

#include "protocol/codes.h"

/* The action, and its object. */
typedef struct {
    uint16_t number;
    synaxobj_operation_t operation;
    uint8_t
        channel; /* distinguishes the devices of a bus, such as a communication reference; 0: there is one */
} synaxobj_access_t;

/* Whether it is one of these objects. */
bool synaxobj_is_known(uint16_t number);

/* An object that is known, on another bus: `length` available bytes at `offset`. Appends to the info column.
 */
void synaxobj_dissect(tvbuff_t *tvb, unsigned offset, unsigned length, packet_info *pinfo, proto_tree *parent,
                      const synaxobj_access_t *access);

#endif
