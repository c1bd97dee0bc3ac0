/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Services 0x10, 0x11, 0x1E, 0x1F and their equivalents of the product groups: SERCOS parameters (chapter
 * 8). */
#include "sis/services/services.h"

#include "parameters/ident.h"
#include "parameters/values.h"
#include "protocol/limits.h"
#include "sis/access.h"
#include "sis/export.h"
#include "sis/station.h"
#include "sis/names.h"
#include "sis/sequence.h"
#include "sis/told.h"

#define DATA_STATUS_UNDEFINED 0xFEF0 /* fig. 8-44 */
#define NO_DRIVE              0
#define UNDEFINED_DEVICE      255

/* A body of a parameter service being decoded. */
typedef struct {
    sis_body_t *body;
    uint8_t general; /* the corresponding general service */
    sis_element_t element;
    bool is_last;
    uint32_t device;
    bool has_ident;
    sis_ident_t ident; /* in a reaction: its command's */
    const char *ident_text;
    sis_known_t known;
    uint32_t segment; /* of a list, as asked for */
} access_t;

static bool
is_segment(const access_t *access)
{
    return access->general == 0x11 || access->general == 0x1E;
}

/* Of the services for segments, only 0x81 has sequential telegrams: the same command is repeated, and bit
 * 2 marks the last reaction. Its pieces may end inside an element (IndraDrive, MPH-02). */
static bool
is_single(const access_t *access)
{
    return is_segment(access) && access->body->service != 0x81;
}

static bool
is_write(const access_t *access)
{
    return access->general == 0x1E || access->general == 0x1F;
}

static void
show_control(const access_t *access)
{
    static int *const bits[] = {&hf_sis_parameter_control_reserved, &hf_sis_element, &hf_sis_transmission,
                                NULL};
    const sis_body_t *body = access->body;

    proto_tree_add_bitmask_list(proto_item_add_subtree(body->item, ett_sis_parameter_control), body->tvb,
                                body->offset - 1, 1, bits, ENC_NA);
    proto_item_append_text(body->item, " (%s, %s)", val_to_str_const(access->element, sis_elements, ""),
                           access->is_last ? "last transmission" : "more follows");
}

/* Fig. 8-2: 1 to 254 are drives. */
static void
check_device(const access_t *access)
{
    sis_body_t *body = access->body;

    if (access->device == NO_DRIVE && body->tree != NULL)
        proto_item_append_text(body->item, " (the SERCOS master, or the drive that is addressed)");
    if (access->device == UNDEFINED_DEVICE)
        sis_mark(body, &ei_sis_body_note, "device address 255 is not defined");
}

/* Only 0x10 and 0x1F have sequential telegrams, and ECODRIVE's 0x81. */
static void
check_control(const access_t *access, uint32_t control)
{
    if (control & SIS_PARAMETER_CONTROL_RESERVED)
        sis_mark(access->body, &ei_sis_body_note, "reserved bits of the parameter control");
    if (is_single(access) && !access->is_last)
        sis_mark(access->body, &ei_sis_body_note, "bit 2 is 0, but this service has no sequential telegrams");
}

static bool
take_control(access_t *access)
{
    sis_body_t *body = access->body;
    uint32_t control;

    if (!sis_take(body, hf_sis_parameter_control, 1, &control))
        return false;
    access->element = (sis_element_t)SIS_ELEMENT_OF(control);
    access->is_last = control & SIS_TRANSMISSION;
    if (body->tree)
        show_control(access);
    check_control(access, control);
    if (!sis_take(body, hf_sis_device, 1, &access->device))
        return false;
    check_device(access);
    if (body->request != NULL) {
        body->request->element = (uint8_t)access->element;
        body->request->is_last = access->is_last || is_single(access);
    }
    sis_request_device(body, access->device);
    return true;
}

static void
say_parameter(const access_t *access)
{
    sis_body_t *body = access->body;
    const char *element = val_to_str_const(access->element, sis_elements, "");

    sis_say_words(body, " ", access->ident_text, NULL);
    if (access->known.name != NULL)
        sis_say_words(body, " (", access->known.name, ")", NULL);
    if (access->element == SIS_ELEMENT_IDENT && is_write(access))
        sis_say_words(body, ", data status", NULL);
    else if (access->element != SIS_ELEMENT_DATA)
        sis_say_words(body, ", ", wmem_ascii_strdown(body->pinfo->pool, element, -1), NULL);
}

