/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The useful data of one service, read field by field (chapters 2.1 and 2.3). */
#include "sis/body.h"

#include "parameters/values.h"
#include "sis/told.h"

bool
sis_has_exchange(const sis_body_t *body)
{
    return body->record != NULL && body->record->exchange != NULL;
}

unsigned
sis_left(const sis_body_t *body)
{
    return body->end - body->offset;
}

void
sis_say(sis_body_t *body, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    wmem_strbuf_append_vprintf(body->summary, format, arguments);
    va_end(arguments);
}

void
sis_say_words(sis_body_t *body, const char *word, ...)
{
    va_list words;

    va_start(words, word);
    for (; word != NULL; word = va_arg(words, const char *))
        wmem_strbuf_append(body->summary, word);
    va_end(words);
}

void
sis_say_bytes(sis_body_t *body, const char *before, unsigned count)
{
    char digits[12], *begin = digits + sizeof digits;
    unsigned rest = count;

    *--begin = '\0';
    do {
        *--begin = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest > 0);
    sis_say_words(body, before, begin, count == 1 ? " byte" : " bytes", NULL);
}

void
sis_mark(sis_body_t *body, expert_field *ei, const char *format, ...)
{
    va_list arguments;
    const char *text;

    va_start(arguments, format);
    text = wmem_strdup_vprintf(body->pinfo->pool, format, arguments);
    va_end(arguments);
    expert_add_info_format(body->pinfo, body->item, ei, "%s", text);
    sis_tell_expert(body->pinfo, ei);
    wmem_strbuf_append_printf(body->marks, "  [%s]", text);
}

/* One note is enough: nothing else can follow. */
bool
sis_needs(sis_body_t *body, int hf, unsigned size)
{
    if (sis_left(body) >= size && !body->is_short)
        return true;
    if (!body->is_cut && !body->is_short) {
        body->item = body->root;
        sis_mark(body, &ei_sis_body_missing, "%s missing", proto_registrar_get_nth(hf)->name);
    }
    body->is_short = true;
    return false;
}

static uint32_t
get_value(const sis_body_t *body, unsigned size)
{
    switch (size) {
    case 1:
        return compat_get_uint8(body->tvb, body->offset);
    case 2:
        return tvb_get_letohs(body->tvb, body->offset);
    case 3:
        return tvb_get_letoh24(body->tvb, body->offset);
    default:
        return tvb_get_letohl(body->tvb, body->offset);
    }
}

bool
sis_take(sis_body_t *body, int hf, unsigned size, uint32_t *value)
{
    if (!sis_needs(body, hf, size))
        return false;
    if (value != NULL)
        *value = get_value(body, size);
    if (body->tree != NULL)
        body->item = proto_tree_add_item(body->tree, hf, body->tvb, body->offset, size, ENC_LITTLE_ENDIAN);
    body->offset += size;
    return true;
}

const char *
sis_take_code(sis_body_t *body, int hf, unsigned size, const value_string *texts, uint32_t *value)
{
    const char *text;

    if (!sis_needs(body, hf, size))
        return NULL;
    *value = get_value(body, size);
    text = val_to_str_const(*value, texts, "Not defined");
    body->item = proto_tree_add_uint_format_value(body->tree, hf, body->tvb, body->offset, size, *value,
                                                  "%s (0x%0*x)", text, (int)size * 2, *value);
    body->offset += size;
    return text;
}

bool
sis_take_rest(sis_body_t *body, int hf)
{
    if (sis_left(body) == 0 || body->is_short)
        return false;
    body->item = proto_tree_add_item(body->tree, hf, body->tvb, body->offset, sis_left(body), ENC_NA);
    body->offset = body->end;
    return true;
}

sis_request_t *
sis_request_of(const sis_body_t *body)
{
    return body->is_reaction ? body->asked : body->request;
}

