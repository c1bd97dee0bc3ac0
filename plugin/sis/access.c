/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reads and writes of parameters. Nothing is computed unless the field is requested. */
#include "sis/access.h"

#include <epan/to_str.h>

#include "parameters/values.h"
#include "parts.h"
#include "sis/address.h"
#include "sis/told.h"

#define SHOWN_BYTES      16u
#define SHOWN_CHARACTERS 80u

void
sis_keep_written(sis_body_t *body)
{
    body->request->written_length = tvb_captured_length(body->data);
    body->request->written = tvb_memdup(wmem_file_scope(), body->data, 0, body->request->written_length);
}

bool
sis_access_is_wanted(proto_tree *tree)
{
    return sis_is_told() || (tree != NULL && proto_field_is_referenced(tree, hf_sis_access));
}

/* A reaction that comes twice is counted once, one from before this file not at all. */
static bool
is_known(const sis_body_t *body)
{
    const sis_request_t *asked = body->asked;

    return body->record != NULL && body->record->reaction_before == 0 && asked != NULL && asked->has_ident &&
           asked->element == SIS_ELEMENT_DATA && !body->is_short && !body->telegram->is_before;
}

static const char *
bytes_text(wmem_allocator_t *scope, tvbuff_t *data)
{
    unsigned length = tvb_captured_length(data);
    const char *text = tvb_bytes_to_str_punct(scope, data, 0, (int)MIN(length, SHOWN_BYTES), ' ');

    return length <= SHOWN_BYTES ? text : wmem_strdup_printf(scope, "%s... (%u bytes)", text, length);
}

/* Of ASCII characters, and never two backslashes in a row: `tshark -T fields` doubles each since
 * Wireshark 4.2, 4.0 and `-z sis,rows` do not, and so a reader needs not know who printed it. */
static void
append_character(wmem_strbuf_t *json, gunichar2 character)
{
    if (character >= ' ' && character <= '~' && character != '"' && character != '\\')
        wmem_strbuf_append_c(json, (char)character);
    else
        wmem_strbuf_append_printf(json, "\\u%04x", character);
}

static void
append_odd_text(wmem_strbuf_t *json, const char *text)
{
    char *valid = g_utf8_make_valid(text, -1);
    gunichar2 *characters = g_utf8_to_utf16(valid, -1, NULL, NULL, NULL);

    for (const gunichar2 *character = characters; *character != 0; character++)
        append_character(json, *character);
    g_free(characters);
    g_free(valid);
}

static void
append_text(wmem_strbuf_t *json, const char *name, const char *text)
{
    const char *end = text;

    if (text == NULL)
        return;
    while (g_ascii_isprint(*end) && *end != '"' && *end != '\\')
        end++;
    wmem_strbuf_append(json, ",\"");
    wmem_strbuf_append(json, name);
    wmem_strbuf_append(json, "\":\"");
    wmem_strbuf_append_len(json, text, (size_t)(end - text));
    if (*end != '\0')
        append_odd_text(json, end);
    wmem_strbuf_append_c(json, '"');
}

/* JSON has decimal numbers only. */
static void
append_number(wmem_strbuf_t *json, const char *value)
{
    wmem_strbuf_append(json, ",\"number\":");
    if (g_str_has_prefix(value, "0x"))
        wmem_strbuf_append_printf(json, "%" PRIu64, g_ascii_strtoull(value, NULL, 16));
    else
        wmem_strbuf_append_len(json, value, strspn(value, "+-.0123456789e"));
}

