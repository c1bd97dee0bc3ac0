# SPDX-License-Identifier: GPL-2.0-or-later
"""The description in C: codes with their texts (codes), limits (limits), services (services), protocols with their
fields (fields).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from description import (
    TYPES,
    Code,
    Description,
    Expert,
    Field,
    Item,
    Layout,
    Preference,
    Protocol,
    Service,
    Services,
    Table,
)

LICENCE = "/* SPDX-License-Identifier: GPL-2.0-or-later */"
WIDTH = 110


def identifier(filter_: str) -> str:
    """Return a filter name as a part of a C name: "sis_flash_address"."""
    return filter_.replace(".", "_")


def _made_from(source: str, about: str) -> list[str]:
    return [LICENCE, f"/* {about}", f" * Made by generate.py from {source}: edit there. */", "/* clang-format off */"]


def _header(name: str, source: str, about: str, lines: Iterable[str]) -> str:
    guard = f"PROTOCOL_{name.upper()}_H"
    head = [*_made_from(source, about), "", f"#ifndef {guard}", f"#define {guard}", ""]
    return "\n".join([*head, *lines, "", "#endif", ""])


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _comment(text: str) -> Iterator[str]:
    """Return a comment in as many lines as it needs."""
    line = "/*"
    for word in text.split():
        if len(line) + len(word) > WIDTH - 4:
            yield line
            line = " *"
        line += " " + word
    yield line + " */"


# Codes


def _kind(table: Table) -> str:
    return "range_string" if table.has_ranges else "value_string"


def _constants(table: Table) -> Iterator[str]:
    named = [code for code in table.codes if code.constant]
    if named:
        yield "typedef enum {" if table.enum else "enum {"
        yield from (f"    {code.constant} = {code.key}," for code in named)
        yield f"}} {table.enum};" if table.enum else "};"


def codes_h(description: Description) -> str:
    """Return codes.h."""
    lines = ['#include "compat.h"', ""]
    for table in description.tables.values():
        lines += [*_comment(table.about), *_constants(table), f"extern const {_kind(table)} sis_{table.name}[];", ""]
    return _header("codes", "codes.toml", "The codes of all protocols, and their texts.", lines[:-1])


def limits_h(description: Description) -> str:
    """Return limits.h."""
    lines: list[str] = []
    for limit in description.limits:
        lines += [*_comment(limit.about), f"#define {limit.constant} {limit.number}", ""]
    return _header("limits", "limits.toml", "What the dissectors keep, show and accept.", lines[:-1])


def _entry(table: Table, code: Code) -> str:
    first, _, last = (code.constant or code.key).partition("-")
    numbers = f"{first}, {last or first}" if table.has_ranges else first
    return f"    {{{numbers}, {_string(code.text)}}},"


def codes_c(description: Description) -> str:
    """Return codes.c."""
    lines = [
        *_made_from("codes.toml", "The codes of all protocols, and their texts."),
        "",
        '#include "protocol/codes.h"',
    ]
    for table in description.tables.values():
        end = "    {0, 0, NULL}," if table.has_ranges else "    {0, NULL},"
        lines += ["", f"const {_kind(table)} sis_{table.name}[] = {{"]
        lines += [*(_entry(table, code) for code in table.codes), end, "};"]
    return "\n".join([*lines, ""])


# Fields and expert items


def _masks(description: Description) -> Iterator[str]:
    """Return the masks as constants: SIS_CONTROL_REACTION for sis.control.reaction."""
    for field in description.fields:
        if field.mask:
            yield f"#define {identifier(field.filter).upper()} 0x{field.mask:02X}"


def fields_h(description: Description) -> str:
    """Return fields.h."""
    lines = [
        "#include <epan/expert.h>",
        "#include <epan/prefs.h>",
        "",
        '#include "protocol/codes.h"',
        "",
        *_comment("The masks of fields that are bits of another."),
    ]
    lines += [*_masks(description), ""]
    lines += [f"extern int hf_{identifier(field.filter)};" for field in description.fields] + [""]
    lines += [f"extern expert_field ei_{identifier(item.filter)};" for item in description.experts] + [""]
    lines += [f"extern int proto_{protocol.key};" for protocol in description.protocols] + [""]
    lines += [f"extern int ett_{name};" for name in _subtrees(description.protocols)] + [""]
    lines += [*_comment("Preferences.")]
    lines += [f"extern {PREFERENCES[kind][0]}{name};" for name, kind in _preferences(description.protocols)] + [""]
    lines += [*_comment("Registers all protocols, and all of them that stands here."), "void protocol_register(void);"]
    return _header("fields", SOURCES, ABOUT, lines)


# The C type of a preference, and the function that registers it.
PREFERENCES = {
    "choice": ("int ", "prefs_register_enum_preference"),
    "number": ("unsigned ", "prefs_register_uint_preference"),
    "boolean": ("compat_bool ", "prefs_register_bool_preference"),
    "ports": ("range_t *", "prefs_register_range_preference"),
}
SOURCES = "protocols.toml, fields.toml and experts.toml"
ABOUT = "All protocols: their fields, expert items, subtrees and preferences."


def _subtrees(protocols: Iterable[Protocol]) -> Iterator[str]:
    """Return the names of subtrees: "sis_control", and "sis" for the protocol itself."""
    for protocol in protocols:
        yield from ("_".join(filter(None, (protocol.key, subtree))) for subtree in ("", *protocol.subtrees))


def _preferences(protocols: Iterable[Protocol]) -> Iterator[tuple[str, str]]:
    """Return the variables of preferences, and their kinds."""
    for protocol in protocols:
        yield from ((f"pref_{protocol.key}_{one.name}", one.kind) for one in protocol.preferences)


def _default(preference: Preference) -> str:
    if preference.kind == "ports":
        return "NULL"
    return str(preference.default).upper() if preference.kind == "boolean" else str(preference.default)


def _preference(protocol: str, preference: Preference) -> Iterator[str]:
    variable = f"pref_{protocol}_{preference.name}"
    words = ["module", _string(preference.name), _string(preference.title), _string(preference.means)]
    match preference.kind:
        case "choice":
            words += [f"&{variable}", f"choices_{protocol}_{preference.name}", "FALSE"]
        case "number":
            words += ["10", f"&{variable}"]
        case "ports":
            words += [f"&{variable}", "MOST_PORT"]
            yield f'    range_convert_str(wmem_epan_scope(), &{variable}, "", MOST_PORT);'
        case _:
            words += [f"&{variable}"]
    yield f"    {PREFERENCES[preference.kind][1]}({', '.join(words)});"


def _display(field: Field) -> str:
    if field.kind == "boolean" and field.width:
        return str(field.width)
    if field.shown_by:
        return "BASE_CUSTOM"
    return f"BASE_{field.base.upper() or 'NONE'}" + (" | BASE_UNIT_STRING" if field.unit else "")


def _strings(description: Description, field: Field) -> tuple[str, str]:
    """Return what names the values of a field, and what has to be added to its display."""
    name = identifier(field.filter)
    if field.codes:
        has_ranges = description.tables[field.codes].has_ranges
        return (f"RVALS(sis_{field.codes})", " | BASE_RANGE_STRING") if has_ranges else (f"VALS(sis_{field.codes})", "")
    if field.texts:
        return f"TFS(&texts_{name})", ""
    if field.unit:
        return f"UNS(&unit_{name})", ""
    if field.link:
        return f"FRAMENUM_TYPE(FT_FRAMENUM_{field.link.upper()})", ""
    return (f"CF_FUNC({field.shown_by})", "") if field.shown_by else ("NULL", "")


def _mask(field: Field) -> str:
    """Return a mask with as many digits as its integer has: Wireshark's checkers want that."""
    bits = field.width or int(field.kind.removeprefix("uint") if field.kind.startswith("uint") else 8)
    return f"0x{field.mask:0{bits // 4}X}" if field.mask else "0"