sis_request_t *
sis_request_add(sis_body_t *body, uint8_t service)
{
    bool is_kept = sis_has_exchange(body) && body->asked == NULL;
    sis_request_t **end = &body->request->list;
    const sis_request_t *same = NULL;

    if (is_kept && body->element == 0)
        same = sis_exchange_direction(body->record->exchange)->same;
    if (same != NULL)
        same = same->list;
    for (; *end != NULL; end = &(*end)->next)
        same = same != NULL ? same->next : NULL;
    *end = is_kept ? sis_request_new(wmem_file_scope(), service, same, body->record->exchange->first != NULL)
                   : sis_request_new(body->pinfo->pool, service, NULL, false);
    return *end;
}

void
sis_request_device(sis_body_t *body, uint32_t device)
{
    if (body->request == NULL)
        return;
    body->request->has_device = true;
    body->request->device = (uint8_t)device;
}

bool
sis_take_subservice(sis_body_t *body, uint32_t *subservice)
{
    const value_string *texts = sis_subservices_of(body->service);
    const char *text;
    uint32_t device;

    if (!sis_take(body, hf_sis_device, 1, &device))
        return false;
    sis_request_device(body, device);
    text = sis_take_code(body, hf_sis_subservice, 1, texts, subservice);
    if (text == NULL)
        return false;
    if (try_val_to_str(*subservice, texts) == NULL)
        sis_mark(body, &ei_sis_body_note, "subservice 0x%02x is not defined", *subservice);
    else
        sis_say_words(body, ": ", text, NULL);
    if (body->request != NULL)
        body->request->subservice = (uint8_t)*subservice;
    return true;
}

const sis_layout_t *
sis_find_layout(const sis_layouts_t *service, uint32_t subservice)
{
    for (unsigned i = 0; i < service->count; i++) {
        if (service->layouts[i].subservice == subservice)
            return &service->layouts[i];
    }
    return NULL;
}

/* A code with its text, into the summary. */
static void
take_item_code(sis_body_t *body, const sis_item_t *item)
{
    uint32_t value;
    const char *text = sis_take_code(body, *item->hf, item->size, item->codes, &value);

    if (text == NULL)
        return;
    sis_say_words(body, ", ", text, NULL);
    if (try_val_to_str(value, item->codes) == NULL)
        sis_mark(body, &ei_sis_body_note, "0x%0*x is not defined", (int)item->size * 2, value);
}

/* The rest as bytes; their number into the summary. */
static void
take_item_bytes(sis_body_t *body, const sis_item_t *item)
{
    unsigned length = sis_left(body);

    sis_needs(body, *item->hf, 1);
    if (sis_take_rest(body, *item->hf))
        sis_say_bytes(body, ", ", length);
}

/* As its field says: text, bytes, a code or a number. */
static void
take_item(sis_body_t *body, const sis_item_t *item)
{
    const header_field_info *field = proto_registrar_get_nth((unsigned)*item->hf);
    enum ftenum type = field->type;
    unsigned size = type == FT_UINT8 ? 1 : type == FT_UINT16 ? 2 : type == FT_UINT32 ? 4 : 0;
    uint32_t value;

    if (type == FT_STRING) {
        sis_take_text(body, *item->hf);
    } else if (type == FT_BYTES) {
        take_item_bytes(body, item);
    } else if (size == 0 || item->size != size) {
        sis_take_rest(body, hf_sis_raw); /* protocol/checks.py lets none pass */
    } else if (item->codes != NULL) {
        take_item_code(body, item);
    } else if (sis_take(body, *item->hf, item->size, &value)) {
        if (field->display == BASE_HEX)
            sis_say(body, ", 0x%0*x", (int)item->size * 2, value);
        else
            sis_say(body, ", %u", value);
    }
}

void
sis_take_layout(sis_body_t *body, const sis_layout_t *layout)
{
    const sis_item_t *item;

    if (layout == NULL) {
        sis_take_rest(body, hf_sis_raw);
        return;
    }
    for (item = body->is_reaction ? layout->reaction : layout->command; item->hf != NULL; item++) {
        if (item->may_be_missing && sis_left(body) < item->size)
            continue;
        if (item->take != NULL)
            item->take(body, item->size);
        else
            take_item(body, item);
    }
}