/* Everything about a parameter, read from here on or, without a length, recalled. */
static void
show_parameter(const access_t *access, unsigned length)
{
    sis_body_t *body = access->body;
    unsigned offset = length > 0 ? body->offset : 0;
    sis_ident_place_t place = {offset, length, offset, offset + 1, ENC_LITTLE_ENDIAN};

    if (body->tree != NULL)
        body->item =
            sis_add_ident(body->tree, body->pinfo->pool, body->tvb, &place, access->ident, &access->known);
}

static void
know_parameter(access_t *access, sis_ident_t ident)
{
    sis_body_t *body = access->body;

    access->has_ident = true;
    access->ident = ident;
    access->ident_text = sis_ident_text(body->pinfo->pool, ident);
    sis_tell_text(body->pinfo, hf_sis_parameter, access->ident_text);
    access->known = sis_station_known(body, ident, (uint8_t)access->device);
}

/* Only 0 to 2 of the type byte are documented, and bits 3 to 7 are always 0; bit 15 tells S from P. */
static void
check_ident(sis_body_t *body, sis_ident_t ident)
{
    if (ident.type > 7)
        sis_mark(body, &ei_sis_body_note, "reserved bits of the parameter's type");
    else if (ident.type > 2)
        sis_mark(body, &ei_sis_body_note, "parameter type %u is not defined", ident.type);
    if (ident.type > 0 && ident.number & 0x8000)
        sis_mark(body, &ei_sis_body_note, "bit 15 is only defined for parameters of drives");
}

static bool
take_parameter(access_t *access)
{
    sis_body_t *body = access->body;
    unsigned offset = body->offset;

    if (!sis_needs(body, hf_sis_parameter, 3))
        return false;
    know_parameter(access, (sis_ident_t){.type = compat_get_uint8(body->tvb, offset),
                                         .number = tvb_get_letohs(body->tvb, offset + 1)});
    show_parameter(access, 3);
    body->offset += 3;
    say_parameter(access);
    check_ident(body, access->ident);
    if (body->request != NULL) {
        body->request->has_ident = true;
        body->request->ident = access->ident;
    }
    return true;
}

/* 0x81 and 0x8E count offset and length of a segment in words, all others in bytes. */
static bool
counts_words(const sis_body_t *body)
{
    return body->service == 0x81 || body->service == 0x8E;
}

static void
check_announced(sis_body_t *body, unsigned announced)
{
    unsigned sent = sis_left(body);

    if (!body->is_cut && sent > 0 && sent != announced)
        sis_mark(body, sent < announced ? &ei_sis_body_missing : &ei_sis_body_unexpected,
                 "%s bytes than announced", sent < announced ? "fewer" : "more");
}

/* The documents allow no more data in a telegram, some devices do. */
static void
check_most(const access_t *access, unsigned length)
{
    unsigned most = is_write(access) ? SIS_MOST_PARAMETER_WRITTEN : SIS_MOST_PARAMETER_READ;

    if (length > most)
        sis_mark(access->body, &ei_sis_body_note, "more than %u bytes", most);
}

/* Offset and length count words in ECODRIVE's services, bytes in all others. Written data should have the
 * declared length. A SYNAX may be asked for any (its page 2-30), and 0x81 has sequential telegrams. */
static bool
take_segment(access_t *access)
{
    sis_body_t *body = access->body;
    bool is_words = counts_words(body);
    const char *unit = is_words ? "word" : "byte";
    uint32_t offset, length;

    if (!sis_take(body, hf_sis_list_offset, 2, &offset))
        return false;
    proto_item_append_text(body->item, " %s%s", unit, plurality(offset, "", "s"));
    if (!sis_take(body, hf_sis_list_length, 2, &length))
        return false;
    proto_item_append_text(body->item, " %s%s", unit, plurality(length, "", "s"));
    if (body->request != NULL)
        body->request->segment = offset << 16 | length;
    sis_say(body, ", %u %s%s at offset %u", length, unit, plurality(length, "", "s"), offset);
    if (is_single(access) && body->service != 0x91)
        check_most(access, length * (is_words ? 2 : 1));
    if (is_write(access))
        check_announced(body, length * (is_words ? 2 : 1));
    return true;
}

