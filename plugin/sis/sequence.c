/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Sequential telegrams: long data are read or written in pieces (chapters 8.2 and 8.7). Bit 2 of the
 * parameter control says whether more follow. Nothing marks the first piece or numbers the pieces. */
#include "sis/sequence.h"

#include "items.h"
#include "protocol/limits.h"
#include "sis/names.h"
#include "sis/pieces.h"

#define SERVICE_CHANNEL_BUSY 0x8001 /* the command was not executed, and must be repeated */
#define PARAMETER_OCCUPIED   0x800C
#define CANCELLED            0x800B /* another request had priority: the transfer has ended */

#define INVALID_SEQUENTIAL_TELEGRAM 0xF8

#define LENGTH_WORDS 4u /* of a list: actual and maximum length, two bytes each */

/* A transfer under way, from one station to another. */
typedef struct sis_transfer {
    struct sis_transfer *next;
    uint8_t service;
    sis_subject_t subject;
    uint32_t number;
    uint32_t begun_in;
    uint32_t last_in;       /* the latest piece */
    uint32_t damaged_count; /* of its bus, then */
    uint32_t received;      /* bytes */
    uint32_t pieces;        /* reassembled so far */
    uint32_t announced;     /* bytes, by the length words of a list; 0: unknown */
    uint32_t length_words;  /* as they are, if a length is known */
    bool is_broken;         /* a piece may be missing: reassembly has ended */
    bool is_refused;        /* after 0xF8: it restarts or continues */
    bool is_begun_anew;
} transfer_t;

static transfer_t **
transfers_of(const sis_exchange_t *exchange)
{
    return &exchange->stream->from[exchange->direction].transfers;
}

static bool
is_same_transfer(const transfer_t *a, const transfer_t *b)
{
    const sis_subject_t *one = &a->subject, *other = &b->subject;

    return a->service == b->service && one->element == other->element && one->device == other->device &&
           one->ident.type == other->ident.type && one->ident.number == other->ident.number &&
           one->segment == other->segment;
}

/* The link to this transfer; the end of the list if it is not under way. */
static transfer_t **
find_transfer(const sis_exchange_t *exchange, const transfer_t *like)
{
    transfer_t **link = transfers_of(exchange);

    while (*link != NULL && !is_same_transfer(*link, like))
        link = &(*link)->next;
    return link;
}

static void
end_transfer(transfer_t **link)
{
    transfer_t *transfer = *link;

    *link = transfer->next;
    wmem_free(wmem_file_scope(), transfer);
}

static void
note_end(sis_record_t *record, const transfer_t *transfer, const char *reason)
{
    sis_ended_t *ended;

    if (transfer->is_refused) /* already reported */
        return;
    ended = wmem_new(wmem_file_scope(), sis_ended_t);
    *ended = (sis_ended_t){transfer->begun_in, reason};
    sis_make_rare(record)->ended = ended;
}

static void
end_with_note(sis_record_t *record, transfer_t **link, const char *reason)
{
    note_end(record, *link, reason);
    end_transfer(link);
}

/* Appends a transfer to the list. The length is limited, so the oldest may be dropped. */
static transfer_t *
open_transfer(sis_record_t *record, const transfer_t *like)
{
    transfer_t **link = transfers_of(record->exchange), *transfer;
    unsigned count = 0;

    for (transfer_t *open = *link; open != NULL; open = open->next)
        count++;
    if (count >= SIS_MOST_OPEN)
        end_with_note(record, link, "too many others have begun since");
    while (*link != NULL)
        link = &(*link)->next;
    transfer = *link = wmem_memdup(wmem_file_scope(), like, sizeof *like);
    return transfer;
}

/* A step seen before: the same command again, or its reaction again. */
static bool
is_taken_before(const sis_record_t *record)
{
    const sis_exchange_t *exchange = record->exchange;

    if (record->is_reaction)
        return record->reaction_before != 0 || exchange->is_kept_reaction_seen;
    return exchange->first != NULL || exchange->is_step_again;
}

static unsigned
damaged_since(const transfer_t *transfer, const sis_exchange_t *exchange)
{
    return exchange->stream->bus->damaged_count - transfer->damaged_count;
}

/* Whether a piece may have been lost since the one before: lost characters; the damaged reaction to a
 * command that was then repeated; or a damaged command with its damaged reaction. Not if the slave repeats
 * the reaction that it has kept. */
