/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Items of the packet details: what was found out about a packet, which stands for no bytes, and bytes. */

#ifndef SIS_ITEMS_H
#define SIS_ITEMS_H

#include "compat.h"

/* Adds a number. */
proto_item *add_generated(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t value);

/* Adds a link to a packet, unless its number is 0. Returns its item, else NULL. */
proto_item *add_link(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t frame);

/* Adds the bytes up to `end`, if there are any. */
void add_bytes(proto_tree *tree, int hf, tvbuff_t *tvb, unsigned offset, unsigned end);

/* custom_fmt_func_double_t: always three digits, so that the points of a column stand below each other. */
void format_ms(char *text, double ms);

#endif
