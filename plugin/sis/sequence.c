/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sequential telegrams: long data are read or written in pieces (chapters 8.2 and 8.7). Bit 2 of the
 * parameter control says whether more follow. Nothing marks the first piece or numbers the pieces. */
#include "sis/sequence.h"

#include "items.h"
#include "protocol/limits.h"
#include "sis/address.h"
#include "sis/names.h"
#include "sis/pieces.h"

#define SERVICE_CHANNEL_BUSY 0x8001 /* the command was not executed, and must be repeated */
#define PARAMETER_OCCUPIED   0x800C
#define CANCELLED            0x800B /* another request had priority: the transfer has ended */

#define TELEGRAM_ERROR              0xF0 /* and above */
#define INVALID_SEQUENTIAL_TELEGRAM 0xF8

#define LENGTH_WORDS 4u /* of a list: actual and maximum length, two bytes each */

/* What a transfer is about; constant for all its pieces. */
typedef struct {
    uint8_t service;
    bool is_in_list; /* of elements of service 0x04 */
    sis_ident_t ident;
    uint8_t element;
    uint8_t device;
    uint32_t segment; /* as requested */
} subject_t;

/* A transfer under way, from one station to another. */
typedef struct sis_transfer {
    struct sis_transfer *next;      /* of the same bus */
    const sis_exchange_t *exchange; /* that began it */
    subject_t subject;
    uint32_t number;
    uint32_t begun_in;
    uint32_t last_in;       /* the latest piece */
    uint32_t damaged_count; /* of its bus, then */
    uint32_t received;      /* bytes */
    uint32_t pieces;        /* reassembled so far */
    uint32_t announced;     /* bytes, by the length words of a list; 0: unknown */
    uint32_t length_words;  /* as they are, if a length is known */
    uint32_t cancelled_in;  /* a command since the latest piece, not confirmed yet; 0: none */
    uint32_t begun_after;   /* the list of services that begins it behind a cancel; 0: none */
    bool is_broken;         /* a piece may be missing: reassembly has ended */
    bool is_refused;        /* after 0xF8: it restarts or continues */
    bool is_doubtful; /* a cancel was not confirmed, and nothing tells whether it restarted or continued */
    bool is_begun_anew;
} transfer_t;

/* Whether a transfer is one of these two stations, in this direction. */
static bool
is_between(const transfer_t *transfer, const sis_exchange_t *exchange)
{
    return sis_exchange_direction(transfer->exchange) == sis_exchange_direction(exchange);
}

/* An element of a list and a telegram are never steps of one transfer: between its telegrams, the service
 * stays the same (0xF8, fig. 2-18). */
static bool
is_same(const subject_t *one, const subject_t *other)
{
    return one->service == other->service && one->is_in_list == other->is_in_list &&
           one->element == other->element && one->device == other->device &&
           one->ident.type == other->ident.type && one->ident.number == other->ident.number &&
           one->segment == other->segment;
}

/* What a command asks for, as a transfer. */
static subject_t
subject_of(const sis_request_t *request, bool is_in_list)
{
    return (subject_t){request->service, is_in_list,      request->ident,
                       request->element, request->device, request->segment};
}

/* Of an element of a list, or of a list as a whole. */
static bool
is_in_list(const sis_body_t *body)
{
    return body->element != 0 || body->service == SIS_LIST;
}

/* NULL: it is not under way. */
static transfer_t *
find_transfer(const sis_exchange_t *exchange, const subject_t *subject)
{
    transfer_t *transfer = exchange->stream->bus->open;

    while (transfer != NULL && !(is_between(transfer, exchange) && is_same(&transfer->subject, subject)))
        transfer = transfer->next;
    return transfer;
}

/* Whether the same data are under way in telegrams, if these are in a list, or the other way round. */
static bool
is_under_way_apart(const sis_exchange_t *exchange, const subject_t *subject)
{
    subject_t apart = *subject;

    apart.is_in_list = !apart.is_in_list;
    return find_transfer(exchange, &apart) != NULL;
}

static void
end_transfer(transfer_t *transfer)
{
    transfer_t **link = &transfer->exchange->stream->bus->open;

    while (*link != transfer)
        link = &(*link)->next;
    *link = transfer->next;
    wmem_free(wmem_file_scope(), transfer);
}

