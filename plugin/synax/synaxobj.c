/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Objects of SYNAX200 (chapter 2). 5E70 to 5E73 hold a SIS telegram: a request is written, its answer is read
 * from the same object (p. 2-16). 5FF0 to 5FF6 are diagnosis words (p. 2-36 to 2-40). */

#include "synax/synaxobj.h"

#include <epan/proto_data.h>

#include "sertap/line.h"
#include "sertap/time.h"
#include "sis/frame.h"
#include "synax/fields.h"

#define HEAD_SIZE   3u /* for tests of the dissector by name; not on any bus */
#define WORD_SIZE   2u
#define MOST_FIELDS 2

#define DIAGNOSIS_FIELDBUS 0x5FF0
#define FAULT_CODE_PPC     0x5FF6

static int proto_synaxobj = -1;

static int hf_index = -1;
static int hf_operation = -1;
static int hf_raw = -1;
static int hf_padding = -1;
static int hf_open_bit = -1;
static int hf_diagnosis = -1;
static int hf_interface = -1;
static int hf_fault = -1;
static int hf_status = -1;
static int hf_bus = -1;
static int hf_memory = -1;
static int hf_ppc = -1;
static int hf_fault_ppc = -1;
static int hf_communication = -1;
static int hf_process_data = -1;

static int ett_synaxobj = -1;
static int ett_word = -1;

static dissector_handle_t sis;

static const value_string synaxobj_operations[] = {
    {SYNAXOBJ_READ_ANSWER, "read answer"},
    {SYNAXOBJ_WRITE_REQUEST, "write request"},
    {SYNAXOBJ_READ_REQUEST, "read request"},
    {SYNAXOBJ_WRITE_ANSWER, "write answer"},
    {0, NULL},
};

static const value_string synaxobj_names[] = {
    {0x5E70, "Data exchange, 16 bytes"},
    {0x5E71, "Data exchange, 32 bytes"},
    {0x5E72, "Data exchange, 64 bytes"},
    {0x5E73, "Data exchange, 128 bytes"},
    {DIAGNOSIS_FIELDBUS, "Diagnosis fieldbus"},
    {0x5FF2, "Status fieldbus"},
    {0x5FF5, "Written by the PPC, name not known"},
    {FAULT_CODE_PPC, "Fault code PPC"},
    {0x5FFC, "Name not known, perhaps of the multiplex channel"},
    {0x5FFD, "Name not known, perhaps of the multiplex channel"},
    {0x5FFE, "Name not known, perhaps of the multiplex channel"},
    {0, NULL},
};

static const true_false_string no_bus_failure = {"No failure", "After a failure of the bus"};

typedef enum { OF_TELEGRAMS, OF_BITS, OF_NOTHING_KNOWN } content_t;

typedef struct {
    uint16_t number;
    uint8_t size; /* bytes, 0: not known */
    content_t content;
    int *hf;                  /* of a word */
    int *fields[MOST_FIELDS]; /* in it */
    uint16_t open_bits;       /* the meaning of each is not defined */
} object_t;

static const object_t objects[] = {
    {0x5E70, 16, OF_TELEGRAMS, NULL, {NULL}, 0},
    {0x5E71, 32, OF_TELEGRAMS, NULL, {NULL}, 0},
    {0x5E72, 64, OF_TELEGRAMS, NULL, {NULL}, 0},
    {0x5E73, 128, OF_TELEGRAMS, NULL, {NULL}, 0},
    {DIAGNOSIS_FIELDBUS, WORD_SIZE, OF_BITS, &hf_diagnosis, {&hf_interface, &hf_fault}, 0xFF00},
    {0x5FF2, WORD_SIZE, OF_BITS, &hf_status, {&hf_bus, &hf_memory}, 0xFFF7},
    {0x5FF5, WORD_SIZE, OF_BITS, &hf_ppc, {NULL}, 0xFFFF},
    {FAULT_CODE_PPC, WORD_SIZE, OF_BITS, &hf_fault_ppc, {&hf_communication, &hf_process_data}, 0xFFFF},
    {0x5FFC, 0, OF_NOTHING_KNOWN, NULL, {NULL}, 0},
    {0x5FFD, 0, OF_NOTHING_KNOWN, NULL, {NULL}, 0},
    {0x5FFE, 0, OF_NOTHING_KNOWN, NULL, {NULL}, 0},
};

