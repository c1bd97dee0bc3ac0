/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Command, echo and answer of the ASCII protocol. A drive echoes each line but the one that opens it. Its
 * answer ends with its prompt, or with "?" while it waits for an element of a list (MPH-02, p. 10-86 to
 * 10-91). Between a command and its answer, the same line once more is its echo; a shared line does not show
 * who sent it. */

#include "ascii/dialogue.h"

#include <epan/proto_data.h>

#include "kept.h"
#include "parts.h"
#include "protocol/fields.h"
#include "sertap/line.h"
#include "sis/station.h"

/* One line of the capture, both directions of a tap, or a TCP connection. */
typedef struct {
    uint64_t key;
    sisascii_command_t *command; /* the last one */
    sisascii_command_t *list;    /* the write whose elements are expected */
    bool is_asked;               /* for the next of them */
    bool is_mute;                /* what seemed to be an echo was a repeat: nobody echoes now */
    bool has_drive;
    uint8_t drive; /* that is open */
} bus_t;

/* What the first pass works with. */
typedef struct {
    packet_info *pinfo;
    const sisascii_said_t *said;
    const sis_times_t *times;
    bus_t *bus;
    sisascii_unit_t *unit;
} noting_t;

static wmem_map_t *buses;

sis_place_t
sisascii_place(const sisascii_command_t *command)
{
    return (sis_place_t){.path = {command->drive}, .path_length = 1, .device = command->drive};
}

static bool
is_waiting(const sisascii_command_t *command)
{
    return command != NULL && command->asked->answer_in == 0;
}

/* Whether the last command may have this line as an answer. */
static bool
can_answer(const noting_t *n)
{
    const sisascii_command_t *command = n->bus->command;

    return command != NULL && command->end_in == 0 && sis_may_answer(&n->unit->asked, command->asked);
}

static bool
is_same(const noting_t *n, const sisascii_command_t *command)
{
    return command != NULL && strcmp(n->said->text, command->said.text) == 0;
}

static bool
is_echo(const noting_t *n)
{
    const sisascii_command_t *command = n->bus->command;

    return can_answer(n) && is_waiting(command) && is_same(n, command) && !command->is_echoed &&
           (n->unit->asked.line != 0 || (!n->bus->is_mute && command->said.kind != SISASCII_OPEN));
}

/* Characters that were lost or damaged since may have been the answer. */
static bool
is_disturbed(const noting_t *n, uint32_t since)
{
    const sertap_record_t *record = sertap_record(n->pinfo);
    sertap_disturbance_t seen;

    if (record == NULL)
        return false;
    seen = sertap_disturbance(record);
    return seen.lost_in > since || seen.unframed_in > since;
}

/* The next command comes: was the one before answered? */
static void
follow(const noting_t *n, sisascii_command_t *command)
{
    sisascii_command_t *before = n->bus->command;

    if (!is_waiting(before))
        return;
    if (before->is_echoed)
        n->bus->is_mute = true;
    if (is_same(n, before))
        command->repeat_of = before->repeat_of != 0 ? before->repeat_of : before->asked->frame;
    if (is_disturbed(n, before->asked->frame))
        return;
    before->next_in = command->asked->frame;
    command->unanswered_before = before->asked->frame;
}

static void
look_up(const noting_t *n, sisascii_command_t *command)
{
    sis_learned_t *learned = sis_learned_of(sis_exchange_bus(n->pinfo));
    sis_place_t place = sisascii_place(command);
    sis_twin_t twin;

    if (!command->has_drive)
        return;
    twin = sis_learned_twin(learned, &place, command->said.ident);
    command->known = sis_learned_find(learned, &place, command->said.ident);
    if (twin.known != NULL)
        command->twin = wmem_memdup(wmem_file_scope(), &twin, sizeof twin);
}

static sisascii_command_t *
begin(const noting_t *n, sisascii_kind_t kind)
{
    sisascii_command_t *command = wmem_new0(wmem_file_scope(), sisascii_command_t);

    n->unit->kind = kind;
    n->unit->command = command;
    n->unit->is_command = true;
    command->said = *n->said;
    command->said.kind = kind;
    command->said.text = wmem_strdup(wmem_file_scope(), n->said->text);
    command->asked = &n->unit->asked;
    follow(n, command);
    command->has_drive = n->bus->has_drive;
    command->drive = n->bus->drive;
    n->bus->command = command;
    n->bus->is_asked = false;
    return command;
}

static void
add_value(sisascii_command_t *command, const char *text)
{
    if (command->value == NULL)
        command->value = wmem_strbuf_new(wmem_file_scope(), "");
    wmem_strbuf_append_printf(command->value, "%s%s", command->count > 0 ? ", " : "", text);
    command->count++;
}

static void
begin_access(const noting_t *n)
{
    const sisascii_said_t *said = n->said;
    sisascii_command_t *command = begin(n, said->kind);

    n->bus->list = NULL;
    look_up(n, command);
    if (said->kind != SISASCII_WRITE)
        return;
    if (strcmp(said->text + said->value_at, ">") == 0)
        n->bus->list = command;
    else
        add_value(command, said->text + said->value_at);
}

/* What follows "?": an element, or "<" after the last one. */
static void
begin_element(const noting_t *n)
{
    bool is_end = strcmp(n->said->text, "<") == 0;
    sisascii_command_t *command = begin(n, is_end ? SISASCII_END : SISASCII_ELEMENT);

    command->list = n->bus->list;
    if (is_end)
        return;
    add_value(command->list, n->said->text);
    n->unit->number = command->list->count;
}

