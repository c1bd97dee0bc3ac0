/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Items of the packet details that stand for no bytes: what was found out about a packet. */

#ifndef SIS_ITEMS_H
#define SIS_ITEMS_H

#include "compat.h"

/* Adds a number. */
proto_item *add_generated(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t value);

/* Adds a link to a packet, unless its number is 0. Returns its item, else NULL. */
proto_item *add_link(proto_tree *tree, int hf, tvbuff_t *tvb, uint32_t frame);

/* custom_fmt_func_double_t: always three digits, so that the points of a column stand below each other. */
void format_ms(char *text, double ms);

#endif