static const object_t *
find_object(uint16_t number)
{
    for (unsigned i = 0; i < array_length(objects); i++) {
        if (objects[i].number == number)
            return &objects[i];
    }
    return NULL;
}

bool
synaxobj_is_known(uint16_t number)
{
    return find_object(number) != NULL;
}

static bool
holds_telegrams(uint16_t number)
{
    const object_t *object = find_object(number);

    return object != NULL && object->content == OF_TELEGRAMS;
}

/* What is written, until the object is written again. */
typedef struct {
    uint32_t frame;
    int64_t moment;
    uint32_t answer_in; /* the first; 0: none yet */
    uint32_t next_in;   /* the next write request; 0: none yet */
} request_t;

/* The relations of a packet. */
typedef struct {
    request_t *request;
    int64_t elapsed; /* of an answer */
} link_t;

typedef struct {
    uint64_t line;
    uint64_t object; /* and channel */
} object_key_t;

_Static_assert(sizeof(object_key_t) == 8 + 8, "the key is hashed byte by byte, so it has no gaps");

static wmem_map_t *requests; /* the last of each object */

static unsigned
hash_key(const void *key)
{
    return wmem_strong_hash(key, sizeof(object_key_t));
}

static gboolean
are_keys_equal(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(object_key_t)) == 0;
}

static void
begin_exchange(const object_key_t *key, const packet_info *pinfo, link_t *link)
{
    request_t *before = wmem_map_lookup(requests, key);

    if (before != NULL)
        before->next_in = pinfo->num;
    link->request = wmem_new0(wmem_file_scope(), request_t);
    link->request->frame = pinfo->num;
    link->request->moment = sertap_ns(&pinfo->abs_ts);
    wmem_map_insert(requests, wmem_memdup(wmem_file_scope(), key, sizeof *key), link->request);
}

static void
end_exchange(const object_key_t *key, const packet_info *pinfo, link_t *link)
{
    link->request = wmem_map_lookup(requests, key);
    if (link->request == NULL)
        return;
    if (link->request->answer_in == 0)
        link->request->answer_in = pinfo->num;
    link->elapsed = sertap_elapsed(link->request->moment, sertap_ns(&pinfo->abs_ts));
}

/* One exchange is a write request and one or more reads of the same object (p. 2-16). Found in the first
 * pass, and kept for later passes. NULL: the packet belongs to none. */
static const link_t *
find_link(packet_info *pinfo, uint32_t place, const synaxobj_access_t *access)
{
    object_key_t key = {.line = sertap_line_key(pinfo),
                        .object = (uint64_t)access->channel << 16 | access->number};
    link_t *link = p_get_proto_data(wmem_file_scope(), pinfo, proto_synaxobj, place);

    if (link != NULL || PINFO_FD_VISITED(pinfo) || !holds_telegrams(access->number))
        return link;
    link = wmem_new0(wmem_file_scope(), link_t);
    if (access->operation == SYNAXOBJ_WRITE_REQUEST)
        begin_exchange(&key, pinfo, link);
    else if (access->operation == SYNAXOBJ_READ_ANSWER)
        end_exchange(&key, pinfo, link);
    p_add_proto_data(wmem_file_scope(), pinfo, proto_synaxobj, place, link);
    return link;
}

/* The object being dissected. */
typedef struct {
    tvbuff_t *tvb;
    packet_info *pinfo;
    proto_tree *parent;
    proto_tree *tree;
    proto_item *root;
    const synaxobj_access_t *access;
    unsigned offset, length;
} dissection_t;

static void
show_link(const dissection_t *d, const link_t *link)
{
    const request_t *request = link != NULL ? link->request : NULL;

    if (request == NULL)
        return;
    if (d->access->operation == SYNAXOBJ_READ_ANSWER) {
        proto_item_set_generated(
            proto_tree_add_uint(d->tree, hf_synax_request_in, d->tvb, 0, 0, request->frame));
        proto_item_set_generated(
            sertap_add_ms(d->tree, hf_synax_answer_time, d->tvb, 0, 0, d->pinfo->pool, link->elapsed));
    } else if (request->answer_in != 0) {
        proto_item_set_generated(
            proto_tree_add_uint(d->tree, hf_synax_answer_in, d->tvb, 0, 0, request->answer_in));
    } else if (request->next_in != 0) {
        expert_add_info_format(d->pinfo, d->root, &ei_synax_unanswered,
                               "No answer was read before the next write request, in frame %u",
                               request->next_in);
    }
}

