/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Chooses the file that decodes a service; decodes the status byte at the beginning; and decodes service
 * 0x04, a list of services (chapter 7), whose elements stand for telegrams. */
#include "sis/body.h"

#include "protocol/services.h"
#include "sis/learn.h"
#include "sis/names.h"
#include "sis/sequence.h"
#include "sis/services/services.h"
#include "sis/told.h"

static void dissect_list(sis_body_t *body);

typedef void (*body_dissector_t)(sis_body_t *body);

static const struct {
    uint8_t service;
    body_dissector_t dissect;
} services[] = {
    {0x00, sis_dissect_identification}, {0x01, sis_dissect_cancel},    {0x02, sis_dissect_flash},
    {0x03, sis_dissect_initialization}, {0x04, dissect_list},          {0x10, sis_dissect_parameter},
    {0x11, sis_dissect_parameter},      {0x12, sis_dissect_phase},     {0x1D, sis_dissect_phase},
    {0x1E, sis_dissect_parameter},      {0x1F, sis_dissect_parameter},
};

static void
take_status(sis_body_t *body)
{
    uint8_t status, general = sis_general_service(body->service);
    const char *text = NULL;

    if (!sis_needs(body, hf_sis_status, 1))
        return;
    status = compat_get_uint8(body->tvb, body->offset);
    if (general == 0x12 || general == 0x1D)
        text = try_val_to_str(status, sis_status_phase);
    if (text == NULL)
        text = rval_to_str_const(status, sis_status, "");
    sis_tell(body->pinfo, hf_sis_status, status);
    body->status = status;
    body->item = proto_tree_add_uint_format_value(body->tree, hf_sis_status, body->tvb, body->offset, 1,
                                                  status, "%s (0x%02x)", text, status);
    body->offset++;
    body->status_text = text;
    body->status_item = body->item;
}

/* An error code says more, and is an item of its own. */
static void
mark_status(const sis_body_t *body)
{
    if (body->status == 0 || body->is_explained)
        return;
    expert_add_info_format(body->pinfo, body->status_item,
                           body->status < 0xF0 ? &ei_sis_status_execution_error
                                               : &ei_sis_status_telegram_error,
                           "Status: %s", body->status_text);
    wmem_strbuf_append_printf(body->marks, "  [status: %s]", body->status_text);
}

/* Some product groups send ASCII records (chapter 2.1). */
static bool
is_plain_text(const sis_body_t *body)
{
    for (unsigned i = body->offset; i < body->end; i++) {
        uint8_t c = compat_get_uint8(body->tvb, i);

        if (!g_ascii_isprint(c) && !g_ascii_isspace(c))
            return false;
    }
    return sis_left(body) > 0 && g_ascii_isprint(compat_get_uint8(body->tvb, body->offset));
}

static void
dissect_undocumented(sis_body_t *body)
{
    if (body->is_reaction && sis_has_status(body->service) && sis_take_channel_error(body))
        return;
    if (sis_take_rest(body, hf_sis_raw))
        sis_mark(body, &ei_sis_body_note, "no document says what is in it");
    else if (body->service < SIS_TOKEN_PASSING && !body->is_cut)
        sis_mark(body, &ei_sis_body_note, "no document defines this service");
}

static const sis_layouts_t by_layout[] = {SIS_SERVICES_BY_LAYOUT};

static const sis_layouts_t *
find_layouts(uint8_t service)
{
    for (unsigned i = 0; by_layout[i].layouts != NULL; i++) {
        if (by_layout[i].service == service)
            return &by_layout[i];
    }
    return NULL;
}

static void
dissect_by_layout(sis_body_t *body)
{
    uint32_t subservice = 0;

    if (sis_subservices_of(body->service) == NULL || sis_take_subservice(body, &subservice))
        sis_take_layout_or_error(body, find_layouts(body->service), subservice);
}

/* NULL: the documents do not describe its contents. */
static body_dissector_t
find_dissector_of(uint8_t service)
{
    uint8_t general = sis_general_service(service);

    for (unsigned i = 0; i < array_length(services); i++) {
        if (services[i].service == general)
            return services[i].dissect;
    }
    return find_layouts(service) != NULL ? dissect_by_layout : NULL;
}

/* Bytes that no field has used: an incomplete field, or more than the service has. */
static void
show_leftover(sis_body_t *body)
{
    unsigned left = sis_left(body);

    if (left == 0)
        return;
    body->item = proto_tree_add_item(body->tree, hf_sis_raw, body->tvb, body->offset, left, ENC_NA);
    if (!body->is_short && !body->is_cut)
        sis_mark(body, &ei_sis_body_unexpected, "more bytes than this service has");
    body->offset = body->end;
}

