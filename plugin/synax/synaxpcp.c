/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Interbus PCP: service code, word count, invoke id, communication reference, and what the service brings.
 * All words have the high byte first. Codes and layouts are those that ABB's NIBA-01 manual prints (p. 6-2 to
 * 6-8); one write request is printed in SYNAX' own (L242). */
#include "parts.h"

#include "items.h"
#include "kept.h"
#include "protocol/fields.h"
#include "sis/asked.h"
#include "synax/synaxobj.h"

#define HEAD_SIZE     4u /* service code and word count, which counts what comes after them */
#define REFERENCE_END 6u /* of invoke id and communication reference */
#define RESULT_END    8u
#define SUBINDEX_AT   8u
#define LENGTH_AT     9u
#define DATA_AT       10u

/* A service on an object. The master sees request and confirmation, the device indication and response. */
typedef struct {
    bool is_write, is_answer, is_at_device;
} access_t;

#define OF_DEVICE 0x0020 /* bits of the codes 0081, 0082, 00A1 ... 01A2 */
#define SECOND    0x0100 /* a confirmation or an indication: what the other has begun arrives */

/* False: it is another service. */
static bool
read_access(uint16_t code, access_t *access)
{
    uint16_t service = code & ~(OF_DEVICE | SECOND);

    access->is_write = service == 0x0082;
    access->is_at_device = code & OF_DEVICE;
    access->is_answer = !(code & OF_DEVICE) == !!(code & SECOND);
    return service == 0x0081 || service == 0x0082;
}

/* A message with its relations. Only a request or an indication names its object. */
typedef struct link {
    sis_asked_t asked;
    const struct link *request; /* itself, or what it answers; NULL: not known */
    uint16_t number;
    uint8_t subindex;
} link_t;

/* The message being dissected. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *parent;
    proto_tree *tree;
    proto_item *root;
    access_t access;
    unsigned end; /* by the word count, and as far as available */
} dissection_t;

/* The last request or indication like this message. */
static void **
last_like(const dissection_t *d, bool is_at_device)
{
    return sis_asked_last(d->pinfo, proto_synaxpcp,
                          (uint32_t)is_at_device << 17 | (uint32_t)d->access.is_write << 16 |
                              compat_get_uint16(d->tvb, HEAD_SIZE, ENC_BIG_ENDIAN));
}

/* At the same end of the bus, else at the other: a log may have only requests and responses. */
static void
end_exchange(const dissection_t *d, link_t *link, const sis_times_t *times)
{
    link_t *request = *last_like(d, d->access.is_at_device);

    if (request == NULL || request->asked.answer_in != 0)
        request = *last_like(d, !d->access.is_at_device);
    if (request == NULL || request->asked.answer_in != 0)
        return;
    link->request = request;
    sis_asked_answer(&link->asked, &request->asked, times);
}

/* Found in the first pass, and kept for every later one. */
static const link_t *
find_link(const dissection_t *d)
{
    link_t *link = kept_of_packet(d->pinfo, proto_synaxpcp, tvb_raw_offset(d->tvb), sizeof *link);
    sis_times_t times = sis_times(d->tvb, d->pinfo, 0, NULL);

    if (PINFO_FD_VISITED(d->pinfo))
        return link;
    sis_asked_note(&link->asked, d->pinfo, &times);
    if (d->access.is_answer) {
        end_exchange(d, link, &times);
        return link;
    }
    link->request = link;
    link->number = compat_get_uint16(d->tvb, REFERENCE_END, ENC_BIG_ENDIAN);
    link->subindex = compat_get_uint8(d->tvb, SUBINDEX_AT);
    *last_like(d, d->access.is_at_device) = link;
    return link;
}

static void
show_link(const dissection_t *d, const link_t *link)
{
    sis_asked_fields_t fields = {hf_synaxpcp_request_in, hf_synaxpcp_response_in, hf_synaxpcp_response_time};

    sis_asked_show(&link->asked, d->tree, d->tvb, d->pinfo, &fields);
}

static void
say_short(const dissection_t *d, unsigned needed)
{
    expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "The message has at least %u bytes", needed);
}