static void
add_raw(const dissection_t *d, int hf, unsigned offset, unsigned length)
{
    if (length > 0)
        proto_tree_add_item(d->tree, hf, d->tvb, offset, length, ENC_NA);
}

static bool
is_zero(const dissection_t *d)
{
    for (unsigned i = 0; i < d->length; i++) {
        if (compat_get_uint8(d->tvb, d->offset + i) != 0)
            return false;
    }
    return true;
}

static void
dissect_no_telegram(const dissection_t *d)
{
    bool is_empty = is_zero(d);

    add_raw(d, hf_raw, d->offset, d->length);
    col_append_str(d->pinfo->cinfo, COL_INFO, is_empty ? "  empty" : "  no telegram");
    if (!is_empty)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_note,
                               "The object does not begin with a telegram");
}

/* The whole telegram with its head of 8 bytes, and the padding of the object (p. 2-16). */
static void
dissect_telegram(const dissection_t *d)
{
    unsigned declared = d->length >= 4 ? sis_declared_length(d->tvb, d->offset) : 0;
    unsigned extent = declared > 0 && declared <= d->length ? declared : d->length;

    if (compat_get_uint8(d->tvb, d->offset) != SIS_START) {
        dissect_no_telegram(d);
        return;
    }
    add_raw(d, hf_padding, d->offset + extent, d->length - extent);
    col_append_str(d->pinfo->cinfo, COL_INFO, "  ");
    col_set_fence(d->pinfo->cinfo, COL_INFO);
    call_dissector(sis, tvb_new_subset_length(d->tvb, d->offset, extent), d->pinfo, d->parent);
}

/* Each undefined set bit by its number, and one note for all of them. */
static void
add_open_bits(const dissection_t *d, proto_item *item, uint16_t bits)
{
    wmem_strbuf_t *numbers = wmem_strbuf_new(d->pinfo->pool, "");
    proto_tree *tree = proto_item_add_subtree(item, ett_word);

    for (unsigned bit = 0; bit < 16; bit++) {
        if ((bits >> bit & 1) == 0)
            continue;
        proto_tree_add_uint(tree, hf_open_bit, d->tvb, d->offset, WORD_SIZE, bit);
        wmem_strbuf_append_printf(numbers, "%s%u", wmem_strbuf_get_len(numbers) > 0 ? ", " : "", bit);
    }
    if (bits != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_note, "What these bits mean is not defined: %s",
                               wmem_strbuf_get_str(numbers));
}

static void
report_fault(const dissection_t *d, proto_item *item, uint16_t word)
{
    if (d->access->number == FAULT_CODE_PPC && word != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_error,
                               "Fault of the PPC: process data channel 0x%02x, communication channel 0x%02x",
                               word & 0xFF, word >> 8);
    else if (d->access->number == DIAGNOSIS_FIELDBUS && (word & 0xFF) != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_error, "Fault of the fieldbus: 0x%02x", word & 0xFF);
}

/* High byte first, as PCP has its words. */
static void
dissect_word(const dissection_t *d, const object_t *object)
{
    proto_item *item;
    uint16_t word;

    if (d->length < WORD_SIZE) {
        add_raw(d, hf_raw, d->offset, d->length);
        expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "The object has 2 bytes, not 1");
        return;
    }
    word = compat_get_uint16(d->tvb, d->offset, ENC_BIG_ENDIAN);
    item = proto_tree_add_item(d->tree, *object->hf, d->tvb, d->offset, WORD_SIZE, ENC_BIG_ENDIAN);
    for (unsigned i = 0; i < MOST_FIELDS && object->fields[i] != NULL; i++)
        proto_tree_add_item(proto_item_add_subtree(item, ett_word), *object->fields[i], d->tvb, d->offset,
                            WORD_SIZE, ENC_BIG_ENDIAN);
    add_open_bits(d, item, word & object->open_bits);
    report_fault(d, item, word);
    add_raw(d, hf_raw, d->offset + WORD_SIZE, d->length - WORD_SIZE);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "  0x%04x", word);
}

