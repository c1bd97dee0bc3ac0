/* SPDX-License-Identifier: GPL-2.0-or-later */
/* *Statistics > Service Response Time*: of SIS by service, of RK512 by command, of the ASCII protocol by line
 * (`tshark -z sis,srt`, `-z rk512i,srt`, `-z sisascii,srt`). */
#include "parts.h"

#include <epan/srt_table.h>
#include <epan/tap.h>

#include "ascii/dialogue.h"
#include "sis/exchange.h"
#include "sis/names.h"
#include "rk512/rk512i.h"

#define SERVICES 256
#define KINDS    (SISASCII_END + 1)

/* The letters of RK512's commands. A row of the table has the index of its letter here. */
static const char commands[] = {'A', 'E', 'O'};

/* The table subtracts the time of the command from the packet's. */
static tap_packet_status
count(void *data, const packet_info *pinfo, int row, int64_t elapsed)
{
    srt_stat_table *table = g_array_index(((srt_data_t *)data)->srt_array, srt_stat_table *, 0);
    nstime_t asked, taken = sertap_time(elapsed);

    nstime_delta(&asked, &pinfo->abs_ts, &taken);
    add_srt_table_data(table, row, &asked, (packet_info *)pinfo);
    return TAP_PACKET_REDRAW;
}

static void
init_services(struct register_srt *srt _U_, GArray *tables)
{
    srt_stat_table *table =
        init_srt_table("SIS services", NULL, tables, SERVICES, "Service", "sis.service", NULL);
    wmem_allocator_t *pool = wmem_allocator_new(WMEM_ALLOCATOR_SIMPLE);

    for (unsigned service = 0; service < SERVICES; service++)
        init_srt_table_row(table, (int)service, sis_service_name(pool, (uint8_t)service));
    wmem_destroy_allocator(pool);
}

static tap_packet_status
count_service(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    const sis_telegram_t *telegram = tapped;

    if (!telegram->timing.has_reaction_time)
        return TAP_PACKET_DONT_REDRAW;
    return count(data, pinfo, telegram->service, telegram->record->exchange->reaction_time);
}

static void
init_commands(struct register_srt *srt _U_, GArray *tables)
{
    static const char *const names[] = {"SEND", "FETCH", "SEND to an extended data block"};
    srt_stat_table *table = init_srt_table("RK512 commands", NULL, tables, array_length(commands), "Command",
                                           "rk512i.command", NULL);

    for (unsigned i = 0; i < array_length(commands); i++)
        init_srt_table_row(table, (int)i, names[i]);
}

static tap_packet_status
count_command(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped,
              tap_flags_t flags _U_)
{
    const rk512i_answer_t *answer = tapped;
    const char *command = memchr(commands, answer->command, sizeof commands);

    if (command == NULL)
        return TAP_PACKET_DONT_REDRAW;
    return count(data, pinfo, (int)(command - commands), answer->elapsed);
}

static void
init_kinds(struct register_srt *srt _U_, GArray *tables)
{
    srt_stat_table *table =
        init_srt_table("Lines of the ASCII protocol", NULL, tables, KINDS, "Line", "sisascii.kind", NULL);

    for (int kind = 0; kind < KINDS; kind++)
        init_srt_table_row(table, kind, val_to_str_const((uint32_t)kind, sis_ascii_kinds, ""));
}

static tap_packet_status
count_kind(void *data, packet_info *pinfo, epan_dissect_t *edt _U_, const void *tapped, tap_flags_t flags _U_)
{
    const sisascii_unit_t *answer = tapped;

    return count(data, pinfo, (int)answer->command->said.kind, answer->asked.elapsed);
}

void
windows_response_times_register(void)
{
    register_srt_table(proto_sis, "sis", 1, count_service, init_services, NULL);
    register_srt_table(proto_rk512i, "rk512i", 1, count_command, init_commands, NULL);
    register_srt_table(proto_sisascii, "sisascii", 1, count_kind, init_kinds, NULL);
}