/* Passes on objects of SYNAX, complete: an element of an object may be anything. */
static void
dissect_data(const dissection_t *d, unsigned length, const link_t *request)
{
    synaxobj_access_t access = {.channel = compat_get_uint8(d->tvb, HEAD_SIZE + 1)};
    proto_item *item;

    access.operation = d->access.is_answer ? d->access.is_write ? SYNAXOBJ_WRITE_ANSWER : SYNAXOBJ_READ_ANSWER
                       : d->access.is_write ? SYNAXOBJ_WRITE_REQUEST
                                            : SYNAXOBJ_READ_REQUEST;
    access.number = request != NULL ? request->number : 0;
    if (request != NULL && request->subindex == 0 && synaxobj_is_known(access.number)) {
        synaxobj_dissect(d->tvb, length > 0 ? DATA_AT : d->end, length, d->pinfo, d->parent, &access);
        return;
    }
    if (request != NULL)
        col_append_fstr(d->pinfo->cinfo, COL_INFO, "  0x%04X.%u", request->number, request->subindex);
    if (length == 0)
        return;
    item = proto_tree_add_item(d->tree, hf_synaxpcp_data, d->tvb, DATA_AT, length, ENC_NA);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, ", %u byte%s", length, plurality(length, "", "s"));
    if (request == NULL)
        expert_add_info_format(d->pinfo, item, &ei_synax_note,
                               "The request is not in the capture: the object is not known");
    else if (synaxobj_is_known(request->number))
        expert_add_info_format(d->pinfo, item, &ei_synax_note,
                               "What element %u of the object holds is not defined", request->subindex);
    else
        expert_add_info_format(d->pinfo, item, &ei_synax_note, "What object 0x%04X holds is not defined",
                               request->number);
}

/* The length, the data, and the byte that pads a word. */
static void
dissect_length(const dissection_t *d, const link_t *request)
{
    unsigned length = compat_get_uint8(d->tvb, LENGTH_AT), there = d->end - DATA_AT;
    proto_item *item = proto_tree_add_item(d->tree, hf_synaxpcp_length, d->tvb, LENGTH_AT, 1, ENC_NA);

    if (length > there)
        expert_add_info_format(d->pinfo, item, &ei_synax_short, "The data are cut");
    else
        add_bytes(d->tree, hf_synaxpcp_padding, d->tvb, DATA_AT + length, d->end);
    dissect_data(d, MIN(length, there), request);
}

/* Read and write request, and their indications. */
static void
dissect_request(const dissection_t *d)
{
    unsigned needed = d->access.is_write ? DATA_AT : SUBINDEX_AT + 1;
    const link_t *link;

    if (d->end < needed) {
        add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, REFERENCE_END, d->end);
        say_short(d, needed);
        return;
    }
    proto_tree_add_item(d->tree, hf_synaxpcp_index, d->tvb, REFERENCE_END, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(d->tree, hf_synaxpcp_subindex, d->tvb, SUBINDEX_AT, 1, ENC_NA);
    link = find_link(d);
    show_link(d, link);
    if (d->access.is_write) {
        dissect_length(d, link->request);
        return;
    }
    add_bytes(d->tree, hf_synaxpcp_padding, d->tvb, SUBINDEX_AT + 1, d->end);
    dissect_data(d, 0, link->request);
}

/* Error class, error code and additional code instead of a result. */
static void
dissect_error(const dissection_t *d)
{
    uint32_t error = compat_get_uint32(d->tvb, REFERENCE_END, ENC_BIG_ENDIAN);
    proto_item *item =
        proto_tree_add_item(d->tree, hf_synaxpcp_error, d->tvb, REFERENCE_END, 4, ENC_BIG_ENDIAN);
    proto_tree *tree = proto_item_add_subtree(item, ett_synaxpcp_error);
    const char *text = try_val_to_str(error, sis_synaxpcp_errors);
    const char *words = wmem_strdup_printf(d->pinfo->pool, "Error class %u, code %u, additional 0x%04x%s%s",
                                           error >> 24, error >> 16 & 0xFF, error & 0xFFFF,
                                           text != NULL ? ", at ABB: " : "", text != NULL ? text : "");

    proto_tree_add_item(tree, hf_synaxpcp_error_class, d->tvb, REFERENCE_END, 1, ENC_NA);
    proto_tree_add_item(tree, hf_synaxpcp_error_code, d->tvb, REFERENCE_END + 1, 1, ENC_NA);
    proto_tree_add_item(tree, hf_synaxpcp_error_additional, d->tvb, RESULT_END, 2, ENC_BIG_ENDIAN);
    expert_add_info_format(d->pinfo, item, &ei_synax_error, "%s", words);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "  %s", words);
    add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, RESULT_END + 2, d->end);
}

/* Result 0, and the data read. */
static void
dissect_result(const dissection_t *d, const link_t *request)
{
    proto_tree_add_item(d->tree, hf_synaxpcp_result, d->tvb, REFERENCE_END, 2, ENC_BIG_ENDIAN);
    if (d->access.is_write) {
        add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, RESULT_END, d->end);
        dissect_data(d, 0, request);
    } else if (d->end < DATA_AT) {
        add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, RESULT_END, d->end);
        say_short(d, DATA_AT);
    } else {
        proto_tree_add_item(d->tree, hf_synaxpcp_padding, d->tvb, RESULT_END, 1, ENC_NA);
        dissect_length(d, request);
    }
}

