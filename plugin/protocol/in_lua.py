# SPDX-License-Identifier: GPL-2.0-or-later
"""The description in Lua: blocks of sis.lua with protocols, codes, limits, services, names of parameters and fields."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from description import TYPES, Code, Description, Expert, Field, Item, Limit, Preference, Protocol, Service, Table, runs

WIDTH = 120


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _comment(text: str) -> Iterator[str]:
    """Return a comment in as many lines as it needs."""
    line = "--"
    for word in text.split():
        if len(line) + len(word) >= WIDTH:
            yield line
            line = "--"
        line += " " + word
    yield line


def _constant(of: Code | Limit) -> str:
    """Return its name without the prefix that C needs: K.STATION for SIS_STATION."""
    return "K." + of.constant.removeprefix("SIS_")


def _table(table: Table) -> Iterator[str]:
    yield from _comment(table.about)
    yield from (f"{_constant(code)} = {code.key}" for code in table.codes if code.constant)
    yield f"N.{table.name} = {{"
    for code in table.codes:
        first, _, last = code.key.partition("-")
        if table.has_ranges:
            yield f"  {{{first}, {last or first}, {_string(code.text)}}},"
        else:
            yield f"  [{_constant(code) if code.constant else first}] = {_string(code.text)},"
    yield "}"


def codes(description: Description) -> str:
    """Return the block with the codes."""
    lines: list[str] = []
    for table in description.tables.values():
        lines += [*_table(table), ""]
    return "\n".join(lines)


def limits(description: Description) -> str:
    """Return the block with the limits."""
    lines: list[str] = []
    for limit in description.limits:
        lines += [*_comment(limit.about), f"{_constant(limit)} = {limit.number}", ""]
    return "\n".join(lines)


def _strings(field: Field) -> str:
    if field.codes:
        return f"N.{field.codes}"
    if field.texts or field.unit:
        return "{" + ", ".join(map(_string, field.texts or field.unit)) + "}"
    return f"frametype.{field.link.upper()}" if field.link else "nil"


def _display(description: Description, field: Field) -> str:
    if field.kind == "boolean" and field.width:
        return str(field.width)
    ranges = bool(field.codes) and description.tables[field.codes].has_ranges
    return f"base.{field.base.upper() or 'NONE'}" + (
        " + base.UNIT_STRING" if field.unit else " + base.RANGE_STRING" if ranges else ""
    )


def _field(description: Description, field: Field) -> str:
    words = [
        _string(field.filter),
        _string(field.name),
        f"ftypes.{TYPES[field.kind]}",
        _display(description, field),
        _strings(field),
        f"0x{field.mask:02x}" if field.mask else "0",
        _string(field.means) if field.means else "nil",
    ]
    while words[-1] in {"nil", "0", "base.NONE"}:
        words.pop()
    return _call("field", words)


def _expert(item: Expert) -> str:
    return _call(
        "expert_field",
        [_string(item.filter), f'"{item.group.upper()}"', f'"{item.severity.upper()}"', _string(item.says)],
    )


def _call(function: str, words: Iterable[str]) -> str:
    """Return a call, in as many lines as it needs."""
    lines = [f"{function}("]
    for word in words:
        separator = "" if lines[-1].endswith("(") else ", "
        if len(lines[-1] + separator + word) >= WIDTH - 1:
            lines[-1] += separator.rstrip()
            lines.append("  ")
            separator = ""
        first, *rest = _parts(word)
        lines[-1] += separator + first
        lines += [f"    .. {part}" for part in rest]
    return "\n".join(lines) + ")"


def _parts(word: str) -> Sequence[str]:
    """Cut a string that is too long for a line."""
    if len(word) < WIDTH - 10:
        return [word]
    cut = word.rindex(" ", 0, WIDTH - 20) + 1
    return [word[:cut] + '"', *_parts('"' + word[cut:])]


def fields(description: Description) -> str:
    """Return the block with the fields and expert items."""
    lines = ["-- The masks of fields that are bits of another."]
    for field in description.fields:
        if field.mask and field.mask < 1 << 31:
            lines.append(f"K.{field.filter.replace('.', '_').upper().removeprefix('SIS_')} = 0x{field.mask:02X}")
    for protocol in description.protocols:
        lines += ["", f"-- {protocol.key}"]
        lines += [_field(description, field) for field in description.fields if field.protocol == protocol.key]
        lines += [_expert(item) for item in description.experts if item.protocol == protocol.key]
    return "\n".join([*lines, ""])


def _proto(protocol: Protocol) -> str:
    """Return the name of a protocol in the script: a name begins with a letter."""
    return "p" + protocol.key if protocol.key[0].isdigit() else protocol.key


def _default(preference: Preference) -> str:
    return str(preference.default).lower() if preference.kind == "boolean" else str(preference.default)


PREFERENCES = {"choice": "enum", "number": "uint", "boolean": "bool", "ports": "range"}


def _preference(protocol: Protocol, preference: Preference) -> str:
    words = [_string(preference.title), _default(preference), _string(preference.means)]
    if preference.kind == "choice":
        choices = [f"{{{_string(name)}, {_string(text)}, {value}}}" for name, text, value in preference.choices]
        words += [*("{" + choices[0] if choice is choices[0] else choice for choice in choices)]
        words[-1] += "}"
        words.append("false")
    if preference.kind == "ports":
        words[1] = '""'
        words.append("65535")
    return _call(f"{_proto(protocol)}.prefs.{preference.name} = Pref.{PREFERENCES[preference.kind]}", words)


def protocols(description: Description) -> str:
    """Return the block with the protocols and their preferences."""
    lines = []
    for protocol in description.protocols:
        lines.append(f"local {_proto(protocol)} = Proto({_string(protocol.key)}, {_string(protocol.name)})")
        lines += [_preference(protocol, preference) for preference in protocol.preferences]
    words = ", ".join(f"[{_string(protocol.key)}] = {_proto(protocol)}" for protocol in description.protocols)
    lines += ["", *_wrapped(f"local protos = {{{words}}} -- by filter name")]
    defaults = [
        f"{preference.name} = {_default(preference)}"
        for protocol in description.protocols
        if protocol.key == "sis"
        for preference in protocol.preferences
    ]
    lines += ["", *_wrapped(f"local P = {{{', '.join(defaults)}}} -- values of the preferences of sis"), ""]
    return "\n".join(lines)


def _wrapped(line: str) -> Iterator[str]:
    """Return a line as several that are not too long."""
    while len(line) >= WIDTH:
        cut = line.rindex(" ", 0, WIDTH)
        yield line[:cut]
        line = "  " + line[cut + 1 :]
    yield line


def _numbers(numbers: Mapping[int, int]) -> str:
    return ", ".join(f"[0x{number:02X}] = 0x{other:02X}" for number, other in numbers.items())


def _ranges(numbers: Sequence[int]) -> str:
    return "{" + ", ".join(f"{{0x{first:02X}, 0x{last:02X}}}" for first, last in runs(numbers)) + "}"


def _item(description: Description, item: Item) -> str:
    codes = description.field_of(item).codes
    words = [f'"{item.name}"', str(item.size)]
    if codes or item.may_be_missing:
        words.append(str(item.may_be_missing).lower())
    return "{" + ", ".join([*words, f"N.{codes}"] if codes else words) + "}"


def _service(description: Description, service: Service) -> Iterator[str]:
    yield from (f"    {key} = N.{table}," for key in ("subservices", "errors") if (table := getattr(service, key)))
    if service.functions is None:
        yield "    is_by_layout = true,"
    for layout in service.layouts:
        yield f"    [0x{layout.subservice:02X}] = {{"
        for key, items in (("command", layout.command), ("reaction", layout.reaction)):
            yield from _wrapped(f"      {key} = {{{', '.join(_item(description, item) for item in items)}}},")
        yield "    },"


def services(description: Description) -> str:
    """Return the block with what stands in the useful data of services."""
    known = description.services
    lines = ["-- Reactions of these ranges begin with a status byte."]
    lines += [f"K.WITH_STATUS = {_ranges(known.with_status)}"]
    lines += ["-- The useful data of these ranges begin with control byte and device address."]
    lines += [f"K.WITH_CONTROL = {_ranges(known.with_control)}"]
    lines += ["-- Services of product groups with the layout of a general one; K.LIKE_IF_SET: if a preference is set."]
    lines += ["K.LIKE = {", *(f"  [0x{one:02X}] = 0x{general:02X}," for one, general in known.like.items()), "}"]
    lines += ["K.LIKE_IF_SET = {"]
    lines += [f"  {preference} = {{{_numbers(likes)}}}," for preference, likes in known.like_if_set.items()]
    lines += ["}", "-- What follows a subservice: field, bytes (0: the rest), may be missing, codes.", "K.LAYOUTS = {"]
    for name, service in known.layouts.items():
        lines += [f"  [0x{service.number:02X}] = {{ -- {name}", *_service(description, service), "  },"]
    return "\n".join([*lines, "}", ""])


def names(description: Description) -> str:
    """Return the block with the names of S parameters."""
    rows = (f"  [{number}] = {_string(name)}," for number, name in description.s_names.items())
    return "\n".join(["N.s_names = {", *rows, "}", ""])
