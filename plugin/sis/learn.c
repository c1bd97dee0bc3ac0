/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The first pass: what is learned from a telegram, in the order of the capture, and written into its record.
 * First its relations and what is valid for it; then, as soon as it is decoded, what it says. Only the place
 * of a piece must be known while it is decoded (sequence.c). */
#include "sis/learn.h"

#include "sertap/line.h"
#include "sis/address.h"
#include "sis/bus.h"
#include "sis/cycle.h"
#include "sis/sequence.h"

/* What is valid for a telegram, and how busy its line is. The slave of a swapped reaction is in its command.
 */
static void
learn_settings(sis_record_t *record, sis_bus_t *bus, packet_info *pinfo, const sis_telegram_t *telegram)
{
    const sis_times_t *times = &telegram->times;
    uint8_t address = record->exchange != NULL ? record->exchange->path[0] : telegram->receiver;

    if (!telegram->is_good || !sis_is_answered(address))
        address = SIS_ALL_STATIONS;
    if (times->record != NULL)
        sis_bus_learn_limits(bus, sertap_limits(times->record));
    if (!telegram->is_before)
        sis_cycle_heard(bus, times, pinfo->num);
    record->settings = sis_bus_settings(bus, address, times->begin);
    record->load = times->record != NULL ? sertap_load(times->record) : -1;
}

/* Of a telegram that the first pass did not see: TCP reassembled its segments differently. */
static sis_record_t *
unseen_record(packet_info *pinfo)
{
    sis_record_t *record = wmem_new0(pinfo->pool, sis_record_t);

    record->load = -1;
    return record;
}

sis_record_t *
sis_learn_telegram(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram)
{
    sis_record_t *record = sis_record_next(pinfo);

    if (record == NULL && !pinfo->fd->visited) {
        sis_bus_t *bus = sis_exchange_bus(pinfo);

        record = sis_record_add(pinfo, telegram);
        sis_exchange_learn(record, bus, tvb, pinfo, telegram);
        learn_settings(record, bus, pinfo, telegram);
    }
    if (record == NULL || record->service != telegram->service ||
        record->is_reaction != telegram->is_reaction)
        return unseen_record(pinfo);
    return record;
}

void
sis_learn_body(sis_body_t *body)
{
    if (body->pinfo->fd->visited)
        return;
    if (body->learn != NULL)
        body->learn(body);
    sis_sequence_learn(body);
    if (body->element == 0 && !body->is_reaction) {
        body->request->is_read = true;
        if (!body->telegram->is_before)
            sis_cycle_learn(body);
    }
}