def _field(description: Description, field: Field) -> str:
    strings, display = _strings(description, field)
    words = [
        _string(field.name),
        _string(field.filter),
        f"FT_{TYPES[field.kind]}",
        _display(field) + display,
        strings,
        _mask(field),
        _string(field.means) if field.means else "NULL",
        "HFILL",
    ]
    return f"        {{&hf_{identifier(field.filter)}, {{{', '.join(words)}}}}},"


def _expert(item: Expert) -> str:
    """Write an item as EXPFILL does, but with a description."""
    words = [_string(item.filter), f"PI_{item.group.upper()}", f"PI_{item.severity.upper()}", _string(item.says)]
    field = f"{{0, {{NULL, NULL, FT_NONE, BASE_NONE, NULL, 0, {_string(f'{item.means} {item.do}')}, HFILL}}}}"
    return f"        {{&ei_{identifier(item.filter)}, {{{', '.join(words)}, 0, NULL, 0, {field}}}}},"


def _helpers(description: Description) -> Iterator[str]:
    """Return what the registrations point to: pairs of texts, units, functions."""
    for field in description.fields:
        name = identifier(field.filter)
        if field.texts:
            yield f"static const true_false_string texts_{name} = {{{', '.join(map(_string, field.texts))}}};"
        if field.unit:
            units = [_string(text) for text in field.unit] + ["NULL"]
            yield f"static const unit_name_string unit_{name} = {{{', '.join(units[:2])}}};"
    for protocol in description.protocols:
        for preference in (one for one in protocol.preferences if one.choices):
            yield f"static const enum_val_t choices_{protocol.key}_{preference.name}[] = {{"
            yield from (f"    {{{_string(key)}, {_string(text)}, {value}}}," for key, text, value in preference.choices)
            yield "    {NULL, NULL, 0},"
            yield "};"