static void
answer(const noting_t *n, sisascii_kind_t kind)
{
    sisascii_command_t *command = n->bus->command;
    sisascii_unit_t *unit = n->unit;

    unit->kind = kind;
    unit->command = command;
    n->bus->is_mute = false;
    if (is_waiting(command))
        sis_asked_answer(&unit->asked, command->asked, n->times);
}

/* Name, unit and limits, as the drive says them. An attribute as text is not documented. */
static void
learn(const noting_t *n, const sisascii_command_t *command)
{
    sis_learned_t *learned = sis_learned_of(sis_exchange_bus(n->pinfo));
    sis_place_t place = sisascii_place(command);
    sis_fact_t fact = {command->said.element, 0, n->said->text};

    if (command->has_drive && fact.element != SIS_ELEMENT_ATTRIBUTE && n->said->text[0] != '\0')
        sis_learned_add(learned, &place, command->said.ident, &fact);
}

static void
note_value(const noting_t *n)
{
    sisascii_command_t *command = n->bus->command;

    answer(n, SISASCII_ANSWER);
    if (command->said.kind != SISASCII_READ)
        return;
    if (command->count == 0)
        learn(n, command);
    add_value(command, n->said->text);
    n->unit->number = command->count > 1 ? command->count : 0;
}

static void
note_error(const noting_t *n)
{
    sisascii_command_t *command = n->bus->command, *access = command->list != NULL ? command->list : command;

    answer(n, SISASCII_ERROR);
    access->has_error = true;
    access->error = n->said->error;
}

static void
note_prompt(const noting_t *n)
{
    n->bus->has_drive = true;
    n->bus->drive = n->said->drive;
    if (can_answer(n)) {
        answer(n, SISASCII_PROMPT);
        n->bus->command->end_in = n->pinfo->num;
    }
    n->bus->list = NULL;
    n->bus->is_asked = false;
}

static void
note_asking(const noting_t *n)
{
    if (!can_answer(n))
        return;
    answer(n, SISASCII_ASKS);
    n->bus->command->end_in = n->pinfo->num;
    n->bus->is_asked = n->bus->list != NULL;
}

static void
note_text(const noting_t *n)
{
    if (n->bus->is_asked && n->bus->list != NULL)
        begin_element(n);
    else if (n->said->text[0] != '\0' && can_answer(n) && n->bus->command->said.kind != SISASCII_OPEN)
        note_value(n);
}

static void
note_line(const noting_t *n)
{
    if (is_echo(n)) {
        n->unit->kind = SISASCII_ECHO;
        n->unit->command = n->bus->command;
        n->bus->command->is_echoed = true;
        return;
    }
    switch (n->said->kind) {
    case SISASCII_OPEN:
        n->bus->has_drive = true;
        n->bus->drive = n->said->drive;
        n->bus->list = NULL;
        begin(n, SISASCII_OPEN);
        break;
    case SISASCII_READ:
    case SISASCII_WRITE:
        begin_access(n);
        break;
    case SISASCII_PROMPT:
        note_prompt(n);
        break;
    case SISASCII_ASKS:
        note_asking(n);
        break;
    case SISASCII_ERROR:
        if (can_answer(n))
            note_error(n);
        break;
    default:
        note_text(n);
    }
}

/* A limit that the bus was told holds for SIS telegrams, so only the user's counts here. */
static void
find_limit(const noting_t *n)
{
    const sertap_record_t *record = sertap_record(n->pinfo);
    sis_bus_t *bus = sis_exchange_bus(n->pinfo);
    const sis_settings_t *settings;

    if (record == NULL)
        return;
    sis_bus_learn_limits(bus, sertap_limits(record));
    settings = sis_bus_settings(bus, SIS_ALL_STATIONS, n->times->begin);
    if (settings != NULL && settings->of[SIS_TRS].is_by_user)
        n->unit->limit = settings->of[SIS_TRS];
}

/* Which line of its packet this is, from 0. */
static uint32_t
number_in_packet(packet_info *pinfo)
{
    uint32_t *count = p_get_proto_data(pinfo->pool, pinfo, proto_sisascii, 0);

    if (count == NULL) {
        count = wmem_new0(pinfo->pool, uint32_t);
        p_add_proto_data(pinfo->pool, pinfo, proto_sisascii, 0, count);
    }
    return (*count)++;
}

/* Who has sent it: one of the two lines of a tap, or ends of a connection, whose ports may be equal;
 * 0: nobody knows. */
static uint8_t
line_of(const packet_info *pinfo, const sertap_record_t *record)
{
    if (record != NULL)
        return record->line;
    if (pinfo->ptype != PT_TCP)
        return 0;
    if (pinfo->srcport != pinfo->destport)
        return 1 + (pinfo->srcport > pinfo->destport);
    return 1 + (cmp_address(&pinfo->net_src, &pinfo->net_dst) > 0);
}

const sisascii_unit_t *
sisascii_find(packet_info *pinfo, const sisascii_said_t *said, const sis_times_t *times)
{
    sisascii_unit_t *unit = kept_of_packet(pinfo, proto_sisascii, number_in_packet(pinfo), sizeof *unit);
    noting_t n = {pinfo, said, times, NULL, unit};

    if (unit->asked.frame != 0)
        return unit;
    sis_asked_note(&unit->asked, pinfo, times);
    unit->asked.line = line_of(pinfo, sertap_record(pinfo));
    unit->kind = said->kind;
    if (pinfo->fd->visited)
        return unit;
    n.bus = kept_value(buses, &sis_exchange_bus(pinfo)->key, sizeof n.bus->key, sizeof *n.bus);
    find_limit(&n);
    note_line(&n);
    unit->has_drive = n.bus->has_drive;
    unit->drive = n.bus->drive;
    return unit;
}

void
sisascii_dialogue_register(void)
{
    buses = kept_map_of_numbers();
}