/* The reaction does not name the parameter; its command does. */
static void
recall_parameter(access_t *access)
{
    const sis_request_t *asked = access->body->asked;

    if (asked == NULL || !asked->has_ident)
        return;
    access->segment = asked->segment;
    know_parameter(access, asked->ident);
    show_parameter(access, 0);
    say_parameter(access);
}

#define SHOWN_BYTES 8

/* A request for the data status may repeat the number of its parameter, or have no data (fig. 8-42). */
static void
check_status_request(const access_t *access, tvbuff_t *tvb)
{
    if (access->has_ident &&
        (tvb_captured_length(tvb) != 2 || tvb_get_letohs(tvb, 0) != access->ident.number))
        sis_mark(access->body, &ei_sis_body_note,
                 "a request for the data status carries its own ident number or nothing");
}

/* A list may end before the requested length, and the device may have less room. SYNAX sends one element for
 * any length (its page 2-30). */
static void
check_segment(const access_t *access, unsigned length)
{
    sis_body_t *body = access->body;
    unsigned asked = (access->segment & 0xFFFF) * (counts_words(body) ? 2 : 1);

    if (!is_segment(access) || !body->is_reaction || !access->has_ident || body->is_cut || length == asked ||
        (body->service == 0x91 && length > 0))
        return;
    body->item = body->root;
    sis_mark(body, &ei_sis_body_note, "%s",
             length < asked ? "fewer bytes than asked for" : "more bytes than asked for");
}

/* The data of an element: all of them, or a segment of a list. */
static void
show_data(access_t *access, proto_tree *tree, tvbuff_t *tvb)
{
    sis_body_t *body = access->body;
    sis_place_t place = sis_station_of(body, (uint8_t)access->device);
    sis_element_data_t data = {tvb, ENC_LITTLE_ENDIAN, !is_segment(access), &place};
    unsigned length = tvb_captured_length(tvb);
    const char *text, *misfit;

    if (is_write(access) && access->element == SIS_ELEMENT_IDENT) {
        proto_tree_add_item(tree, hf_sis_data, tvb, 0, length, ENC_NA); /* not a value */
        check_status_request(access, tvb);
        return;
    }
    text = sis_add_element(tree, body->pinfo, &data, access->element,
                           access->has_ident ? &access->ident : NULL, &access->known);
    if (text != NULL) {
        sis_say_words(body, " = ", text, NULL);
    } else {
        sis_say_bytes(body, ", ", length);
        if (length <= SHOWN_BYTES)
            sis_say_words(body, ": ", tvb_bytes_to_str_punct(body->pinfo->pool, tvb, 0, (int)length, ' '),
                          NULL);
    }
    body->data = data.is_whole ? tvb : NULL;
    body->text = text;
    misfit = body->is_cut ? NULL : sis_element_misfit(&data, access->element, &access->known);
    if (misfit != NULL) {
        body->item = body->root;
        sis_mark(body, &ei_sis_body_note, "%s", misfit);
    }
    check_segment(access, length);
    if (access->has_ident && data.is_whole && body->is_reaction)
        body->learn = sis_station_learn;
}

static void
show_piece(access_t *access, tvbuff_t *whole)
{
    sis_body_t *body = access->body;
    unsigned length = sis_left(body);
    proto_tree *tree;

    sis_take_rest(body, hf_sis_data);
    sis_say_bytes(body, access->is_last ? ", last piece of " : ", piece of ", length);
    if (whole == NULL)
        return;
    length = tvb_captured_length(whole);
    tree = proto_tree_add_subtree_format(
        body->tree, whole, 0, -1, ett_sis_whole, NULL, "Data of all pieces%s, %u byte%s",
        sis_is_doubtful(body) ? " if the transfer went on" : "", length, plurality(length, "", "s"));
    if (sis_is_doubtful(body)) {
        proto_tree_add_item(tree, hf_sis_data, whole, 0, -1, ENC_NA);
        return;
    }
    show_data(access, tree, whole);
    if (!is_segment(access))
        sis_export_parameter(body, access->ident, (uint8_t)access->device, whole);
}