def _register(description: Description, protocol: Protocol) -> Iterator[str]:
    fields = [field for field in description.fields if field.protocol == protocol.key]
    experts = [item for item in description.experts if item.protocol == protocol.key]
    proto = f"proto_{protocol.key}"
    yield from ["", "static void", f"register_{protocol.key}(void)", "{"]
    if fields:
        yield "    static hf_register_info fields[] = {"
        yield from (_field(description, field) for field in fields)
        yield "    };"
    if experts:
        yield "    static ei_register_info experts[] = {"
        yield from map(_expert, experts)
        yield "    };"
    yield f"    static int *subtrees[] = {{{', '.join(f'&ett_{name}' for name in _subtrees([protocol]))}}};"
    if protocol.preferences:
        yield "    module_t *module;"
    yield ""
    names = ", ".join(map(_string, (protocol.name, protocol.short, protocol.key)))
    yield f"    {proto} = proto_register_protocol({names});"
    if fields:
        yield f"    proto_register_field_array({proto}, fields, array_length(fields));"
    if experts:
        yield f"    expert_register_field_array(expert_register_protocol({proto}), experts, array_length(experts));"
    yield "    proto_register_subtree_array(subtrees, array_length(subtrees));"
    if protocol.preferences:
        yield f"    module = prefs_register_protocol({proto}, NULL);"
    for preference in protocol.preferences:
        yield from _preference(protocol.key, preference)
    yield "}"


def fields_c(description: Description) -> str:
    """Return fields.c."""
    lines = _made_from(SOURCES, ABOUT)
    lines += ["", '#include "protocol/fields.h"', "", '#include "items.h"', ""]
    lines += ["#define MOST_PORT 65535", "", *_helpers(description), ""]
    lines += [f"int proto_{protocol.key} = -1;" for protocol in description.protocols] + [""]
    lines += [f"int ett_{name} = -1;" for name in _subtrees(description.protocols)] + [""]
    for protocol in description.protocols:
        lines += [
            f"{PREFERENCES[one.kind][0]}pref_{protocol.key}_{one.name} = {_default(one)};"
            for one in protocol.preferences
        ]
    lines.append("")
    lines += [f"int hf_{identifier(field.filter)} = -1;" for field in description.fields] + [""]
    lines += [f"expert_field ei_{identifier(item.filter)} = EI_INIT;" for item in description.experts]
    for protocol in description.protocols:
        lines += _register(description, protocol)
    lines += ["", "void", "protocol_register(void)", "{"]
    lines += [f"    register_{protocol.key}();" for protocol in description.protocols] + ["}"]
    return "\n".join([*lines, ""])


