/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Common fields of the other SYNAX200 transports. */

#include "synax/fields.h"

int proto_synax = -1;

int hf_synax_request_in = -1;
int hf_synax_answer_in = -1;
int hf_synax_answer_time = -1;

expert_field ei_synax_note = EI_INIT;
expert_field ei_synax_short = EI_INIT;
expert_field ei_synax_unexpected = EI_INIT;
expert_field ei_synax_error = EI_INIT;
expert_field ei_synax_unanswered = EI_INIT;
expert_field ei_synax_unanswered_before = EI_INIT;
expert_field ei_synax_too_many = EI_INIT;

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_synax_request_in, {"Request in", "synax.request_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_REQUEST), 0, NULL, HFILL}},
    {&hf_synax_answer_in, {"Answer in", "synax.answer_in", FT_FRAMENUM, BASE_NONE, FRAMENUM_TYPE(FT_FRAMENUM_RESPONSE), 0, NULL, HFILL}},
    {&hf_synax_answer_time, {"Time to the answer", "synax.answer_time", FT_RELATIVE_TIME, BASE_NONE, NULL, 0, "From the request to its answer", HFILL}},
};

static ei_register_info experts[] = {
    {&ei_synax_note, {"synax.note", PI_PROTOCOL, PI_NOTE, "Content that the documents do not define", EXPFILL}},
    {&ei_synax_short, {"synax.short", PI_PROTOCOL, PI_WARN, "Bytes are missing", EXPFILL}},
    {&ei_synax_unexpected, {"synax.unexpected", PI_PROTOCOL, PI_WARN, "More bytes than expected", EXPFILL}},
    {&ei_synax_error, {"synax.error", PI_RESPONSE_CODE, PI_NOTE, "The answer reports an error", EXPFILL}},
    {&ei_synax_unanswered, {"synax.unanswered", PI_SEQUENCE, PI_NOTE, "No answer before the next request", EXPFILL}},
    {&ei_synax_unanswered_before, {"synax.unanswered_before", PI_SEQUENCE, PI_NOTE, "A request before this one got no answer", EXPFILL}},
    {&ei_synax_too_many, {"synax.pieces.too_many", PI_SEQUENCE, PI_NOTE, "More than 8192 pieces: they are not joined", EXPFILL}},
};
/* clang-format on */

void
synax_fields_register(void)
{
    proto_synax = proto_register_protocol("Rexroth SYNAX200 transports", "SYNAX", "synax");
    proto_register_field_array(proto_synax, fields, array_length(fields));
    expert_register_field_array(expert_register_protocol(proto_synax), experts, array_length(experts));
}
