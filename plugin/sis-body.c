/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Useful data: which file takes apart which service, and what all of them need (chapters 2.1 and 2.3). */

#include "sis-export.h"
#include "sis-sequence.h"
#include "sis-values.h"

int hf_sis_raw = -1;
int hf_sis_status = -1;
int hf_sis_device = -1;
int hf_sis_subservice = -1;
int hf_sis_error = -1;
int hf_sis_baud_mask = -1;
int hf_sis_data = -1;
static int hf_text = -1;

expert_field ei_sis_missing = EI_INIT;
expert_field ei_sis_unexpected = EI_INIT;
expert_field ei_sis_note = EI_INIT;
static expert_field ei_status = EI_INIT;
static expert_field ei_status_telegram = EI_INIT;

/* Preferences. */
static compat_bool clc_as_sercos = false;
static compat_bool ecodrive_phases = false;

typedef void (*body_dissector_t)(sis_body_t *body);

static const struct {
    uint8_t service;
    body_dissector_t dissect;
} services[] = {
    {0x00, sis_dissect_identification}, {0x01, sis_dissect_cancel},    {0x02, sis_dissect_flash},
    {0x03, sis_dissect_initialization}, {0x04, sis_dissect_list},      {0x10, sis_dissect_parameter},
    {0x11, sis_dissect_parameter},      {0x12, sis_dissect_phase},     {0x1D, sis_dissect_phase},
    {0x1E, sis_dissect_parameter},      {0x1F, sis_dissect_parameter},
};

/* Product groups have services of their own in the layout of 0x1x (chapter 8); those of the CLC are only said
 * to be close to it, and nobody has seen the phase services of ECODRIVE. */
uint8_t
sis_general_service(uint8_t service)
{
    uint8_t low = service & 0x0F, group = service & 0xF0;
    bool is_phase = low == 0x2 || low == 0xD, is_parameter = low <= 0x1 || low >= 0xE;

    if ((group == 0x80 && (is_parameter || (is_phase && ecodrive_phases))) ||
        (group == 0x90 && (is_parameter || is_phase)) ||
        (group == 0xC0 && (is_parameter || is_phase) && clc_as_sercos))
        return 0x10 | low;
    return service;
}

/* The other product groups need not (chapter 2.1), and their bodies are not documented. */
bool
sis_has_status(uint8_t service)
{
    return service <= 0x1F || (service >= 0x80 && service <= 0x9F) || sis_general_service(service) != service;
}

