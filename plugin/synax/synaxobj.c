/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Objects of SYNAX200 (chapter 2). 5E70 to 5E73 hold a SIS telegram: a request is written, its answer is read
 * from the same object (p. 2-16). 5FF0 to 5FF6 are diagnosis words (p. 2-36 to 2-40). */
#include "synax/synaxobj.h"

#include "items.h"
#include "kept.h"
#include "parts.h"
#include "protocol/fields.h"
#include "sis/asked.h"
#include "sis/frame.h"

#define WORD_SIZE   2u
#define MOST_FIELDS 2

static dissector_handle_t sis;

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
    {SYNAXOBJ_DIAGNOSIS_FIELDBUS,
     WORD_SIZE,
     OF_BITS,
     &hf_synaxobj_diagnosis,
     {&hf_synaxobj_diagnosis_interface, &hf_synaxobj_diagnosis_fault},
     0xFF00},
    {SYNAXOBJ_STATUS_FIELDBUS,
     WORD_SIZE,
     OF_BITS,
     &hf_synaxobj_status,
     {&hf_synaxobj_status_bus, &hf_synaxobj_status_memory},
     0xFFF7},
    {0x5FF5, WORD_SIZE, OF_BITS, &hf_synaxobj_ppc, {NULL}, 0xFFFF},
    {SYNAXOBJ_FAULT_CODE_PPC,
     WORD_SIZE,
     OF_BITS,
     &hf_synaxobj_fault,
     {&hf_synaxobj_fault_communication, &hf_synaxobj_fault_process_data},
     0xFFFF},
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

/* What is written, until the object is written again, or an answer. */
typedef struct {
    sis_asked_t asked;
    uint32_t next_in; /* the next write request; 0: none yet */
} link_t;

/* One exchange is a write request and one or more reads of the same object (p. 2-16). Found in the first
 * pass, and kept for later passes. */
static const link_t *
find_link(tvbuff_t *tvb, packet_info *pinfo, uint32_t place, const synaxobj_access_t *access)
{
    link_t *link = kept_of_packet(pinfo, proto_synaxobj, place, sizeof *link), *request;
    sis_times_t times = sis_times(tvb, pinfo, 0, NULL);
    void **last;

    if (PINFO_FD_VISITED(pinfo) || find_object(access->number)->content != OF_TELEGRAMS)
        return link;
    last = sis_asked_last(pinfo, proto_synaxobj, (uint32_t)access->channel << 16 | access->number);
    request = *last;
    sis_asked_note(&link->asked, pinfo, &times);
    if (access->operation == SYNAXOBJ_WRITE_REQUEST) {
        if (request != NULL)
            request->next_in = pinfo->num;
        *last = link;
    } else if (access->operation == SYNAXOBJ_READ_ANSWER && request != NULL) {
        sis_asked_answer(&link->asked, &request->asked, &times);
    }
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
    sis_asked_fields_t fields = {hf_synax_request_in, hf_synax_answer_in, hf_synax_answer_time};

    sis_asked_show(&link->asked, d->tree, d->tvb, d->pinfo, &fields);
    if (link->asked.answer_in != 0 || link->next_in == 0)
        return;
    add_generated(d->tree, hf_synax_next_request_in, d->tvb, link->next_in);
    expert_add_info_format(d->pinfo, d->root, &ei_synax_unanswered,
                           "No answer was read before the next write request");
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

    add_bytes(d->tree, hf_synaxobj_raw, d->tvb, d->offset, d->offset + d->length);
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
    add_bytes(d->tree, hf_synaxobj_padding, d->tvb, d->offset + extent, d->offset + d->length);
    col_append_str(d->pinfo->cinfo, COL_INFO, "  ");
    col_set_fence(d->pinfo->cinfo, COL_INFO);
    call_dissector(sis, tvb_new_subset_length(d->tvb, d->offset, extent), d->pinfo, d->parent);
}

/* Each undefined set bit by its number, and one note for all of them. */
static void
add_open_bits(const dissection_t *d, proto_item *item, uint16_t bits)
{
    wmem_strbuf_t *numbers = wmem_strbuf_new(d->pinfo->pool, "");
    proto_tree *tree = proto_item_add_subtree(item, ett_synaxobj_word);

    for (unsigned bit = 0; bit < 16; bit++) {
        if ((bits >> bit & 1) == 0)
            continue;
        proto_tree_add_uint(tree, hf_synaxobj_open_bit, d->tvb, d->offset, WORD_SIZE, bit);
        wmem_strbuf_append_printf(numbers, "%s%u", wmem_strbuf_get_len(numbers) > 0 ? ", " : "", bit);
    }
    if (bits != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_note, "What these bits mean is not defined: %s",
                               wmem_strbuf_get_str(numbers));
}

