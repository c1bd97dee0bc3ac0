# SPDX-License-Identifier: GPL-2.0-or-later
"""Every call of the plugin that adds a field: its length and its type are those of fields.toml.

Wireshark's own checkers know only the fields that a file itself registers; here one file registers all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from description import Description, Field
from in_c import identifier

PLUGIN = Path(__file__).resolve().parent.parent / "plugin"
INTEGERS, PACKETS = {"uint8", "uint16", "uint32"}, {"packet"}
BYTES = {"uint8": 1, "uint16": 2, "uint32": 4}

# What a call adds: the kinds of the fields that it may have.
KINDS = {
    **dict.fromkeys(
        ("proto_tree_add_uint", "proto_tree_add_uint_format", "proto_tree_add_uint_format_value"), INTEGERS | PACKETS
    ),
    **dict.fromkeys(("add_generated", "add_link", "add_frame"), INTEGERS | PACKETS),
    **dict.fromkeys(("proto_tree_add_string", "proto_tree_add_string_format"), {"string"}),
    **dict.fromkeys(("proto_tree_add_time_format_value", "sertap_add_ms"), {"time"}),
    **dict.fromkeys(
        ("proto_tree_add_double", "proto_tree_add_double_format_value", "sertap_add_column_ms"), {"double"}
    ),
    "proto_tree_add_boolean": {"boolean"},
    **dict.fromkeys(("add_raw", "add_rest"), {"bytes"}),
    "proto_tree_add_item": {*INTEGERS, "boolean", "string", "bytes", "heading"},
    "sis_take": {*INTEGERS, "boolean"},
    "sis_take_code": INTEGERS,
    "sis_take_text": {"string"},
    "sis_take_rest": {"bytes", "string"},
}
# Which argument of a call is a length that its field must have.
LENGTHS = {"proto_tree_add_item": 4, "sis_take": 2}
CALL = re.compile(rf"\b({'|'.join(KINDS)})\(")
DEFINE = re.compile(r"^#define (\w+) +(0x[0-9A-Fa-f]+|\d+)u?(?: |$)", re.MULTILINE)


def fields() -> dict[str, Field]:
    return {f"hf_{identifier(field.filter)}": field for field in Description().fields}


def arguments(text: str, at: int) -> list[str]:
    """Split the arguments of a call, from behind its bracket on."""
    found, depth = [""], 1
    for character in text[at:]:
        depth += (character in "([{") - (character in ")]}")
        if depth == 0:
            break
        if character == "," and depth == 1:
            found.append("")
        else:
            found[-1] += character
    return [" ".join(argument.split()) for argument in found]


def number(text: str, known: dict[str, int]) -> int | None:
    """Return a length that the source says as a number or by its name."""
    return int(text) if text.isdecimal() else known.get(text)


def size(field: Field) -> int | None:
    """Return how many bytes a field has; None: any number."""
    if field.kind == "boolean":
        return field.width // 8 if field.mask else None
    return BYTES.get(field.kind)


def wrong(source: str, all_fields: dict[str, Field]) -> Iterator[str]:
    """Yield the calls of a source that say something else than fields.toml."""
    known = {name: int(value, 0) for name, value in DEFINE.findall(source)}
    for call in CALL.finditer(source):
        given = arguments(source, call.end())
        names = [word for argument in given for word in re.findall(r"\bhf_\w+", argument) if word in all_fields]
        place = LENGTHS.get(call[1])
        length = number(given[place], known) if place and place < len(given) else None
        for field in (all_fields[name] for name in names[:1]):
            if field.kind not in KINDS[call[1]]:
                yield f"{call[1]}({field.filter}): a {field.kind}"
            elif length and size(field) not in (None, length):
                yield f"{call[1]}({field.filter}): {length} bytes, not {size(field)}"


@pytest.mark.style
def test_calls_say_what_the_description_says() -> None:
    found = {path.name: list(wrong(path.read_text(), fields())) for path in PLUGIN.rglob("*.c")}
    assert {name: calls for name, calls in found.items() if calls} == {}


# Each is a call of the plugin, with one thing made wrong.
MISTAKES = [
    ("proto_tree_add_item(tree, hf_sis_length, tvb, 2, 2, ENC_NA);", "proto_tree_add_item(sis.length): 2 bytes, not 1"),
    (
        "#define SIZE 1u\nproto_tree_add_item(d->tree, hf_synaxobj_ppc, tvb, f(a, b), SIZE, ENC_NA);",
        "proto_tree_add_item(synaxobj.ppc): 1 bytes, not 2",
    ),
    (
        "proto_tree_add_item(tree, hf_synax_info_write, tvb, 0, 1, ENC_NA);",
        "proto_tree_add_item(synax.info.write): 1 bytes, not 2",
    ),
    ("proto_tree_add_uint(tree, hf_sis_value, tvb, 0, 0, 1);", "proto_tree_add_uint(sis.value): a string"),
    (
        "sertap_add_ms(tree, hf_sis_reaction_time_ms, tvb, 0, 0, pool, ns);",
        "sertap_add_ms(sis.reaction_time.ms): a double",
    ),
    ("add_link(tree, hf_sis_reaction_time, tvb, frame);", "add_link(sis.reaction_time): a time"),
]


@pytest.mark.parametrize(("call", "said"), MISTAKES)
@pytest.mark.style
def test_a_seeded_mistake_is_found(call: str, said: str) -> None:
    assert list(wrong(call, fields())) == [said]
