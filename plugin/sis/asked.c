/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A request and its answer, in all protocols but SIS. */
#include "sis/asked.h"

#include "items.h"
#include "kept.h"
#include "parts.h"
#include "sertap/line.h"

typedef struct {
    uint64_t line;
    uint64_t what; /* and whose */
} subject_t;

KEPT_KEY(subject_t, 8 + 8)

typedef struct {
    subject_t key;
    void *last;
} last_t;

static wmem_map_t *requests;

void
sis_asked_note(sis_asked_t *asked, packet_info *pinfo, const sis_times_t *times)
{
    const sertap_record_t *record = sertap_record(pinfo);

    asked->frame = pinfo->num;
    asked->line = record != NULL ? record->line : 0;
    asked->end = times->end;
    asked->end_earliest = times->end_earliest;
    asked->is_bounded = times->is_bounded;
}

bool
sis_may_answer(const sis_asked_t *answer, const sis_asked_t *request)
{
    return answer->line == 0 || answer->line != request->line;
}

void
sis_asked_answer(sis_asked_t *answer, sis_asked_t *request, const sis_times_t *times)
{
    if (request->answer_in == 0)
        request->answer_in = answer->frame;
    answer->request_in = request->frame;
    answer->elapsed = sertap_elapsed(request->end, times->begin);
    answer->span = (sis_span_t){0, SIS_ANY_TIME};
    if (request->is_bounded && times->is_bounded)
        answer->span = sis_span_between(request->end_earliest, request->end, times);
}

void **
sis_asked_last(const packet_info *pinfo, int proto, uint32_t what)
{
    subject_t key = {sertap_line_key(pinfo), (uint64_t)proto << 32 | what};
    last_t *kept = kept_value(requests, &key, sizeof key, sizeof *kept);

    return &kept->last;
}

void
sis_asked_show(const sis_asked_t *asked, proto_tree *tree, tvbuff_t *tvb, packet_info *pinfo,
               const sis_asked_fields_t *fields)
{
    add_link(tree, fields->answer_in, tvb, asked->answer_in);
    add_link(tree, fields->request_in, tvb, asked->request_in);
    if (asked->request_in != 0)
        sertap_add_ms(tree, fields->elapsed, tvb, pinfo->pool, asked->elapsed);
}

void
sis_asked_register(void)
{
    requests = kept_map(hash_subject_t, are_equal_subject_t);
}
