/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the first pass finds out about telegrams (learn.c). All that shows a telegram only reads it. */

#ifndef SIS_RECORD_H
#define SIS_RECORD_H

#include "parameters/parameters.h"
#include "sis/routes.h"
#include "sis/telegram.h"

/* What a command asks for. Its reaction repeats only part of it. */
typedef struct sis_request {
    uint8_t service;
    uint8_t subservice;
    uint8_t element;
    uint8_t device;
    uint8_t phase;
    bool has_device : 1;
    bool has_subservice : 1; /* of 0x01: the service to cancel */
    bool is_ambiguous : 1;   /* of 0x01: whether subservice is that, or the device */
    bool has_ident : 1;
    bool has_address : 1;
    bool has_setting : 1;       /* of 0x03: complete data of the subservice */
    bool is_last : 1;           /* of a parameter: no more pieces follow */
    bool is_to_be_repeated : 1; /* its reaction refuses it, and the same will come again */
    bool is_again : 1;          /* the command before was the same, without a good reaction: the same step */
    bool is_read : 1;           /* all of it: the first pass has seen the command */
    uint16_t test_ms;
    sis_ident_t ident;
    uint32_t address; /* of the memory */
    uint32_t setting; /* of 0x03: ms or Bd; of Read flash: bytes */
    uint32_t segment; /* of a list: requested offset and length; 0: all of it */
    /* Known about the parameter when the command was sent; NULL: nothing. */
    const sis_known_t *known;
    const struct sis_twin *twin; /* the same of a device of its type; NULL: nothing */
    const uint8_t *written;      /* all data of a parameter, in file scope; NULL: not written, or unknown */
    unsigned written_length;
    uint32_t transfer;        /* of sequential telegrams, this is a step of it; 0: none */
    struct sis_request *next; /* of the following element of service 0x04 */
    struct sis_request *list; /* of the first element of service 0x04, or the next subservice of 0x03 */
} sis_request_t;

/* A phase switch under way (chapter 8.5). */
typedef struct {
    uint32_t command_in; /* 0: none */
    int64_t begin;       /* ns since 1970 */
    uint8_t to;
} sis_switch_t;

/* Data of commands through routers only. */
typedef struct {
    sis_waiting_t waiting;          /* for the next router's version */
    struct sis_exchange *above;     /* the same exchange one level above; NULL: none */
    struct sis_exchange *forwarded; /* and one level below */
} sis_routing_t;

/* A command and its reaction, as far as the capture has them. Lives as long as the file. A capture has
 * millions, so the fields leave no gaps. */
typedef struct sis_exchange {
    struct sis_stream *stream;
    struct sis_exchange *first; /* the first of the same commands, which this repeats; NULL: none */
    struct sis_exchange *again; /* the next repeat; NULL: none */
    sis_routing_t *routing;     /* NULL: no router */
    sis_request_t *request;
    int64_t command_end;   /* when its last character came, ns since 1970 */
    int64_t reaction_time; /* ns, valid if has_time */
    int64_t wait;          /* TwM, ns: of a repeat, or after a broadcast; negative: none, or not measured */
    uint32_t command_in;
    uint32_t reaction_in;      /* 0: none */
    uint32_t next_command_in;  /* the master continued without a reaction; 0: no */
    uint32_t gave_up;          /* the master's command before, unanswered until now; 0: none */
    uint32_t command_duration; /* ns */
    uint32_t command_spread;   /* ns: so much earlier its last character can have come; UINT32_MAX: unknown */
    uint8_t path[8];           /* from the receiver through subaddresses to the addressed station */
    uint8_t path_length;
    uint8_t station;         /* the final receiver */
    uint8_t gave_up_station; /* the receiver of `gave_up` */
    uint8_t direction;       /* in its stream */
    bool has_time;
    bool is_measured;         /* reaction_time: command and reaction came in different reads */
    bool is_reaction_damaged; /* uncertain: a damaged telegram came before the next command */
    bool needs_reaction;      /* no group or broadcast, and no token, which is not specified */
    bool is_reaction_kept; /* its telegram number is that of the command before: the slave sends what it sent
                              then */
    bool is_kept_reaction_seen;
} sis_exchange_t;

