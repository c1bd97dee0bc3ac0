/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The header of a telegram (chapter 2.1), and the data of its packet. */
#include "sis/telegram.h"

#include <epan/proto_data.h>

#include "protocol/fields.h"

int sis_tap = -1;

sis_packet_t *
sis_packet(packet_info *pinfo)
{
    sis_packet_t *packet = p_get_proto_data(pinfo->pool, pinfo, proto_sis, 0);

    if (packet == NULL) {
        packet = wmem_new0(pinfo->pool, sis_packet_t);
        p_add_proto_data(pinfo->pool, pinfo, proto_sis, 0, packet);
    }
    return packet;
}

sis_telegram_t *
sis_telegram_read(tvbuff_t *tvb, packet_info *pinfo)
{
    sis_telegram_t *telegram = wmem_new0(pinfo->pool, sis_telegram_t);
    const uint8_t *header = tvb_get_ptr(tvb, 0, SIS_STATIC_LENGTH);
    unsigned there = tvb_reported_length(tvb);
    const sis_telegram_t *before = sis_packet(pinfo)->last;
    const sertap_record_t *tap = sertap_record(pinfo);

    telegram->tvb = tvb;
    telegram->is_before = tap != NULL && tap->type == SERTAP_BEFORE;
    telegram->control = header[4];
    telegram->service = header[5];
    telegram->sender = header[6];
    telegram->receiver = header[7];
    telegram->subaddress_count = telegram->control & SIS_CONTROL_SUBADDRESSES;
    telegram->is_reaction = telegram->control & SIS_CONTROL_REACTION;
    telegram->talker = telegram->is_reaction ? telegram->receiver : telegram->sender;
    telegram->listener = telegram->is_reaction ? telegram->sender : telegram->receiver;
    telegram->body_offset =
        SIS_STATIC_LENGTH + telegram->subaddress_count + ((telegram->control & SIS_CONTROL_NUMBER) ? 1 : 0);
    telegram->declared = sis_declared_length(tvb, 0);
    telegram->length = telegram->declared != 0 ? MIN(there, telegram->declared) : there;
    telegram->times = sis_times(tvb, pinfo, telegram->length, before != NULL ? &before->times : NULL);
    telegram->is_good = telegram->body_offset <= telegram->declared && sis_is_good(tvb, 0);
    telegram->last_address = telegram->receiver;
    if (telegram->is_good && telegram->subaddress_count > 0)
        telegram->last_address = compat_get_uint8(tvb, SIS_STATIC_LENGTH + telegram->subaddress_count - 1);
    if (telegram->is_good && (telegram->control & SIS_CONTROL_NUMBER))
        telegram->number = compat_get_uint8(tvb, telegram->body_offset - 1);
    return telegram;
}
