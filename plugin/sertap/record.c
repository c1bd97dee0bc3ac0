/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A record of the serial tap, for all dissectors of its payload. */
#include "sertap/record.h"

#include <epan/proto_data.h>

const sertap_record_t *
sertap_record(packet_info *pinfo)
{
    return p_get_proto_data(pinfo->pool, pinfo, proto_sertap, 0);
}

unsigned
sertap_index(const sertap_record_t *record, tvbuff_t *part)
{
    unsigned offset = (unsigned)tvb_raw_offset(part);
    bool has_own_source = tvb_get_ds_tvb(part) != tvb_get_ds_tvb(record->tvb);

    return has_own_source ? offset : offset - (unsigned)tvb_raw_offset(record->tvb) - record->data_offset;
}

int64_t
sertap_interval(const sertap_record_t *record, unsigned at)
{
    return at == 0 ? record->silence : tvb_get_ntohl(record->tvb, (int)(record->times_offset + 4 * at));
}

uint8_t
sertap_flags(const sertap_record_t *record, unsigned at)
{
    return compat_get_uint8(record->tvb, record->flags_offset + at);
}

int64_t
sertap_character_ns(const sertap_record_t *record)
{
    int64_t half_bits = 2 + 2 * record->data_bits + (record->parity != 0 ? 2 : 0) + record->stop_half_bits;

    return record->baud != 0 ? half_bits * 500000000 / record->baud : 0;
}

const char *
sertap_format_text(wmem_allocator_t *scope, const sertap_record_t *record)
{
    static const char parity_letters[] = "NEOMS";
    char parity = record->parity < strlen(parity_letters) ? parity_letters[record->parity] : '?';

    return wmem_strdup_printf(scope, "%u%c%s", record->data_bits, parity,
                              val_to_str_const(record->stop_half_bits, sis_sertap_stop_bits, "?"));
}

bool
sertap_is_loss(const sertap_record_t *record)
{
    return record->type == SERTAP_EVENT &&
           (record->event == SERTAP_CHARACTERS_LOST || record->event == SERTAP_ADAPTER_LOST);
}

static uint32_t
big_endian(const uint8_t *bytes)
{
    uint32_t number;

    memcpy(&number, bytes, sizeof number);
    return GUINT32_FROM_BE(number);
}

/* Longest interval and errors. The interval before the first character does not belong to this record. The
 * interval before a character that follows lost ones is unknown. */
void
sertap_record_survey(sertap_record_t *record)
{
    const uint8_t *intervals, *all_flags;

    if (record->timed == 0)
        return;
    intervals = tvb_get_ptr(record->tvb, record->times_offset, 4 * record->timed);
    all_flags = tvb_get_ptr(record->tvb, record->flags_offset, record->timed);
    record->silence = big_endian(intervals);
    record->is_silence_known = record->silence < UINT32_MAX && !(all_flags[0] & SERTAP_INTERVAL_SATURATED);
    record->is_duration_known = record->timed == record->count;
    for (unsigned i = 0; i < record->timed; i++) {
        uint8_t flag = all_flags[i];
        uint32_t interval = big_endian(intervals + 4 * i);
        uint8_t news = flag & ~record->flags;

        for (unsigned bit = 0; news >> bit; bit++) {
            if (news >> bit & 1)
                record->first_at[bit] = i;
        }
        record->flags |= flag;
        if (i > 0)
            record->duration += interval;
        if (i > 0 && flag & SERTAP_INTERVAL_SATURATED)
            record->is_duration_known = false;
        if (i > 0 && interval > record->interval_max && !(flag & SERTAP_ERROR_LOST)) {
            record->interval_max = interval;
            record->interval_max_at = i;
        }
    }
}