static void
decode(sis_body_t *body)
{
    body_dissector_t dissect = find_dissector_of(body->service);
    bool is_product_group = body->service >= 0x80 && !sis_service_is_reserved(body->service);

    if (dissect == NULL && is_product_group && is_plain_text(body)) {
        sis_take_text(body, hf_sis_text); /* without a status */
        return;
    }
    if (body->is_reaction && sis_has_status(body->service))
        take_status(body);
    /* After a telegram error even the useful data header may be missing. */
    if (!body->is_short && (body->status < 0xF0 || sis_left(body) > 0))
        (dissect != NULL ? dissect : dissect_undocumented)(body);
    mark_status(body);
}

/* Decodes it, learns from it, and shows what is known by then. */
void
sis_dissect_body(sis_body_t *body)
{
    bool has_exchange = sis_has_exchange(body);

    decode(body);
    if (has_exchange) {
        sis_learn_body(body);
        sis_show_switch(body);
    }
    show_leftover(body);
    if (has_exchange)
        sis_sequence_show(body);
}

/* The elements of a command that no element of the reaction has answered yet. */
typedef struct {
    sis_request_t *next;
    bool is_each_answered; /* there are as many in the reaction */
    bool is_one_missing;   /* there are fewer */
    bool is_one_unknown;   /* an element of the reaction may have failed, or has */
} commands_t;

/* Whether an element of a reaction, `length` bytes after its service, may answer this command: as whole
 * telegrams are compared (exchange.c). */
static bool
is_answer_to(const sis_request_t *command, const sis_body_t *list, uint8_t service, unsigned length)
{
    uint8_t first, second; /* after the status */

    if (command->service != service)
        return false;
    if (!command->has_device || length < 3)
        return true;
    first = compat_get_uint8(list->tvb, list->offset + 1);
    second = compat_get_uint8(list->tvb, list->offset + 2);
    if (sis_has_control_byte(service))
        return command->element == SIS_ELEMENT_OF(first) && command->device == second;
    return sis_may_answer_subservice(service, command->subservice, second);
}

static sis_request_t *
find_command(sis_request_t *from, const sis_body_t *list, uint8_t service, unsigned length)
{
    while (from != NULL && !is_answer_to(from, list, service, length))
        from = from->next;
    return from;
}

/* What the exchange keeps for an element; of a command, in the second pass, it is the next one. No document
 * says whether a station may leave elements out. If it did, an element that fits two commands belongs to
 * neither. */
static sis_request_t *
take_command(commands_t *commands, const sis_body_t *list, uint8_t service, unsigned length)
{
    sis_request_t *command = commands->next;

    if (list->is_reaction)
        command = find_command(command, list, service, length);
    if (command == NULL)
        return NULL;
    if (list->is_reaction && !commands->is_each_answered &&
        find_command(command->next, list, service, length) != NULL)
        return NULL;
    commands->next = command->next;
    return command;
}

/* The body of an element, `length` bytes after its service, as if it were alone in a telegram. */
static void
dissect_element_body(sis_body_t *list, proto_item *root, unsigned number, uint8_t service, unsigned length,
                     commands_t *commands)
{
    wmem_allocator_t *pool = list->pinfo->pool;
    sis_body_t element = {.telegram = list->telegram,
                          .tvb = list->tvb,
                          .pinfo = list->pinfo,
                          .tree = list->tree,
                          .root = root,
                          .item = root,
                          .offset = list->offset,
                          .end = list->offset + length,
                          .element = number,
                          .is_cut = list->is_cut && list->offset + length == list->end,
                          .is_reaction = list->is_reaction,
                          .service = service,
                          .record = list->record,
                          .summary = wmem_strbuf_new(pool, sis_service_name(pool, service)),
                          .marks = wmem_strbuf_new(pool, ""),
                          .asked = take_command(commands, list, service, length)};

    if (list->is_reaction && list->asked != NULL && element.asked == NULL) {
        list->item = root;
        sis_mark(list, &ei_sis_body_note, "which element of the command this answers is unknown");
    }
    if (!list->is_reaction)
        element.request = sis_request_add(list, service);
    sis_dissect_body(&element);
    if (element.error_text != NULL) {
        sis_error_t error = {element.error, element.error_text, list->errors};

        list->errors = wmem_memdup(pool, &error, sizeof error);
    }
    commands->is_one_unknown |= element.status != 0 || !sis_has_status(service);
    if (list->is_reaction && list->status == 0 && element.status != 0) {
        list->item = root;
        sis_mark(list, &ei_sis_body_note, "the overall status is 0, that of this element is not");
    }
    if (list->status < 0xF0) /* else it has data of its own */
        list->is_explained |= element.is_explained || element.status != 0;
    proto_item_append_text(root, ": %s%s", wmem_strbuf_get_str(element.summary),
                           wmem_strbuf_get_str(element.marks));
    sis_say_words(list, "; ", wmem_strbuf_get_str(element.summary), wmem_strbuf_get_str(element.marks), NULL);
}

