/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the first pass has found out about telegrams. Several may be in one packet. Their records form a list:
 * proto_data with a key for each of them would be searched from its beginning for every telegram. */
#include "sis/record.h"

#include <epan/proto_data.h>

#include "protocol/fields.h"

sis_record_t *
sis_record_next(packet_info *pinfo)
{
    sis_packet_t *packet = sis_packet(pinfo);
    sis_record_t *record = packet->found != NULL ? packet->found->next
                                                 : p_get_proto_data(wmem_file_scope(), pinfo, proto_sis, 0);

    if (record != NULL)
        packet->found = record;
    return record;
}

sis_record_t *
sis_record_add(packet_info *pinfo, const sis_telegram_t *telegram)
{
    sis_packet_t *packet = sis_packet(pinfo);
    sis_record_t *record = wmem_new0(wmem_file_scope(), sis_record_t);

    record->service = telegram->service;
    record->is_reaction = telegram->is_reaction;
    if (packet->found != NULL)
        packet->found->next = record;
    else
        p_add_proto_data(wmem_file_scope(), pinfo, proto_sis, 0, record);
    packet->found = record;
    return record;
}

const sis_rare_t *
sis_rare(const sis_record_t *record, unsigned element)
{
    static const sis_rare_t none;
    const sis_rare_t *rare = record->rare;

    while (rare != NULL && rare->element != element)
        rare = rare->next;
    return rare != NULL ? rare : &none;
}

sis_rare_t *
sis_make_rare(sis_record_t *record, unsigned element)
{
    sis_rare_t **link = &record->rare;

    while (*link != NULL && (*link)->element != element)
        link = &(*link)->next;
    if (*link == NULL) {
        *link = wmem_new0(wmem_file_scope(), sis_rare_t);
        (*link)->element = element;
    }
    return *link;
}

sis_request_t *
sis_request_new(wmem_allocator_t *scope, uint8_t service, const sis_request_t *same, bool is_repeat)
{
    sis_request_t *request = wmem_new0(scope, sis_request_t);

    request->service = service;
    request->is_again = same != NULL && (is_repeat || same->is_to_be_repeated);
    if (request->is_again) {
        request->transfer = same->transfer;
        request->written = same->written;
        request->written_length = same->written_length;
    }
    return request;
}

sis_exchange_t *
sis_exchange_above(const sis_exchange_t *exchange)
{
    return exchange->routing != NULL ? exchange->routing->above : NULL;
}

sis_exchange_t *
sis_exchange_below(const sis_exchange_t *exchange)
{
    return exchange->routing != NULL ? exchange->routing->forwarded : NULL;
}