static void
note_end(const sis_body_t *body, const transfer_t *transfer, const char *reason)
{
    sis_rare_t *rare;
    sis_ended_t *ended;

    if (transfer->is_refused) /* already reported */
        return;
    rare = sis_make_rare(body->record, body->element);
    ended = wmem_new(wmem_file_scope(), sis_ended_t);
    *ended = (sis_ended_t){rare->ended, transfer->begun_in, reason};
    rare->ended = ended;
}

static void
end_with_note(const sis_body_t *body, transfer_t *transfer, const char *reason)
{
    note_end(body, transfer, reason);
    end_transfer(transfer);
}

/* Appends a transfer to the list of its bus, whose length is limited: so the oldest may be dropped. */
static transfer_t *
open_transfer(const sis_body_t *body, const subject_t *subject)
{
    const sis_exchange_t *exchange = body->record->exchange;
    transfer_t **link = &exchange->stream->bus->open, *transfer = wmem_new0(wmem_file_scope(), transfer_t);
    unsigned count = 0;

    for (; *link != NULL; link = &(*link)->next)
        count++;
    *link = transfer;
    transfer->subject = *subject;
    transfer->exchange = exchange;
    if (count >= SIS_MOST_OPEN)
        end_with_note(body, exchange->stream->bus->open, "too many others have begun since");
    return transfer;
}

/* A step seen before: the same command again, or its reaction again. */
static bool
is_taken_before(const sis_body_t *body)
{
    const sis_record_t *record = body->record;

    if (body->is_reaction)
        return record->reaction_before != 0 || record->exchange->is_kept_reaction_seen;
    return body->request->is_again;
}

/* Whether a piece may have been lost since the one before: lost characters; the damaged reaction to a
 * command that was then repeated; or a damaged command with its damaged reaction. Not if the slave repeats
 * the reaction that it has kept. */
static bool
is_piece_missing(const sis_record_t *record, const transfer_t *transfer)
{
    const sis_exchange_t *exchange = record->exchange;
    const sis_bus_t *bus = exchange->stream->bus;
    unsigned enough = record->is_reaction && exchange->first != NULL ? 1 : 2;

    return bus->lost_in > transfer->last_in ||
           (!exchange->is_reaction_kept && bus->damaged_count - transfer->damaged_count >= enough);
}

/* The number of bytes of a list, if this is its first piece and has length words (a SERCOS list: bytes used,
 * possible); 0: unknown. */
static uint32_t
announced_by(const sis_body_t *body)
{
    unsigned length = sis_left(body), actual;

    if (length < LENGTH_WORDS)
        return 0;
    actual = tvb_get_letohs(body->tvb, body->offset);
    if (actual > tvb_get_letohs(body->tvb, body->offset + 2) || actual + LENGTH_WORDS <= length)
        return 0;
    return actual + LENGTH_WORDS;
}

static void
begin_transfer(transfer_t *transfer, const sis_body_t *body)
{
    transfer->number = sis_next_transfer();
    transfer->begun_in = transfer->last_in = body->pinfo->num;
    transfer->damaged_count = body->record->exchange->stream->bus->damaged_count;
    transfer->received = transfer->pieces = 0;
    transfer->announced = announced_by(body);
    transfer->length_words = transfer->announced != 0 ? tvb_get_letohl(body->tvb, body->offset) : 0;
    transfer->is_broken = false;
}

/* After 0xF8, or a cancel that was not confirmed, a transfer restarts with its length words, or continues.
 * The announced length decides whether it can continue. If neither fits, pieces are missing. */
static void
follow_break(transfer_t *transfer, const sis_body_t *body, bool is_last)
{
    unsigned length = sis_left(body), received = transfer->received + length;

    if (transfer->announced == 0) {
        transfer->is_doubtful = true;
    } else if (length >= LENGTH_WORDS && tvb_get_letohl(body->tvb, body->offset) == transfer->length_words) {
        note_end(body, transfer, "cancelled");
        begin_transfer(transfer, body);
        transfer->is_begun_anew = true;
    } else if (is_last ? received != transfer->announced : received > transfer->announced) {
        begin_transfer(transfer, body);
        transfer->is_broken = true;
    }
    transfer->is_refused = false;
    transfer->cancelled_in = 0;
}

/* The transfer of a new piece; NULL: it has none, because it is the only piece. Behind a cancel in the same
 * list, written data begin anew. */