/* The following elements still have their commands. */
static void
show_recursion(sis_body_t *list, unsigned length, commands_t *commands)
{
    commands->is_one_unknown = true;
    take_command(commands, list, SIS_LIST, length);
    if (!list->is_reaction)
        sis_request_add(list, SIS_LIST);
    sis_mark(list, &ei_sis_list_recursion, "a list in a list");
    if (length > 0)
        proto_tree_add_item(list->tree, hf_sis_raw, list->tvb, list->offset, length, ENC_NA);
}

/* Length, service, body. */
static void
dissect_element(sis_body_t *list, unsigned number, commands_t *commands)
{
    unsigned there = sis_left(list), length = compat_get_uint8(list->tvb, list->offset);
    unsigned end = MIN(length + 1, there);
    proto_item *root;
    proto_tree *outer = list->tree;
    uint32_t service;

    list->tree = proto_tree_add_subtree_format(outer, list->tvb, list->offset, end, ett_sis_element, &root,
                                               "Element %u", number);
    sis_take(list, hf_sis_element_length, 1, NULL);
    if (length == 0) {
        sis_mark(list, &ei_sis_body_unexpected, "an element is empty");
    } else if (sis_take(list, hf_sis_service, 1, &service)) {
        if (length + 1 > there && !list->is_cut) {
            sis_mark(list, &ei_sis_body_missing, "an element is cut");
            list->is_cut = true; /* so its missing field has no note */
        }
        sis_tell(list->pinfo, hf_sis_service, service);
        if (service == SIS_LIST)
            show_recursion(list, end - 2, commands);
        else
            dissect_element_body(list, root, number, (uint8_t)service, end - 2, commands);
        list->offset += end - 2;
    }
    list->tree = outer;
}

/* The commands of a list that a reaction answers. */
static commands_t
commands_of(const sis_body_t *list)
{
    commands_t commands = {.next = list->asked != NULL ? list->asked->list : NULL};
    const sis_request_t *command = commands.next;
    unsigned at = list->offset;

    while (at < list->end) {
        uint8_t length = compat_get_uint8(list->tvb, at);

        at += 1 + length;
        if (length == 0) /* no element */
            continue;
        if (command == NULL)
            return commands; /* more than there are commands */
        command = command->next;
    }
    commands.is_each_answered = command == NULL;
    commands.is_one_missing = command != NULL;
    return commands;
}

#define SHORTEST_ELEMENT 3
#define CHANNEL_CODE     2 /* bytes */

/* Service 0x04 has no codes of its own: its overall status is 0 or 1, and its list follows also after an
 * error (chapter 7.1). Only the codes of the channel are those of all services (fig. 2-19). Tell whether no
 * list follows. */
static bool
take_overall_error(sis_body_t *body)
{
    unsigned left = sis_left(body);

    if (body->status != 0x02 || left < CHANNEL_CODE ||
        (left == CHANNEL_CODE &&
         try_val_to_str(tvb_get_letohs(body->tvb, body->offset), sis_errors_channel) != NULL))
        return sis_take_channel_error(body);
    body->item = body->root;
    sis_mark(body, &ei_sis_body_note, "the overall status of a list is 0 or 1");
    if (left < SHORTEST_ELEMENT)
        sis_take_rest(body, hf_sis_raw);
    return left < SHORTEST_ELEMENT;
}

static void
dissect_list(sis_body_t *body)
{
    commands_t commands;

    if (body->is_reaction && take_overall_error(body))
        return;
    if (sis_left(body) == 0 && !body->is_cut)
        sis_mark(body, &ei_sis_body_note, "an empty list");
    commands = commands_of(body);
    for (unsigned number = 1; sis_left(body) > 0 && !body->is_short; number++)
        dissect_element(body, number, &commands);
    if (commands.is_one_missing && !body->is_cut) {
        body->item = body->root;
        sis_mark(body, &ei_sis_body_note, "fewer elements than asked for");
    }
    if (body->status == 0x01 && commands.is_each_answered && !commands.is_one_unknown && !body->is_cut) {
        body->item = body->root;
        sis_mark(body, &ei_sis_body_note, "the overall status is 1, but nothing in the list failed");
    }
}