/* The value as displayed, bytes if its attribute is unknown; and all bytes. */
static void
append_data(wmem_strbuf_t *json, packet_info *pinfo, const sis_access_t *access)
{
    sis_element_data_t data = {access->data, ENC_LITTLE_ENDIAN, true, &access->place};
    const char *text = sis_add_element(NULL, pinfo, &data, SIS_ELEMENT_DATA, &access->ident, &access->known);
    unsigned length = tvb_captured_length(data.tvb);
    double number;

    append_text(json, "value",
                text != NULL ? sis_text_shortened(pinfo->pool, text, SHOWN_CHARACTERS)
                             : bytes_text(pinfo->pool, data.tvb));
    if (text == NULL)
        wmem_strbuf_append(json, ",\"raw\":true");
    else if (sis_element_number(&data, &access->known, text, &number))
        append_number(json, text);
    append_text(
        json, "data",
        length > 0 ? bytes_to_str_maxlen(pinfo->pool, tvb_get_ptr(data.tvb, 0, (int)length), length, 0) : "");
}

const char *
sis_access_text(packet_info *pinfo, const sis_access_t *access)
{
    wmem_allocator_t *scope = pinfo->pool;
    wmem_strbuf_t *json = wmem_strbuf_new(scope, "");

    wmem_strbuf_append_printf(json, "{\"access\":\"%s\"", access->is_write ? "write" : "read");
    if (access->has_master)
        wmem_strbuf_append_printf(json, ",\"master\":%u", access->master);
    append_text(json, "station", sis_place_text(scope, &access->place));
    wmem_strbuf_append_printf(json, ",\"device\":%u", access->place.device);
    append_text(json, "parameter", sis_ident_text(scope, access->ident));
    append_text(json, "error", access->error);
    append_text(json, "value", access->value);
    if (access->is_number)
        append_number(json, access->value);
    if (access->data != NULL)
        append_data(json, pinfo, access);
    append_text(json, "text", access->text);
    append_text(json, "name", access->known.name);
    append_text(json, "unit", access->known.unit);
    append_text(json, "minimum", access->known.minimum);
    append_text(json, "maximum", access->known.maximum);
    wmem_strbuf_append_c(json, '}');
    return wmem_strbuf_get_str(json);
}

void
sis_access_tell(const sis_access_t *access, tvbuff_t *tvb, packet_info *pinfo, proto_tree *tree)
{
    sis_tell_access(pinfo, access);
    if (tree != NULL && proto_field_is_referenced(tree, hf_sis_access))
        proto_item_set_hidden(
            proto_tree_add_string(tree, hf_sis_access, tvb, 0, 0, sis_access_text(pinfo, access)));
}

static void
note(sis_body_t *body, bool is_write, const char *error, tvbuff_t *data)
{
    const sis_request_t *asked = body->asked;
    sis_access_t *access = wmem_new0(body->pinfo->pool, sis_access_t);

    access->is_write = is_write;
    access->error = error;
    access->has_master = true;
    access->master = body->telegram->listener;
    access->place = sis_station_of(body, asked->device);
    access->ident = asked->ident;
    access->known = sis_station_known(body, asked->ident, asked->device);
    sis_station_complete(body, &access->known);
    access->data = data;
    sis_access_tell(access, body->tvb, body->pinfo, body->tree);
}

void
sis_note_read(sis_body_t *body)
{
    if (sis_access_is_wanted(body->tree) && is_known(body))
        note(body, false, NULL, body->data);
}

static tvbuff_t *
written_data(const sis_body_t *body)
{
    const sis_request_t *request = body->asked;

    if (request->written == NULL)
        return NULL;
    return tvb_new_child_real_data(body->tvb, request->written, request->written_length,
                                   (int)request->written_length);
}

static const char *
error_text(const sis_body_t *body)
{
    if (body->error_text == NULL)
        return body->status_text;
    return wmem_strdup_printf(body->pinfo->pool, "0x%04x %s", body->error, body->error_text);
}

void
sis_note_answer(sis_body_t *body, bool is_write)
{
    if (!sis_access_is_wanted(body->tree) || !is_known(body))
        return;
    if (body->status != 0)
        note(body, is_write, error_text(body), NULL);
    else if (body->asked->is_last)
        note(body, true, NULL, written_data(body));
}
