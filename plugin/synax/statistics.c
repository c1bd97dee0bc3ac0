/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Response times: *Statistics > Service Response Time > RK512*. */

#include "synax/statistics.h"

#include <epan/srt_table.h>
#include <epan/tap.h>

#include "sertap/time.h"
#include "synax/rk512i.h"

/* The letters of the commands. A row of the table has the index of its letter here. */
static const char commands[] = {'A', 'E', 'O'};

static void
srt_init(struct register_srt *srt _U_, GArray *tables)
{
    static const char *const names[] = {"SEND", "FETCH", "SEND to an extended data block"};
    srt_stat_table *table = init_srt_table("RK512 commands", NULL, tables, array_length(commands), "Command",
                                           "rk512i.command", NULL);

    for (unsigned i = 0; i < array_length(commands); i++)
        init_srt_table_row(table, (int)i, names[i]);
}

/* The table subtracts it from the packet's time. */
static tap_packet_status
srt_packet(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    srt_stat_table *table = g_array_index(((srt_data_t *)data)->srt_array, srt_stat_table *, 0);
    const synax_answer_t *answer = tapped;
    const char *command = memchr(commands, answer->command, sizeof commands);
    nstime_t asked, taken = sertap_time(answer->elapsed);

    if (command == NULL)
        return TAP_PACKET_DONT_REDRAW;
    nstime_delta(&asked, &pinfo->abs_ts, &taken);
    add_srt_table_data(table, (int)(command - commands), &asked, pinfo);
    return TAP_PACKET_REDRAW;
}

void
synax_statistics_register(void)
{
    register_srt_table(proto_rk512i, "rk512i", 1, srt_packet, srt_init, NULL);
}