static void
dissect_unknown(const dissection_t *d)
{
    add_raw(d, hf_raw, d->offset, d->length);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "  %u byte%s", d->length, plurality(d->length, "", "s"));
    expert_add_info_format(d->pinfo, d->root, &ei_synax_note, "What object 0x%04X holds is not defined",
                           d->access->number);
}

/* A write request and a read answer contain the object, the others do not. */
static bool
has_content(const synaxobj_access_t *access)
{
    return access->operation == SYNAXOBJ_WRITE_REQUEST || access->operation == SYNAXOBJ_READ_ANSWER;
}

static void
dissect_without_content(const dissection_t *d)
{
    add_raw(d, hf_raw, d->offset, d->length);
    if (try_val_to_str(d->access->operation, synaxobj_operations) == NULL)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_note, "Operation %u is not defined",
                               d->access->operation);
    else if (d->length > 0)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_unexpected, "A %s has no data, not %u byte%s",
                               val_to_str_const(d->access->operation, synaxobj_operations, ""), d->length,
                               plurality(d->length, "", "s"));
}

static void
dissect_content(const dissection_t *d)
{
    const object_t *object = find_object(d->access->number);

    if (!has_content(d->access)) {
        dissect_without_content(d);
        return;
    }
    if (object != NULL && object->size > 0 && d->length > object->size)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_unexpected, "The object has %u bytes, not %u",
                               object->size, d->length);
    if (d->length == 0)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "The content of the object is missing");
    else if (object == NULL || object->content == OF_NOTHING_KNOWN)
        dissect_unknown(d);
    else if (object->content == OF_BITS)
        dissect_word(d, object);
    else
        dissect_telegram(d);
}

static dissection_t
begin(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, unsigned offset, unsigned length)
{
    dissection_t d = {.tvb = tvb, .pinfo = pinfo, .parent = parent, .offset = offset, .length = length};

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SYNAXOBJ");
    d.root = proto_tree_add_item(parent, proto_synaxobj, tvb, offset, length, ENC_NA);
    d.tree = proto_item_add_subtree(d.root, ett_synaxobj);
    return d;
}

static const char *
operation_text(wmem_allocator_t *scope, unsigned operation)
{
    const char *text = try_val_to_str(operation, synaxobj_operations);

    return text != NULL ? text : wmem_strdup_printf(scope, "operation %u", operation);
}

static void
name_root(const dissection_t *d)
{
    proto_item_append_text(d->root, ", 0x%04X %s", d->access->number,
                           operation_text(d->pinfo->pool, d->access->operation));
}

void
synaxobj_dissect(tvbuff_t *tvb, unsigned offset, unsigned length, packet_info *pinfo, proto_tree *parent,
                 const synaxobj_access_t *access)
{
    dissection_t d = begin(tvb, pinfo, parent, offset, length);
    proto_item *number = proto_tree_add_uint(d.tree, hf_index, tvb, 0, 0, access->number);

    d.access = access;
    proto_item_set_generated(number);
    proto_item_set_generated(proto_tree_add_uint(d.tree, hf_operation, tvb, 0, 0, access->operation));
    name_root(&d);
    col_append_fstr(pinfo->cinfo, COL_INFO, "  0x%04X", access->number);
    show_link(&d, find_link(pinfo, tvb_raw_offset(tvb) + offset, access));
    dissect_content(&d);
}

/* The head is defined by this project, in README.md. */
static void
dissect_named(const dissection_t *d)
{
    bool is_cut = tvb_captured_length(d->tvb) < tvb_reported_length(d->tvb);

    proto_tree_add_item(d->tree, hf_index, d->tvb, 0, 2, ENC_BIG_ENDIAN);
    proto_tree_add_item(d->tree, hf_operation, d->tvb, 2, 1, ENC_NA);
    name_root(d);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "0x%04X %s", d->access->number,
                    operation_text(d->pinfo->pool, d->access->operation));
    if (is_cut) {
        add_raw(d, hf_raw, d->offset, d->length);
    } else {
        show_link(d, find_link(d->pinfo, tvb_raw_offset(d->tvb), d->access));
        dissect_content(d);
    }
}

