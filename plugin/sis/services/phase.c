/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Services 0x12 and 0x1D and their equivalents of the product groups: reading and switching the phase
 * (chapters 8.4 and 8.5). */
#include "sis/services/services.h"

#include "items.h"
#include "sis/names.h"
#include "sis/told.h"

#define HIGHEST_PHASE   4
#define OPERATING_PHASE 4

static bool
take_phase(sis_body_t *body, uint32_t *phase)
{
    const char *mode;

    if (!sis_take(body, hf_sis_phase, 1, phase))
        return false;
    sis_tell(body->pinfo, hf_sis_phase, *phase);
    mode = try_val_to_str(*phase, sis_phases);
    if (mode != NULL)
        proto_item_append_text(body->item, " (%s)", mode);
    sis_say(body, ": phase %u%s%s%s", *phase, mode != NULL ? " (" : "", mode != NULL ? mode : "",
            mode != NULL ? ")" : "");
    if (*phase > HIGHEST_PHASE && body->telegram->is_good) /* in a damaged one it may be the damage */
        sis_mark(body, &ei_sis_body_note, "phase %u is not defined", *phase);
    return true;
}

/* A switch ends with the poll that returns its phase or an error. */
static void
learn_poll(sis_body_t *body)
{
    sis_switch_t *begun = &sis_exchange_direction(body->record->exchange)->phase_switch;
    sis_rare_t *rare;

    if (begun->command_in == 0)
        return;
    rare = sis_make_rare(body->record, body->element);
    rare->phase_switch = wmem_memdup(wmem_file_scope(), begun, sizeof *begun);
    rare->is_switch_end = body->status != 0 || body->phase == begun->to;
    if (rare->is_switch_end)
        begun->command_in = 0;
}

/* It begins when its command is acknowledged. */
static void
learn_switch(sis_body_t *body)
{
    const sis_exchange_t *exchange = body->record->exchange;

    if (body->status != 0 || body->asked == NULL)
        return;
    sis_exchange_direction(exchange)->phase_switch =
        (sis_switch_t){exchange->command_in, exchange->command_end, body->asked->phase};
    if (body->asked->phase < OPERATING_PHASE)
        exchange->stream->idle_in = body->pinfo->num;
}

void
sis_show_switch(sis_body_t *body)
{
    const sis_rare_t *rare = sis_rare(body->record, body->element);
    const sis_switch_t *begun = rare->phase_switch;
    int64_t elapsed;
    const char *words, *text;
    proto_item *item;

    if (begun == NULL)
        return;
    item = add_generated(body->tree, hf_sis_phase_switch_in, body->tvb, begun->command_in);
    proto_item_append_text(item, " (to phase %u)", begun->to);
    if (!rare->is_switch_end) {
        sis_say(body, ", switching to phase %u", begun->to);
        return;
    }
    words = body->status == 0 ? "reached" : "failed";
    elapsed = sertap_elapsed(begun->begin, body->telegram->times.begin);
    if (!sis_is_measured(elapsed, &body->telegram->times)) {
        sis_say(body, ", %s", words);
        return;
    }
    text = sertap_decimal_text(body->pinfo->pool, elapsed, 1000000, 3, " s");
    sertap_add_time(body->tree, hf_sis_phase_switch_time, body->tvb, elapsed, text);
    sis_say(body, ", %s after %s", words, text);
}

static void
dissect_phase_reaction(sis_body_t *body)
{
    bool is_switch = sis_general_service(body->service) == 0x1D;

    if (body->status == 0x01 || (body->status > 0x02 && sis_take_channel_error(body))) {
        if (body->status == 0x01)
            sis_take_rest(body, hf_sis_raw); /* not documented */
        return;
    }
    if (is_switch && body->status == 0)
        sis_say_words(body, ", accepted", NULL); /* the documents differ whether the phase of now follows */
    if (is_switch && body->status == 0 && body->asked != NULL && body->asked->phase > HIGHEST_PHASE)
        sis_mark(body, &ei_sis_body_note, "a phase above 4 is refused with 0x8004, not accepted");
    if (!(is_switch && body->status == 0 && sis_left(body) == 0) && !take_phase(body, &body->phase))
        return;
    if (body->status == 0x02)
        sis_take_error(body, sis_errors_phase, NULL);
    body->learn = is_switch ? learn_switch : learn_poll;
}

void
sis_dissect_phase(sis_body_t *body)
{
    uint32_t phase;

    if (body->is_reaction)
        dissect_phase_reaction(body);
    else if (sis_general_service(body->service) == 0x1D && take_phase(body, &phase) && body->request != NULL)
        body->request->phase = (uint8_t)phase;
}