# Services


def _likes(services: Services) -> Iterator[tuple[int, int, str]]:
    """Return a service of a product group, the general one, and the preference that it needs."""
    yield from ((service, general, "NULL") for service, general in services.like.items())
    for preference, likes in services.like_if_set.items():
        yield from ((service, general, f"&pref_sis_{preference}") for service, general in likes.items())


def _item(description: Description, service: Service, item: Item) -> str:
    function = f"take_{item.name}" if item.field in (service.functions or ()) else "NULL"
    codes = description.field_of(item).codes
    words = [function, f"&hf_sis_{item.name}", f"sis_{codes}" if codes else "NULL", str(item.size)]
    return f"{{{', '.join(words)}, {str(item.may_be_missing).lower()}}}"


def _layout(description: Description, service: Service, layout: Layout) -> str:
    """Return a layout; an item without a field ends each side."""
    command, reaction = (
        f"(const sis_item_t[]){{{', '.join([*(_item(description, service, item) for item in items), '{0}'])}}}"
        for items in (layout.command, layout.reaction)
    )
    return f"{{0x{layout.subservice:02X}, {command}, {reaction}}}"


def _layouts(description: Description, service: Service) -> str:
    """Return the layouts of a service as a value of sis_layouts_t."""
    rows = ", \\\n        ".join(_layout(description, service, layout) for layout in service.layouts)
    errors = f"sis_{service.errors}" if service.errors else "NULL"
    head = f"0x{service.number:02X}, {errors}, {len(service.layouts)}"
    return f"{{{head}, (const sis_layout_t[]){{ \\\n        {rows} }}}}"


_SERVICE = """typedef struct {
    uint8_t like; /* a general service with this layout; 0: it has its own */
    const compat_bool *condition; /* a preference that must be set; NULL: always */
    const value_string *subservices; /* after the device address, which is the first byte; NULL: it has none */
    bool has_status;  /* a reaction begins with a status byte */
    bool has_control; /* the useful data begin with control byte and device address */
} sis_service_t;

extern const sis_service_t sis_services_known[256];"""


def services_h(description: Description) -> str:
    """Return services.h: layouts as macros, because functions in them are those of the file that uses them."""
    lines = ['#include "protocol/fields.h"', "", _SERVICE, ""]
    by_layout = []
    for name, service in description.services.layouts.items():
        if service.functions is None:
            by_layout.append(_layouts(description, service))
        else:
            lines += [f"#define SIS_LAYOUTS_{name.upper()} \\", f"    {_layouts(description, service)}", ""]
    lines += [*_comment("Services that have no file, because their layouts say all; the last one is none.")]
    lines += [
        "#define SIS_SERVICES_BY_LAYOUT \\",
        *(f"    {layouts}, \\" for layouts in by_layout),
        "    {0, NULL, 0, NULL}",
    ]
    return _header("services", "services.toml", "What stands in the useful data of services.", lines)


def services_c(description: Description) -> str:
    """Return services.c."""
    services = description.services
    likes = {service: (general, condition) for service, general, condition in _likes(services)}
    lines = _made_from("services.toml", "What stands in the useful data of services.")
    lines += ["", '#include "protocol/services.h"', "", "const sis_service_t sis_services_known[256] = {"]
    subservices = {one.number: f"sis_{one.subservices}" for one in services.layouts.values() if one.subservices}
    for service in sorted({*likes, *subservices, *services.with_status, *services.with_control}):
        general, condition = likes.get(service, (0, "NULL"))
        words = [str(service in known).lower() for known in (services.with_status, services.with_control)]
        words = [f"0x{general:02X}", condition, subservices.get(service, "NULL"), *words]
        lines.append(f"    [0x{service:02X}] = {{{', '.join(words)}}},")
    return "\n".join([*lines, "};", ""])