static transfer_t *
transfer_for(const sis_body_t *body, const subject_t *subject, bool is_last)
{
    const sis_exchange_t *exchange = body->record->exchange;
    transfer_t *transfer = find_transfer(exchange, subject);
    bool is_after = transfer != NULL && !body->is_reaction && transfer->cancelled_in == exchange->command_in;
    bool is_apart;

    if (is_after) {
        end_with_note(body, transfer, "cancelled");
    } else if (transfer != NULL) {
        if (transfer->is_refused || transfer->cancelled_in != 0)
            follow_break(transfer, body, is_last);
        return transfer;
    }
    is_apart = is_under_way_apart(exchange, subject);
    if (is_last && !is_apart)
        return NULL;
    transfer = open_transfer(body, subject);
    begin_transfer(transfer, body);
    transfer->is_broken = is_apart; /* it may be a later piece of those */
    transfer->begun_after = is_after ? exchange->command_in : 0;
    return transfer;
}

/* A step again adds nothing to its transfer, which may be over. */
static void
note_repeated(const sis_body_t *body, const subject_t *subject)
{
    const transfer_t *transfer = find_transfer(body->record->exchange, subject);
    uint32_t number = transfer != NULL ? transfer->number : sis_request_of(body)->transfer;
    sis_rare_t *rare;

    if (number == 0)
        return;
    rare = sis_make_rare(body->record, body->element);
    rare->transfer = number;
    rare->is_piece_repeated = true;
    rare->is_piece_missing = transfer != NULL && transfer->is_broken;
    rare->is_doubtful = transfer != NULL && transfer->is_doubtful;
}

/* The transfer of these data; decided once, in the order of the capture. Returns the number of the piece. */
static unsigned
place_piece(const sis_body_t *body, const subject_t *subject, bool is_last)
{
    const sis_exchange_t *exchange = body->record->exchange;
    transfer_t *transfer = transfer_for(body, subject, is_last);
    sis_rare_t *rare;
    unsigned number;

    if (transfer == NULL)
        return 0;
    sis_request_of(body)->transfer = transfer->number;
    if (is_piece_missing(body->record, transfer) ||
        transfer->received + sis_left(body) > SIS_MOST_LIST + LENGTH_WORDS ||
        transfer->pieces == SIS_MOST_PIECES)
        transfer->is_broken = true;
    transfer->last_in = body->pinfo->num;
    transfer->damaged_count = exchange->stream->bus->damaged_count;
    transfer->received += sis_left(body);
    number = transfer->pieces++;
    rare = sis_make_rare(body->record, body->element);
    rare->transfer = transfer->number;
    rare->is_piece_missing = transfer->is_broken;
    rare->is_doubtful = transfer->is_doubtful;
    rare->is_begun_anew = is_last && transfer->is_begun_anew;
    if (is_last)
        end_transfer(transfer);
    return number;
}

/* The data of a restarted transfer, compared with its announced length. */
static void
check_announced(sis_body_t *body, tvbuff_t *whole)
{
    unsigned length = tvb_captured_length(whole), announced;

    if (!sis_rare(body->record, body->element)->is_begun_anew || length < LENGTH_WORDS)
        return;
    announced = tvb_get_letohs(whole, 0) + LENGTH_WORDS;
    if (announced != length)
        sis_mark(body, &ei_sis_body_note, "not as many bytes as the list announces");
}

/* The number of the piece counts only in the first pass. */
static tvbuff_t *
put_together(sis_body_t *body, tvbuff_t *piece, unsigned number, bool is_last)
{
    const sis_rare_t *rare = sis_rare(body->record, body->element);
    tvbuff_t *whole;

    body->item = body->root;
    if (rare->is_piece_missing)
        sis_mark(body, &ei_sis_sequence_piece_missing, "a piece may be missing");
    if (rare->is_doubtful)
        sis_mark(body, &ei_sis_body_note,
                 "a cancel was not confirmed: it is not known whether the transfer goes on");
    if (rare->is_piece_missing || rare->is_piece_repeated)
        return NULL;
    whole =
        sis_put_together(SIS_PIECES_OF_SIS, body->tree, body->pinfo, piece, rare->transfer, number, is_last);
    if (whole != NULL)
        check_announced(body, whole);
    return whole;
}

/* First pass: finds the transfer of these data. Only its last piece may be empty. Returns the number of the
 * piece. */
static unsigned
learn_piece(const sis_body_t *body, bool is_last)
{
    const sis_exchange_t *exchange = body->record->exchange;
    subject_t subject = subject_of(sis_request_of(body), is_in_list(body));

    if (sis_left(body) == 0 && find_transfer(exchange, &subject) == NULL &&
        !is_under_way_apart(exchange, &subject))
        return 0;
    if (!is_taken_before(body))
        return place_piece(body, &subject, is_last);
    note_repeated(body, &subject);
    return 0;
}