static int
dissect_synaxobj(tvbuff_t *tvb, packet_info *pinfo, proto_tree *parent, void *data _U_)
{
    unsigned there = tvb_captured_length(tvb);
    dissection_t d = begin(tvb, pinfo, parent, 0, there);
    synaxobj_access_t access = {0};

    col_clear(pinfo->cinfo, COL_INFO);
    if (there < HEAD_SIZE) {
        add_raw(&d, hf_raw, 0, there);
        col_append_str(pinfo->cinfo, COL_INFO, "Object without its head");
        if (there == tvb_reported_length(tvb))
            expert_add_info_format(pinfo, d.root, &ei_synax_short, "Index and operation have 3 bytes, not %u",
                                   there);
    } else {
        access.number = compat_get_uint16(tvb, 0, ENC_BIG_ENDIAN);
        access.operation = compat_get_uint8(tvb, 2);
        d.access = &access;
        d.offset = HEAD_SIZE;
        d.length = there - HEAD_SIZE;
        dissect_named(&d);
    }
    tvb_ensure_bytes_exist(tvb, 0, (int)tvb_reported_length(tvb));
    return (int)there;
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_index, {"Object", "synaxobj.index", FT_UINT16, BASE_HEX, VALS(synaxobj_names), 0, NULL, HFILL}},
    {&hf_operation, {"Operation", "synaxobj.operation", FT_UINT8, BASE_DEC, VALS(synaxobj_operations), 0, NULL, HFILL}},
    {&hf_raw, {"Raw", "synaxobj.raw", FT_BYTES, BASE_NONE, NULL, 0, "Bytes that are not decoded", HFILL}},
    {&hf_padding, {"Padding", "synaxobj.padding", FT_BYTES, BASE_NONE, NULL, 0, "What fills the object up after its telegram", HFILL}},
    {&hf_open_bit, {"Bit that is set and not defined", "synaxobj.open_bit", FT_UINT8, BASE_DEC, NULL, 0, NULL, HFILL}},
    {&hf_diagnosis, {"Diagnosis fieldbus", "synaxobj.diagnosis", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_interface, {"Interface", "synaxobj.diagnosis.interface", FT_UINT16, BASE_DEC, NULL, 0xF000, "Which is which is not defined", HFILL}},
    {&hf_fault, {"Fault code", "synaxobj.diagnosis.fault", FT_UINT16, BASE_HEX, NULL, 0x00FF, "Of the fieldbus, each has its own", HFILL}},
    {&hf_status, {"Status fieldbus", "synaxobj.status", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_bus, {"Bus", "synaxobj.status.bus", FT_BOOLEAN, 16, TFS(&no_bus_failure), 0x0008, NULL, HFILL}},
    {&hf_memory, {"State of the dual-port RAM", "synaxobj.status.memory", FT_UINT16, BASE_DEC, NULL, 0x0003, "Which is which is not defined", HFILL}},
    {&hf_ppc, {"Word of the PPC", "synaxobj.ppc", FT_UINT16, BASE_HEX, NULL, 0, NULL, HFILL}},
    {&hf_fault_ppc, {"Fault code PPC", "synaxobj.fault", FT_UINT16, BASE_HEX, NULL, 0, "The next valid access clears it", HFILL}},
    {&hf_communication, {"Communication channel", "synaxobj.fault.communication", FT_UINT16, BASE_HEX, NULL, 0xFF00, NULL, HFILL}},
    {&hf_process_data, {"Process data channel", "synaxobj.fault.process_data", FT_UINT16, BASE_HEX, NULL, 0x00FF, NULL, HFILL}},
};
/* clang-format on */

void
synaxobj_register(void)
{
    static int *trees[] = {&ett_synaxobj, &ett_word};

    proto_synaxobj = proto_register_protocol("Rexroth SYNAX200 object", "SYNAXOBJ", "synaxobj");
    proto_register_field_array(proto_synaxobj, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    register_dissector("synaxobj", dissect_synaxobj, proto_synaxobj);
    requests = wmem_map_new_autoreset(wmem_epan_scope(), wmem_file_scope(), hash_key, are_keys_equal);
}

void
synaxobj_handoff(void)
{
    sis = find_dissector_add_dependency("sis", proto_synaxobj);
}