static void
take_data(access_t *access)
{
    sis_body_t *body = access->body;
    tvbuff_t *data;

    if (body->is_short)
        return;
    if (!is_write(access) || !is_segment(access)) {
        body->item = body->root;
        check_most(access, sis_left(body));
    }
    if (is_single(access) || (!access->has_ident && access->is_last))
        data = tvb_new_subset_length(body->tvb, body->offset, sis_left(body));
    else if (access->has_ident)
        data = sis_sequence_data(body, access->is_last);
    else
        data = NULL;
    if (sis_left(body) == 0 && !sis_is_piece(body)) {
        check_segment(access, 0);
        /* Only the last piece of a transfer may have no data (chapter 8.2). Of a segment the asked length
         * decides. */
        if (access->has_ident && body->is_reaction && !is_segment(access))
            sis_needs(body, hf_sis_data, 1);
        return;
    }
    if (!is_single(access) && (data == NULL || sis_is_piece(body)))
        show_piece(access, data);
    else
        show_data(access, body->tree, data);
    body->offset = body->end;
}

static void
take_data_status(sis_body_t *body)
{
    static int *const bits[] = {&hf_sis_data_status_invalid,      &hf_sis_data_status_impossible,
                                &hf_sis_data_status_not_executed, &hf_sis_data_status_enabled,
                                &hf_sis_data_status_set,          NULL};
    uint32_t status;
    const char *word;
    bool is_defined;

    if (!sis_take(body, hf_sis_data_status, 2, &status))
        return;
    word = val_to_str_const(status & 0x0F, sis_data_states, "not defined");
    is_defined = !(status & DATA_STATUS_UNDEFINED) && try_val_to_str(status & 0x0F, sis_data_states) != NULL;
    proto_tree_add_bitmask_list(proto_item_add_subtree(body->item, ett_sis_data_status), body->tvb,
                                body->offset - 2, 2, bits, ENC_LITTLE_ENDIAN);
    proto_item_append_text(body->item, " (command %s%s)", word,
                           status & 0x0100 ? ", operating data invalid" : "");
    sis_say(body, " = command %s%s", word, status & 0x0100 ? ", operating data invalid" : "");
    if (!is_defined)
        sis_mark(body, &ei_sis_body_note, "undefined bits of the data status");
}

/* The upper digit of a code selects the element, even if the code is undefined. */
static void
take_parameter_error(sis_body_t *body)
{
    uint32_t digit;

    sis_take_error(body, sis_errors_parameter, sis_advice_parameter);
    digit = body->error >> 12;
    if (digit >= 1 && digit < 8 && try_val_to_str(body->error, sis_errors_parameter) == NULL)
        proto_item_append_text(body->item, ", element: %s", val_to_str_const(digit, sis_elements, ""));
}

static void
dissect_parameter_command(access_t *access)
{
    sis_body_t *body = access->body;

    if (!take_control(access) || !take_parameter(access))
        return;
    if (!is_write(access) && access->element <= SIS_ELEMENT_IDENT)
        sis_mark(body, &ei_sis_body_note, "no document allows reading this element"); /* chapter 8.1 */
    if (is_segment(access) && !take_segment(access))
        return;
    if (is_write(access)) {
        if (access->element != SIS_ELEMENT_DATA && access->element != SIS_ELEMENT_IDENT)
            sis_mark(body, &ei_sis_body_note, "only operating data and ident number can be written");
        if (sis_left(body) == 0 && access->element != SIS_ELEMENT_IDENT)
            sis_needs(body, hf_sis_data, 1);
        take_data(access);
        if (body->data != NULL && access->element == SIS_ELEMENT_DATA)
            body->learn = sis_keep_written;
    }
}

static void
dissect_parameter_reaction(access_t *access)
{
    sis_body_t *body = access->body;

    if (!take_control(access))
        return;
    recall_parameter(access);
    if (body->status == 0x01) {
        take_parameter_error(body);
    } else if (sis_take_channel_error(body)) {
        return;
    } else if (!is_write(access)) {
        take_data(access);
    } else if (access->element == SIS_ELEMENT_IDENT) { /* chapters 8.6 and 8.7 */
        take_data_status(body);
    }
}

void
sis_dissect_parameter(sis_body_t *body)
{
    access_t access = {.body = body, .general = sis_general_service(body->service)};

    if (!body->is_reaction) {
        dissect_parameter_command(&access);
        return;
    }
    dissect_parameter_reaction(&access);
    if (is_write(&access) || body->status != 0)
        sis_note_answer(body, is_write(&access));
    else if (access.is_last || is_single(&access))
        sis_note_read(body);
}
