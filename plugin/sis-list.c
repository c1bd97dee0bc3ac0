/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Service 0x04, execute a list of SIS services (chapter 7): each element is the telegram it stands for. */

#include "sis-body.h"

#define LIST_SERVICE 0x04

static int hf_length = -1;
static int ett_element = -1;
static expert_field ei_recursion = EI_INIT;

static void
add_request(sis_body_t *list, sis_request_t *request)
{
    sis_request_t **end;

    if (list->request == NULL)
        return;
    for (end = &list->request->list; *end != NULL; end = &(*end)->next)
        ;
    *end = request;
}

/* The body of an element, `length` bytes after its service, as if it were alone in a telegram. */
static void
dissect_element_body(sis_body_t *list, proto_item *root, uint8_t service, unsigned length,
                     const sis_request_t *asked)
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
                          .is_cut = list->is_cut && list->offset + length == list->end,
                          .is_nested = true,
                          .is_reaction = list->is_reaction,
                          .service = service,
                          .record = list->record,
                          .summary = wmem_strbuf_new(pool, sis_service_name(pool, service)),
                          .marks = wmem_strbuf_new(pool, ""),
                          .asked = asked != NULL && asked->service == service ? asked : NULL};

    if (!list->is_reaction) {
        element.request = wmem_new0(pool, sis_request_t);
        element.request->service = service;
        add_request(list, element.request);
    }
    sis_dissect_body(&element);
    list->is_explained |= element.is_explained || element.status != 0;
    proto_item_append_text(root, ": %s%s", wmem_strbuf_get_str(element.summary),
                           wmem_strbuf_get_str(element.marks));
    sis_say(list, "; %s%s", wmem_strbuf_get_str(element.summary), wmem_strbuf_get_str(element.marks));
}

static void
show_recursion(sis_body_t *list, unsigned length)
{
    sis_mark(list, &ei_recursion, "a list in a list");
    if (length > 0)
        proto_tree_add_item(list->tree, hf_sis_raw, list->tvb, list->offset, length, ENC_NA);
}

/* Length, service, body. */
static void
dissect_element(sis_body_t *list, unsigned number, const sis_request_t *asked)
{
    unsigned there = sis_left(list), length = compat_get_uint8(list->tvb, list->offset);
    unsigned end = MIN(length + 1, there);
    proto_item *root;
    proto_tree *outer = list->tree;
    uint32_t service;

    list->tree = proto_tree_add_subtree_format(outer, list->tvb, list->offset, end, ett_element, &root,
                                               "Element %u", number);
    sis_take(list, hf_length, 1, NULL);
    if (length == 0) {
        sis_mark(list, &ei_sis_unexpected, "element %u is empty", number);
    } else if (sis_take(list, hf_sis_service, 1, &service)) {
        if (length + 1 > there && !list->is_cut)
            sis_mark(list, &ei_sis_missing, "element %u is cut", number);
        if (service == LIST_SERVICE)
            show_recursion(list, end - 2);
        else
            dissect_element_body(list, root, (uint8_t)service, end - 2, asked);
        list->offset += end - 2;
    }
    list->tree = outer;
}

void
sis_dissect_list(sis_body_t *body)
{
    const sis_request_t *asked = body->asked != NULL ? body->asked->list : NULL;

    if (body->is_reaction && sis_take_channel_error(body))
        return;
    for (unsigned number = 1; sis_left(body) > 0 && !body->is_short; number++) {
        dissect_element(body, number, asked);
        asked = asked != NULL ? asked->next : NULL;
    }
}

/* clang-format off */
static hf_register_info fields[] = {
    {&hf_length, {"Length", "sis.element_length", FT_UINT8, BASE_DEC, NULL, 0, "Service and body of this element", HFILL}},
};

static ei_register_info experts[] = {
    {&ei_recursion, {"sis.list.recursion", PI_PROTOCOL, PI_ERROR, "Service 0x04 must not be in its own list", EXPFILL}},
};
/* clang-format on */

void
sis_list_register(void)
{
    static int *trees[] = {&ett_element};

    proto_register_field_array(proto_sis, fields, array_length(fields));
    proto_register_subtree_array(trees, array_length(trees));
    expert_register_field_array(sis_experts, experts, array_length(experts));
}
