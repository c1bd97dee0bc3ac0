/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Response times: *Statistics > Service Response Time > SISASCII*. */

#include <epan/srt_table.h>
#include <epan/tap.h>

#include "ascii/sisascii.h"
#include "parts.h"
#include "protocol/fields.h"
#include "sertap/time.h"

/* A row of the table has the number of its kind of line. */
#define KINDS (SISASCII_END + 1)

static void
srt_init(struct register_srt *srt _U_, GArray *tables)
{
    srt_stat_table *table =
        init_srt_table("Lines of the ASCII protocol", NULL, tables, KINDS, "Line", "sisascii.kind", NULL);

    for (int kind = 0; kind < KINDS; kind++)
        init_srt_table_row(table, kind, val_to_str_const((uint32_t)kind, sis_ascii_kinds, ""));
}

/* The table subtracts it from the packet's time. */
static tap_packet_status
srt_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    srt_stat_table *table = g_array_index(((srt_data_t *)data)->srt_array, srt_stat_table *, 0);
    const sisascii_answer_t *answer = tapped;
    nstime_t asked, taken = sertap_time(answer->elapsed);

    nstime_delta(&asked, &pinfo->abs_ts, &taken);
    add_srt_table_data(table, (int)answer->kind, &asked, pinfo);
    return TAP_PACKET_REDRAW;
}

void
sisascii_statistics_register(void)
{
    register_srt_table(proto_sisascii, "sisascii", 1, srt_packet, srt_init, NULL);
}
