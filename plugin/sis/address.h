/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Station addresses: their kinds in the two editions, and Wireshark's address type for them. */

#ifndef SIS_ADDRESS_H
#define SIS_ADDRESS_H

#include "compat.h"
#include "sis/names.h"

sis_address_kind_t sis_receiver_kind(uint8_t receiver);
sis_address_kind_t sis_sender_kind(uint8_t sender);

/* Whether commands to this (last) address are answered at all: those to groups and broadcasts are not. */
bool sis_is_answered(uint8_t receiver);

/* An address as a number: "16". */
const char *sis_number_text(uint8_t station);

/* "3", "201 (group)", "255 (all)": as in the info column. */
const char *sis_station_text(wmem_allocator_t *scope, uint8_t station);

/* Puts talker and listener into the packet's addresses, unless a lower layer has set them. */
void sis_set_addresses(packet_info *pinfo, uint8_t talker, uint8_t listener);

#endif