tvbuff_t *
sis_sequence_data(sis_body_t *body, bool is_last)
{
    tvbuff_t *alone = tvb_new_subset_length(body->tvb, body->offset, sis_left(body));
    unsigned number = 0;

    if (sis_has_exchange(body) && !body->pinfo->fd->visited)
        number = learn_piece(body, is_last);
    if (sis_is_piece(body))
        return put_together(body, alone, number, is_last);
    return is_last ? alone : NULL;
}

bool
sis_is_piece(const sis_body_t *body)
{
    return body->record != NULL && sis_rare(body->record, body->element)->transfer != 0;
}

bool
sis_is_doubtful(const sis_body_t *body)
{
    return body->record != NULL && sis_rare(body->record, body->element)->is_doubtful;
}

/* A list with an announced length may continue after 0xF8, or restart. */
static void
refuse(const sis_body_t *body, transfer_t *transfer, sis_request_t *asked)
{
    if (body->status != INVALID_SEQUENTIAL_TELEGRAM || transfer->announced == 0) {
        end_with_note(body, transfer, "refused");
        return;
    }
    note_end(body, transfer, "refused");
    transfer->is_refused = true;
    asked->is_to_be_repeated = true;
}

static uint8_t
master_of(const sis_exchange_t *exchange)
{
    const sis_stream_key_t *key = &exchange->stream->key;

    return exchange->direction == 0 ? key->low : key->high;
}

/* Whether a cancel reaches the station of another command of the same master: only the master that transfers
 * cancels (chapter 4). 254 reaches all of one level, 255 lower levels, too (fig. 2-9). Where the members of a
 * group are is not known. */
static bool
reaches(const sis_exchange_t *cancel, const sis_exchange_t *other)
{
    unsigned routers = cancel->path_length - 1u;

    if (sis_is_answered(cancel->station))
        return sis_exchange_direction(cancel) == sis_exchange_direction(other);
    if (cancel->stream->key.is_before != other->stream->key.is_before ||
        master_of(cancel) != master_of(other) || other->path_length <= routers ||
        memcmp(cancel->path, other->path, routers) != 0)
        return false;
    return sis_receiver_kind(cancel->station) != SIS_LEVEL_BROADCAST || other->path_length == routers + 1;
}

/* Device and service may be missing; one byte alone may be either (chapter 4). */
static bool
is_cancelled(const sis_request_t *cancel, const transfer_t *transfer)
{
    bool is_device = transfer->subject.device == cancel->device,
         is_service = transfer->subject.service == cancel->subservice;

    if (cancel->has_device && cancel->has_subservice)
        return is_device && is_service;
    if (cancel->is_ambiguous)
        return transfer->subject.device == cancel->subservice || is_service;
    return true;
}

/* A reaction that says that the command was not executed, because the channel was busy or the telegram had an
 * error (0xF1 to 0xF4): it will be repeated. */
static bool
is_to_be_repeated(const sis_body_t *body)
{
    return (body->status == 0x02 && body->error != CANCELLED) || body->error == SERVICE_CHANNEL_BUSY ||
           body->error == PARAMETER_OCCUPIED || (body->status >= 0xF1 && body->status <= 0xF4);
}

/* Whether a transfer began behind this cancel, in the same list, or the one which that list repeats. */
static bool
is_begun_after(const transfer_t *transfer, const sis_exchange_t *cancel, bool is_reaction)
{
    bool is_again = cancel->first != NULL;
    uint32_t list_in = is_again ? cancel->first->command_in : cancel->command_in;

    return transfer->begun_after == list_in && transfer->cancelled_in == 0 && (is_reaction || is_again);
}

/* A broadcast is not answered: each station obeys. A command to one station, or a group, leaves it open.
 * After a telegram error it was not executed (chapter 2.3), nor while the channel was busy. */