static bool
is_piece_missing(const sis_record_t *record, const transfer_t *transfer)
{
    const sis_exchange_t *exchange = record->exchange;
    unsigned enough = record->is_reaction && exchange->first != NULL ? 1 : 2;

    if (exchange->stream->bus->lost_in > transfer->last_in)
        return true;
    return !exchange->is_reaction_kept && damaged_since(transfer, exchange) >= enough;
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

/* After 0xF8 a transfer restarts with its length words, or continues. The announced length decides whether
 * it can continue. If neither fits, pieces are missing. */
static void
follow_refusal(transfer_t *transfer, const sis_body_t *body, bool is_last)
{
    unsigned length = sis_left(body), received = transfer->received + length;

    transfer->is_refused = false;
    if (length >= LENGTH_WORDS && tvb_get_letohl(body->tvb, body->offset) == transfer->length_words) {
        begin_transfer(transfer, body);
        transfer->is_begun_anew = true;
    } else if (is_last ? received != transfer->announced : received > transfer->announced) {
        begin_transfer(transfer, body);
        transfer->is_broken = true;
    }
}

/* The transfer of these data; decided once, in the order of the capture. Returns the number of the piece. */
static unsigned
place_piece(const sis_body_t *body, const transfer_t *like, bool is_last)
{
    sis_record_t *record = body->record;
    sis_exchange_t *exchange = record->exchange;
    transfer_t *transfer = *find_transfer(exchange, like);
    unsigned number;

    record->is_piece_repeated = is_taken_before(record);
    if (transfer == NULL && (is_last || record->is_piece_repeated)) {
        record->transfer = record->is_piece_repeated ? exchange->transfer : 0; /* of one that is over */
        return 0;
    }
    if (transfer == NULL) {
        transfer = open_transfer(record, like);
        begin_transfer(transfer, body);
    } else if (transfer->is_refused && !record->is_piece_repeated) {
        follow_refusal(transfer, body, is_last);
    }
    record->transfer = exchange->transfer = transfer->number;
    if (!record->is_piece_repeated && (is_piece_missing(record, transfer) ||
                                       transfer->received + sis_left(body) > SIS_MOST_LIST + LENGTH_WORDS ||
                                       transfer->pieces == SIS_MOST_PIECES))
        transfer->is_broken = true;
    record->is_piece_missing = transfer->is_broken;
    if (record->is_piece_repeated)
        return 0;
    transfer->last_in = body->pinfo->num;
    transfer->damaged_count = exchange->stream->bus->damaged_count;
    transfer->received += sis_left(body);
    record->is_begun_anew = is_last && transfer->is_begun_anew;
    number = transfer->pieces++;
    if (is_last)
        end_transfer(find_transfer(exchange, like));
    return number;
}

/* The data of a restarted transfer, compared with its announced length. */
static void
check_announced(sis_body_t *body, tvbuff_t *whole)
{
    unsigned length = tvb_captured_length(whole), announced;

    if (!body->record->is_begun_anew || length < LENGTH_WORDS)
        return;
    announced = tvb_get_letohs(whole, 0) + LENGTH_WORDS;
    if (announced != length)
        sis_mark(body, &ei_sis_body_note, "not as many bytes as the list announces");
}

/* The number of the piece counts only in the first pass. */
static tvbuff_t *
put_together(sis_body_t *body, tvbuff_t *piece, unsigned number, bool is_last)
{
    const sis_record_t *record = body->record;
    tvbuff_t *whole;

    body->item = body->root;
    if (record->is_piece_missing)
        sis_mark(body, &ei_sis_sequence_piece_missing, "a piece may be missing");
    if (record->is_piece_missing || record->is_piece_repeated)
        return NULL;
    whole = sis_put_together(SIS_PIECES_OF_SIS, body->tree, body->pinfo, piece, record->transfer, number,
                             is_last);
    if (whole != NULL)
        check_announced(body, whole);
    return whole;
}

bool
sis_is_sequence_open(const sis_body_t *body, const sis_subject_t *subject)
{
    transfer_t like = {.service = body->service, .subject = *subject};
    const sis_record_t *record = body->record;

    if (body->is_nested || record == NULL || record->exchange == NULL)
        return false;
    return body->pinfo->fd->visited ? record->transfer != 0 : *find_transfer(record->exchange, &like) != NULL;
}

tvbuff_t *
sis_sequence_data(sis_body_t *body, const sis_subject_t *subject, bool is_last)
{
    sis_record_t *record = body->record;
    tvbuff_t *alone = tvb_new_subset_length(body->tvb, body->offset, sis_left(body));
    unsigned number = 0;

    if (body->is_nested || record == NULL || record->exchange == NULL)
        return is_last ? alone : NULL;
    if (!body->pinfo->fd->visited) {
        transfer_t like = {.service = body->service, .subject = *subject};

        number = place_piece(body, &like, is_last);
    }
    return record->transfer != 0 ? put_together(body, alone, number, is_last) : alone;
}

bool
sis_is_piece(const sis_body_t *body)
{
    return body->record != NULL && body->record->transfer != 0;
}

/* A list with an announced length may continue after 0xF8, or restart. */
static void
refuse(sis_record_t *record, transfer_t **link, uint8_t status)
{
    if (status != INVALID_SEQUENTIAL_TELEGRAM || (*link)->announced == 0) {
        end_with_note(record, link, "refused");
        return;
    }
    note_end(record, *link, "refused");
    (*link)->is_refused = true;
    record->exchange->is_to_be_repeated = true;
}

/* Device and service may be missing; one byte alone may be either (chapter 4). */
static bool
is_cancelled(const sis_request_t *cancel, const transfer_t *transfer)
{
    bool is_device = transfer->subject.device == cancel->device,
         is_service = transfer->service == cancel->subservice;

    if (cancel->has_device && cancel->has_subservice)
        return is_device && is_service;
    if (cancel->is_ambiguous)
        return transfer->subject.device == cancel->subservice || is_service;
    return true;
}

static void
cancel_transfers(sis_record_t *record, const sis_request_t *cancel)
{
    transfer_t **link = transfers_of(record->exchange);

    while (*link != NULL) {
        if (is_cancelled(cancel, *link))
            end_with_note(record, link, "cancelled");
        else
            link = &(*link)->next;
    }
}

/* A device has one transfer at a time: a successful access to another parameter has ended the first. */
static void
end_others(sis_record_t *record, const transfer_t *like)
{
    transfer_t **link = transfers_of(record->exchange);

    while (*link != NULL) {
        if ((*link)->subject.device == like->subject.device && !is_same_transfer(*link, like))
            end_with_note(record, link, "another access to the device came between");
        else
            link = &(*link)->next;
    }
}

static void
watch_reaction(const sis_body_t *body)
{
    sis_record_t *record = body->record;
    const sis_request_t *asked = body->asked;
    transfer_t like = {.service = body->service,
                       .subject = {asked->ident, asked->element, asked->device, asked->segment}};
    transfer_t **link = find_transfer(record->exchange, &like);
    /* Not executed, because the channel was busy or the command was damaged (0xF1, 0xF2, 0xF4): it will be
     * repeated. */
    bool is_to_be_repeated = (body->status == 0x02 && body->error != CANCELLED) ||
                             body->error == SERVICE_CHANNEL_BUSY || body->error == PARAMETER_OCCUPIED ||
                             (body->status >= 0xF1 && body->status <= 0xF4);

    record->exchange->is_to_be_repeated = is_to_be_repeated;
    if (body->status == 0)
        end_others(record, &like);
    else if (*link != NULL && !is_to_be_repeated)
        refuse(record, link, body->status);
}

static void
watch(const sis_body_t *body)
{
    if (!body->is_reaction || body->asked == NULL)
        return;
    if (body->service == 0x01 && body->status == 0)
        cancel_transfers(body->record, body->asked);
    else if (sis_has_control_byte(body->service))
        watch_reaction(body);
}

void
sis_sequence_watch(sis_body_t *body)
{
    const sis_record_t *record = body->record;
    const sis_ended_t *ended;

    if (body->is_nested || record == NULL || record->exchange == NULL)
        return;
    if (!body->pinfo->fd->visited)
        watch(body);
    ended = sis_rare(record)->ended;
    if (ended == NULL)
        return;
    body->item = body->root;
    add_generated(body->tree, hf_sis_sequence_begun_in, body->tvb, ended->begun_in);
    sis_mark(body, &ei_sis_sequence_ended, "transfer ended unfinished: %s", ended->reason);
}
