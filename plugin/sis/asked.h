/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A request and its answer, in all protocols but SIS: there a command has repeats and routers, too
 * (exchange.h). */

#ifndef SIS_ASKED_H
#define SIS_ASKED_H

#include "sis/times.h"

/* A message that asks or answers; lives as long as the file. */
typedef struct {
    uint32_t frame;            /* its own; 0: not seen yet */
    uint32_t request_in;       /* of an answer: the request; 0: none, or not known */
    uint32_t answer_in;        /* of a request: the first answer; 0: none */
    uint8_t line;              /* of a tap with two directions; 0: who has sent it is not known */
    int64_t end, end_earliest; /* of its last character, ns */
    bool is_bounded;
    int64_t elapsed; /* of an answer: since the end of the request, ns */
    sis_span_t span; /* the same, with its bounds */
} sis_asked_t;

/* First pass: begins with what its packet says. */
void sis_asked_note(sis_asked_t *asked, packet_info *pinfo, const sis_times_t *times);

/* Nobody answers himself. A shared line does not show who has sent what. */
bool sis_may_answer(const sis_asked_t *answer, const sis_asked_t *request);

/* First pass: connects both; `times` are those of the answer. */
void sis_asked_answer(sis_asked_t *answer, sis_asked_t *request, const sis_times_t *times);

/* First pass: where a protocol keeps its last request about `what` on this line; at first NULL. */
void **sis_asked_last(const packet_info *pinfo, int proto, uint32_t what);

typedef struct {
    int request_in, answer_in, elapsed;
} sis_asked_fields_t;

/* Adds what is known of it. */
void sis_asked_show(const sis_asked_t *asked, proto_tree *tree, tvbuff_t *tvb, packet_info *pinfo,
                    const sis_asked_fields_t *fields);

#endif