bool
sis_has_control_byte(uint8_t service)
{
    uint8_t general = sis_general_service(service);

    return general == 0x10 || general == 0x11 || general == 0x1E || general == 0x1F;
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
sis_mark(sis_body_t *body, expert_field *ei, const char *format, ...)
{
    va_list arguments;
    const char *text;

    va_start(arguments, format);
    text = wmem_strdup_vprintf(body->pinfo->pool, format, arguments);
    va_end(arguments);
    expert_add_info_format(body->pinfo, body->item, ei, "%s", text);
    wmem_strbuf_append_printf(body->marks, "  [%s]", text);
}

/* Saying it once is enough: after it nothing else can be there either. */
bool
sis_needs(sis_body_t *body, int hf, unsigned size)
{
    if (sis_left(body) >= size && !body->is_short)
        return true;
    if (!body->is_cut && !body->is_short) {
        body->item = body->root;
        sis_mark(body, &ei_sis_missing, "%s missing", proto_registrar_get_nth(hf)->name);
    }
    body->is_short = true;
    return false;
}

static uint32_t
get_value(const sis_body_t *body, unsigned size)
{
    uint32_t value = 0;

    for (unsigned i = size; i > 0; i--)
        value = value << 8 | compat_get_uint8(body->tvb, body->offset + i - 1);
    return value;
}

bool
sis_take(sis_body_t *body, int hf, unsigned size, uint32_t *value)
{
    if (!sis_needs(body, hf, size))
        return false;
    if (value != NULL)
        *value = get_value(body, size);
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

void
sis_request_device(sis_body_t *body, uint32_t device)
{
    if (body->request == NULL)
        return;
    body->request->has_device = true;
    body->request->device = (uint8_t)device;
}

bool
sis_take_subservice(sis_body_t *body, const value_string *texts, uint32_t *subservice)
{
    const char *text;
    uint32_t device;

    if (!sis_take(body, hf_sis_device, 1, &device))
        return false;
    sis_request_device(body, device);
    text = sis_take_code(body, hf_sis_subservice, 1, texts, subservice);
    if (text == NULL)
        return false;
    if (try_val_to_str(*subservice, texts) == NULL)
        sis_mark(body, &ei_sis_note, "subservice 0x%02x is not defined", *subservice);
    else
        sis_say(body, ": %s", text);
    if (body->request != NULL)
        body->request->subservice = (uint8_t)*subservice;
    return true;
}

/* Never ends at a NUL, and shows control characters as their pictures (U+2400 and following). */
const char *
sis_text(wmem_allocator_t *scope, tvbuff_t *tvb, unsigned offset, unsigned length)
{
    wmem_strbuf_t *text = wmem_strbuf_new(scope, "");

    for (unsigned i = 0; i < length; i++) {
        uint8_t c = compat_get_uint8(tvb, offset + i);

        wmem_strbuf_append_unichar(text, c < 0x20 ? 0x2400 + c : c < 0x7F ? c : c == 0x7F ? 0x2421 : 0xFFFD);
    }
    return wmem_strbuf_get_str(text);
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
    sis_say(body, ": \"%s\"", text);
    body->offset = body->end;
}

uint32_t
sis_take_baud_mask(sis_body_t *body, bool several)
{
    wmem_strbuf_t *text = wmem_strbuf_new(body->pinfo->pool, "");
    uint32_t mask, rate = 0;
    unsigned unknown;

    if (!sis_take(body, hf_sis_baud_mask, 1, &mask))
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
    sis_say(body, ": %s", wmem_strbuf_get_str(text));
    if (!several && (mask & (mask - 1)) != 0)
        sis_mark(body, &ei_sis_note, "more than one baud rate");
    return rate;
}

static void
mark_error(sis_body_t *body, const char *text, uint32_t code)
{
    sis_mark(body, &ei_status, "error 0x%04x: %s", code, text);
    body->is_explained = true;
    body->error = code;
    body->error_text = text;
}

void
sis_take_error(sis_body_t *body, const value_string *texts)
{
    uint32_t code;
    const char *text = sis_take_code(body, hf_sis_error, 2, texts, &code);

    if (text != NULL)
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
        sis_take_error(body, sis_errors_channel);
    else if (body->status > 0x02 && body->status < 0xF0)
        sis_take_rest(body, hf_sis_raw); /* nobody says what it is */
    return body->status >= 0x02;
}

static bool
is_phase_service(uint8_t service)
{
    return sis_general_service(service) == 0x12 || sis_general_service(service) == 0x1D;
}

static void
take_status(sis_body_t *body)
{
    const char *text = NULL;
    uint8_t status;

    if (!sis_needs(body, hf_sis_status, 1))
        return;
    status = compat_get_uint8(body->tvb, body->offset);
    if (is_phase_service(body->service))
        text = try_rval_to_str(status, sis_status_phase);
    if (text == NULL)
        text = rval_to_str_const(status, sis_status, "");
    body->status = status;
    body->item = proto_tree_add_uint_format_value(body->tree, hf_sis_status, body->tvb, body->offset, 1,
                                                  status, "%s (0x%02x)", text, status);
    body->offset++;
    body->status_text = text;
    if (status != 0)
        expert_add_info_format(body->pinfo, body->item, status < 0xF0 ? &ei_status : &ei_status_telegram,
                               "Status: %s", text);
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
    return sis_left(body) > 0;
}

static void
dissect_undocumented(sis_body_t *body)
{
    if (body->is_reaction && sis_has_status(body->service) && sis_take_channel_error(body))
        return;
    sis_take_rest(body, hf_sis_raw);
}

/* NULL: the documents do not say what is in it. */
static body_dissector_t
find_dissector_of(uint8_t service)
{
    for (unsigned i = 0; i < array_length(services); i++) {
        if (services[i].service == sis_general_service(service))
            return services[i].dissect;
    }
    return NULL;
}

/* What no field has taken: a field that is not there as a whole, or more than the service has. */
static void
show_leftover(sis_body_t *body)
{
    unsigned left = sis_left(body);

    if (left == 0)
        return;
    body->item = proto_tree_add_item(body->tree, hf_sis_raw, body->tvb, body->offset, left, ENC_NA);
    if (!body->is_short && !body->is_cut)
        sis_mark(body, &ei_sis_unexpected, "%u byte%s more than this service has", left,
                 plurality(left, "", "s"));
    body->offset = body->end;
}

void
sis_dissect_body(sis_body_t *body)
{
    body_dissector_t dissect = find_dissector_of(body->service);

    if (dissect == NULL && body->service >= 0x80 && is_plain_text(body)) {
        sis_take_text(body, hf_text); /* a record of a product group, without a status */
        return;
    }
    if (body->is_reaction && sis_has_status(body->service))
        take_status(body);
    /* After a telegram error not even the useful data header has to be there. */
    if (!body->is_short && (body->status < 0xF0 || sis_left(body) > 0))
        (dissect != NULL ? dissect : dissect_undocumented)(body);
    if (body->status != 0 && !body->is_explained) /* an error code says more */
        wmem_strbuf_append_printf(body->marks, "  [status: %s]", body->status_text);
    show_leftover(body);
    sis_sequence_watch(body);
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_sis_status, {"Status", "sis.status", FT_UINT8, BASE_HEX | BASE_RANGE_STRING, RVALS(sis_status), 0, NULL, HFILL}},
    {&hf_sis_device, {"Device address", "sis.device", FT_UINT8, BASE_DEC, NULL, 0, "Of the device behind the station; its own address, or 0 for the control itself", HFILL}},
    {&hf_sis_subservice, {"Subservice", "sis.subservice", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_sis_error, {"Error code", "sis.error", FT_UINT16, BASE_HEX, NULL, 0, "The full code, where a byte is sent together with its subservice", HFILL}},
    {&hf_sis_baud_mask, {"Baud rate mask", "sis.baud_mask", FT_UINT8, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_sis_data, {"Data", "sis.data", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_sis_raw, {"Not decoded", "sis.raw", FT_BYTES, BASE_NONE, NULL, 0, NULL, HFILL}},
    {&hf_text, {"Text", "sis.text", FT_STRING, BASE_NONE, NULL, 0, "Useful data of a product group that are plain ASCII", HFILL}},
};

static ei_register_info experts[] = {
    {&ei_sis_missing, {"sis.body.missing", PI_PROTOCOL, PI_WARN, "Useful data are missing", EXPFILL}},
    {&ei_sis_unexpected, {"sis.body.unexpected", PI_PROTOCOL, PI_WARN, "More useful data than the service has", EXPFILL}},
    {&ei_sis_note, {"sis.body.note", PI_PROTOCOL, PI_NOTE, "Useful data that the documents do not define", EXPFILL}},
    {&ei_status, {"sis.status.execution_error", PI_RESPONSE_CODE, PI_NOTE, "The status is an execution error", EXPFILL}},
    {&ei_status_telegram, {"sis.status.telegram_error", PI_RESPONSE_CODE, PI_WARN, "The status is a telegram error", EXPFILL}},
};
/* clang-format on */

void
sis_body_register(module_t *module)
{
    proto_register_field_array(proto_sis, fields, array_length(fields));
    expert_register_field_array(sis_experts, experts, array_length(experts));
    prefs_register_bool_preference(
        module, "clc_as_sercos", "Decode services 0xC0 to 0xCF like 0x10 to 0x1F",
        "The CLC's services are said to be close to the SERCOS services; their layout is "
        "not documented",
        &clc_as_sercos);
    prefs_register_bool_preference(
        module, "ecodrive_phases", "Decode services 0x82 and 0x8D like 0x12 and 0x1D",
        "Reading and switching the phase of an ECODRIVE this way is not confirmed", &ecodrive_phases);
    sis_identification_register();
    sis_cancel_register();
    sis_flash_register();
    sis_initialization_register();
    sis_list_register();
    sis_sercos_register();
    sis_parameters_register(module);
    sis_values_register();
    sis_exchange_register();
    sis_sequence_register();
    sis_export_register();
}