/* Response and confirmation: they do not name the object. */
static void
dissect_answer(const dissection_t *d)
{
    const link_t *link = find_link(d);
    const link_t *request = link->request;
    bool is_good = d->end >= RESULT_END && compat_get_uint16(d->tvb, REFERENCE_END, ENC_BIG_ENDIAN) == 0;

    show_link(d, link);
    if (request != NULL)
        add_generated(d->tree, hf_synaxpcp_index_of_request, d->tvb, request->number);
    if (is_good) {
        dissect_result(d, request);
    } else if (d->end >= RESULT_END + 2) {
        dissect_error(d);
    } else {
        add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, REFERENCE_END, d->end);
        say_short(d, d->end < RESULT_END ? RESULT_END : RESULT_END + 2);
    }
}

static void
dissect_other(const dissection_t *d, uint16_t code)
{
    add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, REFERENCE_END, d->end);
    if (try_val_to_str(code, sis_synaxpcp_services) == NULL)
        expert_add_info_format(
            d->pinfo, d->root, &ei_synax_note, "Service code 0x%04x is not defined%s", code,
            code >> 8 == 0x80 ? ": older controllers have such codes, and manuals differ in "
                                "which is a request"
                              : "");
    else if (REFERENCE_END < d->end)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_note, "What this service brings is not decoded");
}

static void
dissect_message(dissection_t *d)
{
    uint16_t code = compat_get_uint16(d->tvb, 0, ENC_BIG_ENDIAN);
    const char *name = try_val_to_str(code, sis_synaxpcp_services);

    if (name == NULL)
        name = wmem_strdup_printf(d->pinfo->pool, "Service 0x%04x", code);
    proto_item_append_text(d->root, ", %s", name);
    col_append_str(d->pinfo->cinfo, COL_INFO, name);
    if (d->end < REFERENCE_END) {
        add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, HEAD_SIZE, d->end);
        say_short(d, REFERENCE_END);
        return;
    }
    proto_tree_add_item(d->tree, hf_synaxpcp_invoke, d->tvb, HEAD_SIZE, 1, ENC_NA);
    proto_tree_add_item(d->tree, hf_synaxpcp_reference, d->tvb, HEAD_SIZE + 1, 1, ENC_NA);
    if (!read_access(code, &d->access))
        dissect_other(d, code);
    else if (d->access.is_answer)
        dissect_answer(d);
    else
        dissect_request(d);
}

/* Service code and word count; decodes the words that are counted. */
static void
dissect_head(dissection_t *d)
{
    unsigned there = tvb_captured_length(d->tvb), count = compat_get_uint16(d->tvb, 2, ENC_BIG_ENDIAN);
    unsigned end = HEAD_SIZE + 2 * count;
    proto_item *item;

    proto_tree_add_item(d->tree, hf_synaxpcp_service, d->tvb, 0, 2, ENC_BIG_ENDIAN);
    item = proto_tree_add_item(d->tree, hf_synaxpcp_count, d->tvb, 2, 2, ENC_BIG_ENDIAN);
    d->end = MIN(end, there);
    if (end > there)
        expert_add_info_format(d->pinfo, item, &ei_synax_short, "Fewer words than counted");
    if (end < there)
        expert_add_info_format(d->pinfo, item, &ei_synax_unexpected, "Bytes after the last word");
    add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, end, there);
    dissect_message(d);
}

/* Less than a head, or cut by the capture: then a length is meaningless. */
static void
dissect_stump(const dissection_t *d, unsigned there)
{
    col_append_str(d->pinfo->cinfo, COL_INFO, "Cut message");
    add_bytes(d->tree, hf_synaxpcp_raw, d->tvb, 0, there);
    if (there == tvb_reported_length(d->tvb))
        expert_add_info_format(d->pinfo, d->root, &ei_synax_short,
                               "Service code and word count have 4 bytes");
}

static int
dissect_synaxpcp(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    unsigned there = tvb_captured_length(tvb);
    dissection_t d = {.tvb = tvb, .pinfo = pinfo, .parent = parent};

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SYNAXPCP");
    col_clear(pinfo->cinfo, COL_INFO);
    d.root = proto_tree_add_item(parent, proto_synaxpcp, tvb, 0, there, ENC_NA);
    d.tree = proto_item_add_subtree(d.root, ett_synaxpcp);
    if (there < HEAD_SIZE || there < tvb_reported_length(tvb))
        dissect_stump(&d, there);
    else
        dissect_head(&d);
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb));
    return (int)there;
}

void
synax_synaxpcp_register(void)
{
    register_dissector("synaxpcp", dissect_synaxpcp, proto_synaxpcp);
}