static void
cancel_transfer(const sis_body_t *body, transfer_t *transfer)
{
    const sis_exchange_t *exchange = body->record->exchange;
    sis_address_kind_t kind = sis_receiver_kind(exchange->station);

    if (is_begun_after(transfer, exchange, body->is_reaction))
        transfer->is_broken |= body->status != 0; /* perhaps it did not begin there */
    else if (body->is_reaction ? body->status == 0
                               : kind == SIS_LEVEL_BROADCAST || kind == SIS_GLOBAL_BROADCAST)
        end_with_note(body, transfer, "cancelled");
    else if (!body->is_reaction && transfer->cancelled_in == 0)
        transfer->cancelled_in = exchange->command_in;
    else if ((body->status >= TELEGRAM_ERROR || is_to_be_repeated(body)) &&
             transfer->cancelled_in == exchange->command_in)
        transfer->cancelled_in = 0;
}

static void
watch_cancel(const sis_body_t *body, const sis_request_t *cancel)
{
    const sis_exchange_t *exchange = body->record->exchange;
    transfer_t *next;

    for (transfer_t *transfer = exchange->stream->bus->open; transfer != NULL; transfer = next) {
        next = transfer->next;
        if (reaches(exchange, transfer->exchange) && is_cancelled(cancel, transfer))
            cancel_transfer(body, transfer);
    }
}

/* Whether the list that is answered has a step of this transfer. */
static bool
is_step_in_list(const sis_body_t *body, const transfer_t *transfer)
{
    const sis_request_t *asked = body->element != 0 ? body->record->exchange->request->list : NULL;

    while (asked != NULL) {
        subject_t subject = subject_of(asked, true);

        if (is_same(&subject, &transfer->subject))
            return true;
        asked = asked->next;
    }
    return false;
}

/* A device has one transfer at a time: a successful access to another parameter has ended the first. Those of
 * one list go on together: the station executes all of it (chapter 7). */
static void
end_others(const sis_body_t *body, const subject_t *subject)
{
    const sis_exchange_t *exchange = body->record->exchange;
    transfer_t *next;

    for (transfer_t *transfer = exchange->stream->bus->open; transfer != NULL; transfer = next) {
        next = transfer->next;
        if (is_between(transfer, exchange) && transfer->subject.device == subject->device &&
            !is_same(&transfer->subject, subject) && !is_step_in_list(body, transfer))
            end_with_note(body, transfer, "another access to the device came between");
    }
}

static void
watch_access(const sis_body_t *body, sis_request_t *asked)
{
    subject_t subject = subject_of(asked, is_in_list(body));
    transfer_t *transfer = find_transfer(body->record->exchange, &subject);

    asked->is_to_be_repeated = is_to_be_repeated(body);
    if (body->status == 0)
        end_others(body, &subject);
    else if (transfer != NULL && !asked->is_to_be_repeated)
        refuse(body, transfer, asked);
}

/* Nobody knows which command an element answers: it may have a piece of any transfer of its service. */
static void
lose_piece(const sis_body_t *body)
{
    const sis_exchange_t *exchange = body->record->exchange;

    for (transfer_t *transfer = exchange->stream->bus->open; transfer != NULL; transfer = transfer->next)
        transfer->is_broken |= is_between(transfer, exchange) && transfer->subject.is_in_list &&
                               transfer->subject.service == body->service;
}

/* The reaction to a service, or to a list that was refused with it. */
static void
watch_reaction(const sis_body_t *body, sis_request_t *asked)
{
    if (asked->service == SIS_CANCEL)
        watch_cancel(body, asked);
    else if (sis_has_control_byte(asked->service))
        watch_access(body, asked);
}

void
sis_sequence_learn(const sis_body_t *body)
{
    bool is_without_elements = body->status >= TELEGRAM_ERROR || body->error != 0;

    if (!body->is_reaction && body->service == SIS_CANCEL)
        watch_cancel(body, body->request);
    if (body->is_reaction && body->asked == NULL && body->element != 0)
        lose_piece(body);
    if (!body->is_reaction || body->asked == NULL)
        return;
    if (body->service != SIS_LIST)
        watch_reaction(body, body->asked);
    else if (is_without_elements)
        for (sis_request_t *asked = body->asked->list; asked != NULL; asked = asked->next)
            watch_reaction(body, asked);
}

/* The latest first, as they were noted. */
void
sis_sequence_show(sis_body_t *body)
{
    const sis_ended_t *ended = sis_rare(body->record, body->element)->ended;
    const char *reason = NULL;

    body->item = body->root;
    for (; ended != NULL; ended = ended->next) {
        add_generated(body->tree, hf_sis_sequence_begun_in, body->tvb, ended->begun_in);
        if (ended->reason != reason)
            sis_mark(body, &ei_sis_sequence_ended, "transfer ended unfinished: %s", ended->reason);
        reason = ended->reason;
    }
}