static void
report_fault(const dissection_t *d, proto_item *item, uint16_t word)
{
    if (d->access->number == SYNAXOBJ_FAULT_CODE_PPC && word != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_error,
                               "Fault of the PPC: process data channel 0x%02x, communication channel 0x%02x",
                               word & 0xFF, word >> 8);
    else if (d->access->number == SYNAXOBJ_DIAGNOSIS_FIELDBUS && (word & 0xFF) != 0)
        expert_add_info_format(d->pinfo, item, &ei_synax_error, "Fault of the fieldbus: 0x%02x", word & 0xFF);
    else if (d->access->number == SYNAXOBJ_STATUS_FIELDBUS && (word & SYNAXOBJ_STATUS_BUS) == 0)
        expert_add_info(d->pinfo, item, &ei_synax_failed);
}

/* High byte first, as PCP has its words. */
static void
dissect_word(const dissection_t *d, const object_t *object)
{
    proto_item *item;
    uint16_t word;

    if (d->length < WORD_SIZE) {
        add_bytes(d->tree, hf_synaxobj_raw, d->tvb, d->offset, d->offset + d->length);
        expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "The object has 2 bytes, not 1");
        return;
    }
    word = compat_get_uint16(d->tvb, d->offset, ENC_BIG_ENDIAN);
    item = proto_tree_add_item(d->tree, *object->hf, d->tvb, d->offset, WORD_SIZE, ENC_BIG_ENDIAN);
    for (unsigned i = 0; i < MOST_FIELDS && object->fields[i] != NULL; i++)
        proto_tree_add_item(proto_item_add_subtree(item, ett_synaxobj_word), *object->fields[i], d->tvb,
                            d->offset, WORD_SIZE, ENC_BIG_ENDIAN);
    add_open_bits(d, item, word & object->open_bits);
    report_fault(d, item, word);
    add_bytes(d->tree, hf_synaxobj_raw, d->tvb, d->offset + WORD_SIZE, d->offset + d->length);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "  0x%04x", word);
}

static void
dissect_unknown(const dissection_t *d)
{
    add_bytes(d->tree, hf_synaxobj_raw, d->tvb, d->offset, d->offset + d->length);
    col_append_fstr(d->pinfo->cinfo, COL_INFO, "  %u byte%s", d->length, plurality(d->length, "", "s"));
    expert_add_info_format(d->pinfo, d->root, &ei_synax_note,
                           "Control or status word of the multiplex channel: which bits are Index_out_c, "
                           "Index_in_c, RR and RA is not defined");
}

/* A write request and a read answer contain the object, the others do not. */
static void
dissect_content(const dissection_t *d)
{
    const object_t *object = find_object(d->access->number);

    if (d->access->operation != SYNAXOBJ_WRITE_REQUEST && d->access->operation != SYNAXOBJ_READ_ANSWER)
        return;
    if (object->size > 0 && d->length > object->size)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_unexpected, "More bytes than the object has");
    if (d->length == 0)
        expert_add_info_format(d->pinfo, d->root, &ei_synax_short, "The content of the object is missing");
    else if (object->content == OF_NOTHING_KNOWN)
        dissect_unknown(d);
    else if (object->content == OF_BITS)
        dissect_word(d, object);
    else
        dissect_telegram(d);
}

void
synaxobj_dissect(tvbuff_t *tvb, unsigned offset, unsigned length, packet_info *pinfo, proto_tree *parent,
                 const synaxobj_access_t *access)
{
    dissection_t d = {
        .tvb = tvb, .pinfo = pinfo, .parent = parent, .access = access, .offset = offset, .length = length};

    col_set_str(pinfo->cinfo, COL_PROTOCOL, "SYNAXOBJ");
    d.root = proto_tree_add_item(parent, proto_synaxobj, tvb, offset, length, ENC_NA);
    d.tree = proto_item_add_subtree(d.root, ett_synaxobj);
    add_generated(d.tree, hf_synaxobj_index, tvb, access->number);
    add_generated(d.tree, hf_synaxobj_operation, tvb, access->operation);
    proto_item_append_text(d.root, ", 0x%04X %s", access->number,
                           val_to_str_const(access->operation, sis_synaxobj_operations, ""));
    col_append_fstr(pinfo->cinfo, COL_INFO, "  0x%04X", access->number);
    show_link(&d, find_link(tvb, pinfo, tvb_raw_offset(tvb) + offset, access));
    dissect_content(&d);
}

void
synax_synaxobj_handoff(void)
{
    sis = find_dissector_add_dependency("sis", proto_synaxobj);
}
