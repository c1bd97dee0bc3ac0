/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Times as numbers that cannot overflow, and as text that is the same in every locale. */

#ifndef SERTAP_TIME_H
#define SERTAP_TIME_H

#include "compat.h"

/* Times are ns since 1970. This is the latest, in the year 2259; its negative is the earliest, in 1680.
 * The limit of int64_t is far enough away to add the length of a record and its uncertainty safely. */
#define SERTAP_LATEST INT64_C(9150000000000000000)

/* A packet's time, or the nearest valid one. */
int64_t sertap_ns(const nstime_t *moment);

/* The time from one instant to another in ns, up to SERTAP_LATEST in either direction. Every difference of
 * two packets' times is computed here. */
int64_t sertap_elapsed(int64_t from, int64_t to);

nstime_t sertap_time(int64_t ns);

/* Whether Wireshark's statistics trees survive this packet: their search for bursts crashes millions of
 * years after the first packet. */
bool sertap_can_be_counted(const packet_info *pinfo);

/* `value` / `divisor`, rounded, in units of the last decimal: 12345678 / 1000 with 3 decimals is "12.346";
 * and its unit. */
char *sertap_decimal_text(wmem_allocator_t *scope, int64_t value, uint64_t divisor, unsigned decimals,
                          const char *unit);

/* "12.346 ms". */
const char *sertap_ms_text(wmem_allocator_t *scope, int64_t ns);

/* Adds a duration that stands for no bytes, with its text. */
proto_item *sertap_add_time(proto_tree *tree, int hf, tvbuff_t *tvb, int64_t ns, const char *text);

/* The same as "12.345 ms", where somebody sees it and there is one. */
void sertap_add_ms(proto_tree *tree, int hf, tvbuff_t *tvb, wmem_allocator_t *scope, int64_t ns);

/* The same as a number of ms, rounded to three digits, for a column of the packet list. Hidden: the tree has
 * the time already. */
void sertap_add_column_ms(proto_tree *tree, int hf, tvbuff_t *tvb, int64_t ns);

#endif