/* A transfer of sequential telegrams that ended before its last piece. */
typedef struct sis_ended {
    const struct sis_ended *next; /* that ended at the same step */
    uint32_t begun_in;
    const char *reason;
} sis_ended_t;

/* What is known of a reaction that belongs to no exchange. */
typedef enum {
    SIS_UNASKED,
    SIS_TO_DAMAGED, /* a damaged command, as a point-to-point station answers it */
    SIS_OWN_NUMBER, /* a command to the point-to-point address, answered with another one */
} sis_origin_t;

/* Two master control words to the same drive. */
typedef struct {
    uint32_t frame; /* the one before */
    int64_t ns;     /* from beginning to beginning */
    sis_span_t span;
} sis_cycle_t;

/* The results of the first pass that few telegrams have: that of a telegram, or of an element of a list. */
typedef struct sis_rare {
    struct sis_rare *next;            /* of the same telegram */
    const sis_ended_t *ended;         /* the transfers that this ended, unfinished; NULL: none */
    const sis_switch_t *phase_switch; /* the switch that this polls; NULL: none */
    unsigned element;                 /* its number in the list; 0: the telegram itself */
    uint32_t transfer;                /* number of the transfer that this is a piece of; 0: none */
    bool is_piece_repeated;
    bool is_piece_missing;
    bool is_doubtful;   /* whether the transfer went on */
    bool is_begun_anew; /* the transfer of this last piece, after a refused one */
    bool is_switch_end; /* it ended here, successfully or not */
    /* Only of the telegram itself: */
    sis_origin_t origin;
    uint32_t damaged_in;      /* of a reaction: the damaged command that it answers; 0: not known */
    uint32_t routed_from;     /* of a reaction: the one from one level below */
    const sis_cycle_t *cycle; /* of the master control word; NULL: none */
} sis_rare_t;

/* The results of the first pass for one telegram. A capture has millions, so what few have is elsewhere. */
typedef struct sis_record {
    struct sis_record *next;             /* of the next telegram in the same packet; NULL: none */
    sis_exchange_t *exchange;            /* NULL: a damaged telegram, or a reaction without a command */
    const struct sis_settings *settings; /* valid for this telegram; NULL: none */
    sis_rare_t *rare;                    /* NULL: none of them; see sis_rare() */
    uint32_t reaction_before;            /* the command had been answered already, in this packet */
    float load;                          /* percent; negative: not known */
    uint8_t service;                     /* identifies the telegram in later passes */
    bool is_reaction;
    bool is_swapped; /* a reaction with its command's addresses swapped: its sender really sent it */
} sis_record_t;

_Static_assert(sizeof(sis_record_t) <= 48, "one byte more costs 16 bytes a telegram");

/* The record of the next telegram of this packet, as the first pass found it; NULL: none. */
sis_record_t *sis_record_next(packet_info *pinfo);

/* First pass: adds that record. */
sis_record_t *sis_record_add(packet_info *pinfo, const sis_telegram_t *telegram);

/* What few telegrams have, to read: of one service of the telegram, by its element; 0: of the telegram
 * itself. Never NULL. */
const sis_rare_t *sis_rare(const sis_record_t *record, unsigned element);

/* First pass: the same, to write. */
sis_rare_t *sis_make_rare(sis_record_t *record, unsigned element);

/* A request of a service. `same`: the one of the command before, if that had the same bytes and this may be
 * the same step of a transfer, which writes the same; else NULL. */
sis_request_t *
sis_request_new(wmem_allocator_t *scope, uint8_t service, const sis_request_t *same, bool is_repeat);

/* The same exchange one level above and one level below, if there are routers; NULL: none is known. */
sis_exchange_t *sis_exchange_above(const sis_exchange_t *exchange);
sis_exchange_t *sis_exchange_below(const sis_exchange_t *exchange);

#endif