void
sis_take_layout_or_error(sis_body_t *body, const sis_layouts_t *service, uint32_t subservice)
{
    if (!body->is_reaction || sis_is_ok(body))
        sis_take_layout(body, sis_find_layout(service, subservice));
    else if (sis_take_channel_error(body))
        return;
    else if (service->errors != NULL)
        sis_take_error_byte(body, (uint8_t)subservice, service->errors);
    else
        sis_take_rest(body, hf_sis_raw); /* not documented */
}

void
sis_take_text(sis_body_t *body, int hf)
{
    unsigned offset = body->offset, length = sis_left(body);
    const char *text;

    if (!sis_needs(body, hf, 1))
        return;
    text = sis_text(body->pinfo->pool, body->tvb, offset, length);
    body->item = proto_tree_add_string(body->tree, hf, body->tvb, offset, length, text);
    sis_say_words(body, ": \"", text, "\"", NULL);
    body->text = text;
    body->offset = body->end;
}

uint32_t
sis_take_baud_mask(sis_body_t *body, bool several)
{
    wmem_strbuf_t *text = wmem_strbuf_new(body->pinfo->pool, "");
    uint32_t mask, rate = 0;
    unsigned unknown;

    if (!sis_take(body, hf_sis_init_baud_mask, 1, &mask))
        return 0;
    unknown = mask;
    for (unsigned i = 0; sis_baud_masks[i].strptr != NULL; i++) {
        uint32_t bit = sis_baud_masks[i].value;

        unknown &= ~bit;
        if (mask == bit)
            rate = (uint32_t)strtoul(sis_baud_masks[i].strptr, NULL, 10);
        if (bit == 0 ? several || mask == 0 : (mask & bit) != 0) /* 9600 is always supported */
            wmem_strbuf_append_printf(text, "%s%s", wmem_strbuf_get_len(text) ? ", " : "",
                                      sis_baud_masks[i].strptr);
    }
    if (unknown != 0)
        wmem_strbuf_append_printf(text, "%s0x%02x (not defined)", wmem_strbuf_get_len(text) ? ", " : "",
                                  unknown);
    proto_item_append_text(body->item, " (%s)", wmem_strbuf_get_str(text));
    sis_say_words(body, ": ", wmem_strbuf_get_str(text), NULL);
    if (!several && (mask & (mask - 1)) != 0)
        sis_mark(body, &ei_sis_body_note, "more than one baud rate");
    if (unknown != 0)
        sis_mark(body, &ei_sis_body_note, "undefined bits of the baud rate mask");
    return rate;
}

static void
mark_error(sis_body_t *body, const char *text, uint32_t code)
{
    sis_mark(body, &ei_sis_status_execution_error, "error 0x%04x: %s", code, text);
    body->is_explained = true;
    body->error = code;
    body->error_text = text;
}

void
sis_take_error(sis_body_t *body, const value_string *texts, const value_string *advice)
{
    uint32_t code;
    const char *text = sis_take_code(body, hf_sis_error, 2, texts, &code);

    if (text == NULL)
        return;
    if (advice != NULL && try_val_to_str(code, advice) != NULL)
        proto_item_append_text(body->item, ": %s", try_val_to_str(code, advice));
    mark_error(body, text, code);
}

void
sis_take_error_byte(sis_body_t *body, uint8_t subservice, const value_string *texts)
{
    uint32_t code;
    const char *text;

    if (!sis_needs(body, hf_sis_error, 1))
        return;
    code = (uint32_t)subservice << 8 | get_value(body, 1);
    text = val_to_str_const(code, texts, "Not defined");
    body->item = proto_tree_add_uint_format_value(body->tree, hf_sis_error, body->tvb, body->offset, 1, code,
                                                  "%s (0x%04x)", text, code);
    body->offset++;
    mark_error(body, text, code);
}

bool
sis_is_ok(const sis_body_t *body)
{
    return body->status == 0 && !body->is_short;
}

bool
sis_take_channel_error(sis_body_t *body)
{
    if (body->status == 0x02)
        sis_take_error(body, sis_errors_channel, sis_advice_channel);
    else if (body->status > 0x02 && body->status < 0xF0)
        sis_take_rest(body, hf_sis_raw); /* not documented */
    return body->status >= 0x02;
}
