/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Times as numbers that cannot overflow, and as text that is the same in every locale.
 *
 * A capture may claim any time. Numbers with decimals are made from integers: printf() would write a comma
 * where the user's locale has one, and people compare and filter for these texts. */
#include "sertap/time.h"

#include <math.h>

#define NS_PER_US INT64_C(1000)
#define NS_PER_S  INT64_C(1000000000)

int64_t
sertap_ns(const nstime_t *moment)
{
    int64_t seconds = CLAMP((int64_t)moment->secs, -SERTAP_LATEST / NS_PER_S, SERTAP_LATEST / NS_PER_S);

    return CLAMP(seconds * NS_PER_S + moment->nsecs, -SERTAP_LATEST, SERTAP_LATEST);
}

int64_t
sertap_elapsed(int64_t from, int64_t to)
{
    if (from < 0 && to > SERTAP_LATEST + from)
        return SERTAP_LATEST;
    if (from > 0 && to < -SERTAP_LATEST + from)
        return -SERTAP_LATEST;
    return to - from;
}

nstime_t
sertap_time(int64_t ns)
{
    nstime_t moment = {(time_t)(ns / NS_PER_S), (int)(ns % NS_PER_S)};

    return moment;
}

proto_item *
sertap_add_time(proto_tree *tree, int hf, tvbuff_t *tvb, int64_t ns, const char *text)
{
    nstime_t shown = sertap_time(ns);
    proto_item *item = proto_tree_add_time_format_value(tree, hf, tvb, 0, 0, &shown, "%s", text);

    proto_item_set_generated(item);
    return item;
}

/* Wireshark leaves out items that nobody sees or filters for, but only after their text is made.
 * A clock that is set back makes no duration. */
void
sertap_add_ms(proto_tree *tree, int hf, tvbuff_t *tvb, wmem_allocator_t *scope, int64_t ns)
{
    if (ns >= 0 && proto_field_is_referenced(tree, hf))
        sertap_add_time(tree, hf, tvb, ns, sertap_ms_text(scope, ns));
}

void
sertap_add_column_ms(proto_tree *tree, int hf, tvbuff_t *tvb, int64_t ns)
{
    proto_item *item;

    if (!proto_field_is_referenced(tree, hf))
        return;
    item = proto_tree_add_double(tree, hf, tvb, 0, 0, floor((double)ns / 1e3 + 0.5) / 1e3);
    proto_item_set_generated(item);
    proto_item_set_hidden(item);
}

bool
sertap_can_be_counted(const packet_info *pinfo)
{
    return pinfo->rel_ts.secs <= 2 * (SERTAP_LATEST / NS_PER_S);
}

/* Written from its end; printf() takes ten times as long. */
char *
sertap_decimal_text(wmem_allocator_t *scope, int64_t value, uint64_t divisor, unsigned decimals,
                    const char *unit)
{
    uint64_t magnitude = value < 0 ? -(uint64_t)value : (uint64_t)value;
    uint64_t digits = magnitude / divisor + (magnitude % divisor >= divisor - divisor / 2);
    size_t size = strlen(unit) + 1;
    char text[32], *begin = text + sizeof text - size;

    memcpy(begin, unit, size);
    for (unsigned written = 0; written <= decimals || digits > 0; written++) {
        if (written == decimals)
            *--begin = '.';
        *--begin = (char)('0' + digits % 10);
        digits /= 10;
    }
    if (value < 0)
        *--begin = '-';
    return wmem_strdup(scope, begin);
}

const char *
sertap_ms_text(wmem_allocator_t *scope, int64_t ns)
{
    return sertap_decimal_text(scope, ns, NS_PER_US, 3, " ms");
}
