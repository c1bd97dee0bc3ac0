# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads the description of the protocol from the .toml files beside it.

Errors of the description are ValueError and name the entry.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import checks

HERE = Path(__file__).parent
TYPES = {
    "uint8": "UINT8",
    "uint16": "UINT16",
    "uint32": "UINT32",
    "boolean": "BOOLEAN",
    "double": "DOUBLE",
    "string": "STRING",
    "bytes": "BYTES",
    "time": "RELATIVE_TIME",
    "packet": "FRAMENUM",
    "heading": "NONE",
}
LINKS = {"request", "response", "retrans_prev"}
SEVERITIES = {"chat", "note", "warn", "error"}
REPORTED = {"warn", "error"}
PREFERENCES = {"choice", "number", "boolean", "ports"}
GROUPS = {"checksum", "malformed", "protocol", "response_code", "sequence", "undecoded"}


@dataclass(frozen=True)
class Preference:
    """A preference of a protocol; the keys are those of protocols.toml."""

    name: str
    title: str
    means: str
    kind: str  # of PREFERENCES
    default: int
    choices: Sequence[tuple[str, str, int]]  # name, text, value


@dataclass(frozen=True)
class Protocol:
    """A protocol; the keys are those of protocols.toml."""

    key: str
    name: str
    short: str
    subtrees: Sequence[str]
    preferences: Sequence[Preference]


@dataclass(frozen=True)
class Field:
    """A display filter field; the keys are those of fields.toml."""

    filter: str  # "sis.flash.address"
    name: str
    kind: str  # a key of TYPES
    base: str  # "dec", "hex" or "": how a number is shown
    mask: int
    width: int  # of the integer that holds a boolean with a mask, in bits
    codes: str  # a table of codes.toml, or ""
    texts: Sequence[str]  # of a boolean: true, false
    unit: Sequence[str]  # behind one, behind several
    link: str  # what a packet number leads to: a key of LINKS, or ""
    shown_by: str  # the C function that shows it, or ""
    means: str

    @property
    def protocol(self) -> str:
        """Return the protocol that has it: "sis"."""
        return self.filter.partition(".")[0]


@dataclass(frozen=True)
class Expert:
    """An expert item; the keys are those of experts.toml."""

    filter: str
    group: str
    severity: str
    says: str  # in the list of expert items
    means: str
    do: str
    episode: str = ""  # kind, in a report

    @property
    def protocol(self) -> str:
        """Return the protocol that has it."""
        return self.filter.partition(".")[0]


@dataclass(frozen=True)
class Code:
    """An entry of a table: one code, or a range of them."""

    first: int
    last: int
    text: str
    constant: str  # the name of the code in C and Lua, or ""
    key: str  # as it stands in codes.toml: "0x10-0x7F", "7"


@dataclass(frozen=True)
class Table:
    """A table of codes.toml."""

    name: str
    about: str  # what it is, and the chapter or figure
    codes: Sequence[Code]
    enum: str  # the C type of its constants, or ""

    @cached_property
    def has_ranges(self) -> bool:
        """Tell whether an entry is a range: then the first entry that fits counts."""
        return any(code.first != code.last for code in self.codes)


@dataclass(frozen=True)
class Limit:
    """A limit; the keys are those of limits.toml."""

    constant: str
    number: int
    about: str


@dataclass(frozen=True)
class Item:
    """A part of a layout."""

    field: str  # without its protocol: "flash.address"
    size: int  # in bytes; 0: the rest
    may_be_missing: bool

    @property
    def name(self) -> str:
        """Return the name of the field in C and Lua, without its protocol: "flash_address"."""
        return self.field.replace(".", "_")


@dataclass(frozen=True)
class Layout:
    """What follows a subservice."""

    subservice: int  # 0 if the service has none
    command: Sequence[Item]
    reaction: Sequence[Item]


@dataclass(frozen=True)
class Service:
    """A service with layouts; the keys are those of services.toml."""

    number: int
    subservices: str  # a table of codes.toml, or ""
    errors: str  # the same
    functions: Sequence[str] | None  # fields that are read by a function; None: the service has no file
    layouts: Sequence[Layout]

    @property
    def items(self) -> list[Item]:
        """Return all items of its layouts."""
        return [item for layout in self.layouts for item in [*layout.command, *layout.reaction]]


@dataclass(frozen=True)
class Services:
    """What services.toml says."""

    with_status: Sequence[int]
    with_control: Sequence[int]
    like: Mapping[int, int]  # the service of a product group, and the general one
    like_if_set: Mapping[str, Mapping[int, int]]  # the same for each preference
    layouts: Mapping[str, Service]  # by the name of their file


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with a packet; the keys are those of faults.toml."""

    name: str
    tests: Sequence[str]
    live: Sequence[str]
    title: str
    short: str
    expert: Expert  # which says what to do
    rule: str
    button: str


@dataclass(frozen=True)
class Rule:
    """A colouring rule of the profile."""

    name: str
    filter: str
    back: Sequence[int]  # red, green, blue; 16 bits each
    fore: Sequence[int]
    graph: str  # the I/O graph that counts its packets; empty if there is none


@dataclass(frozen=True)
class Button:
    """A filter button of the profile."""

    label: str
    filter: str
    says: str


def runs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    """Return the first and the last number of each run of numbers without a gap."""
    found: list[tuple[int, int]] = []
    for number in numbers:
        if found and found[-1][1] == number - 1:
            found[-1] = (found[-1][0], number)
        else:
            found.append((number, number))
    return found


def _preference(name: str, entry: Mapping[str, Any]) -> Preference:
    if entry["type"] not in PREFERENCES:
        raise ValueError(f"protocols.toml: preference {name} has an unknown type: {entry['type']}")
    first = entry.get("first", 0)
    choices = [(key, text, value) for value, (key, text) in enumerate(entry.get("choices", ()), first)]
    return Preference(name, entry["title"], entry["means"], entry["type"], entry.get("default", first), choices)


def _protocol(key: str, entry: Mapping[str, Any]) -> Protocol:
    preferences = [_preference(name, table) for name, table in entry.get("preferences", {}).items()]
    return Protocol(key, entry["name"], entry["short"], entry.get("subtrees", ()), preferences)


def _field(filter_: str, entry: Mapping[str, Any]) -> Field:
    kind, _, base = entry["type"].partition(" ")
    unknown = entry.keys() - {"name", "type", "mask", "width", "codes", "texts", "unit", "link", "shown_by", "means"}
    if kind not in TYPES or base not in {"", "dec", "hex"} or unknown or entry.get("link", "request") not in LINKS:
        raise ValueError(f"fields.toml: {filter_} has an unknown type, link or key: {entry}")
    return Field(
        filter_,
        entry["name"],
        kind,
        base,
        entry.get("mask", 0),
        entry.get("width", 0),
        entry.get("codes", ""),
        entry.get("texts", ()),
        entry.get("unit", ()),
        entry.get("link", ""),
        entry.get("shown_by", ""),
        entry.get("means", ""),
    )


def _expert(filter_: str, entry: Mapping[str, str]) -> Expert:
    if entry["severity"] not in SEVERITIES or entry["group"] not in GROUPS:
        raise ValueError(f"experts.toml: {filter_} has an unknown severity or group: {entry}")
    if entry["severity"] in REPORTED and ("episode" in entry) == ("no_episode" in entry):
        raise ValueError(f"experts.toml: {filter_} needs an episode, or the reason why it has none")
    texts = (entry.get(key, "") for key in ("means", "do", "episode"))
    return Expert(filter_, entry["group"], entry["severity"], entry["says"], *texts)


def _code(key: str, entry: str | Mapping[str, str]) -> Code:
    first, _, last = key.partition("-")
    text, constant = (entry, "") if isinstance(entry, str) else (entry["text"], entry["constant"])
    return Code(int(first, 0), int(last or first, 0), text, constant, key)


def _table(name: str, entry: Mapping[str, Any]) -> Table:
    codes = [_code(key, value) for key, value in entry["codes"].items()]
    return Table(name, entry["about"], codes, entry.get("enum", ""))


_ITEM = re.compile(r"(?P<field>[a-z_0-9.]+)(:(?P<size>\d+|\*))?(?P<missing>\?)?")


def _item(text: str) -> Item:
    found = _ITEM.fullmatch(text)
    if found is None:
        raise ValueError(f"services.toml: an item cannot be read: {text}")
    size = 0 if found["size"] == "*" else int(found["size"] or 1)
    return Item(found["field"], size, found["missing"] is not None)


_OF_SERVICE = {"service", "subservices", "errors", "functions"}


def _service(name: str, entry: Mapping[str, Any]) -> Service:
    functions = entry["functions"].split() if "functions" in entry else None
    keys = [key for key in entry if key not in _OF_SERVICE]
    if "all" in keys if "subservices" in entry else keys != ["all"]:
        raise ValueError(f"services.toml: {name} has neither subservices with layouts nor the one layout `all`")
    layouts = [_layout(key, entry[key]) for key in keys]
    return Service(int(entry["service"], 0), entry.get("subservices", ""), entry.get("errors", ""), functions, layouts)


def _layout(subservice: str, entry: Mapping[str, str]) -> Layout:
    unknown = entry.keys() - {"command", "reaction"}
    if unknown:
        raise ValueError(f"services.toml: {subservice} has unknown keys: {', '.join(unknown)}")
    command, reaction = ([_item(text) for text in entry.get(key, "").split()] for key in ("command", "reaction"))
    return Layout(0 if subservice == "all" else int(subservice, 0), command, reaction)


def _numbers(texts: Sequence[str]) -> list[int]:
    """Return the numbers of texts such as "0x10" and "0x00-0x1F"."""
    pairs = [text.partition("-") for text in texts]
    return [number for first, _, last in pairs for number in range(int(first, 0), int(last or first, 0) + 1)]


def _likes(entry: Mapping[str, str]) -> dict[int, int]:
    return {int(service, 0): int(general, 0) for service, general in entry.items()}


def _services(entry: Mapping[str, Any]) -> Services:
    return Services(
        _numbers(entry["with_status"]),
        _numbers(entry["with_control"]),
        _likes(entry["like"]),
        {preference: _likes(likes) for preference, likes in entry["like_if_set"].items()},
        {name: _service(name, table) for name, table in entry["layouts"].items()},
    )


def _one_of(tests: Iterable[str]) -> str:
    return " || ".join(tests)


class Description:
    """All that the .toml files say."""

    def __init__(self, folder: Path = HERE) -> None:
        """Read the files of a folder. ValueError if an entry makes no sense."""

        def load(name: str) -> dict[str, Any]:
            return tomllib.loads((folder / name).read_text("utf-8"))

        self.protocols = [_protocol(key, entry) for key, entry in load("protocols.toml").items()]
        self.fields = [_field(name, entry) for name, entry in load("fields.toml").items()]
        self.experts = [_expert(name, entry) for name, entry in load("experts.toml").items()]
        self.services = _services(load("services.toml"))
        self.tables = {name: _table(name, entry) for name, entry in load("codes.toml").items()}
        for field in self.fields:
            if field.codes and field.codes not in self.tables:
                raise ValueError(f"fields.toml: {field.filter} has codes that codes.toml lacks: {field.codes}")
            for wrong in checks.of_field(field):
                raise ValueError(f"fields.toml: {field.filter}: {wrong}")
        for wrong in checks.of_services(self.services, {field.filter: field for field in self.fields}, self.tables):
            raise ValueError(f"services.toml: {wrong}")
        self.limits = [Limit(name, entry["is"], entry["about"]) for name, entry in load("limits.toml").items()]
        self._check_protocols()
        self.standard = load("standard.toml")
        self.s_names = {int(number): name for number, name in load("names.toml")["s_names"].items()}
        faults = load("faults.toml")
        self.faults = [self._fault(name, entry) for name, entry in faults["faults"].items()]
        self.rules = [self._rule(name, entry) for name, entry in faults["rules"].items()]
        self.buttons = [self._button(label, entry) for label, entry in faults["buttons"].items()]
        self._check_faults()

    def _fault(self, name: str, entry: Mapping[str, Any]) -> Fault:
        texts = entry["title"], entry["short"]
        return Fault(
            *(name, entry["tests"], entry.get("live", ()), *texts, self.expert(entry["expert"])),
            *(entry["rule"], entry["button"]),
        )

    def expert(self, name: str) -> Expert:
        """Return an expert item by its filter. ValueError if there is none."""
        for item in self.experts:
            if item.filter == name:
                return item
        raise ValueError(f"experts.toml has no {name}")

    def _rule(self, name: str, entry: Mapping[str, Any]) -> Rule:
        tests = [test for fault in self.faults if fault.rule == name for test in fault.tests]
        return Rule(name, _one_of(tests) or entry["filter"], entry["back"], entry["fore"], entry.get("graph", ""))

    def _button(self, label: str, entry: Mapping[str, Any]) -> Button:
        tests = [test for fault in self.faults if fault.button == label for test in fault.tests]
        services = self.with_layout_of(_numbers(entry.get("services", ())))
        if services:
            tests.append(f"sis.service in {{{', '.join(f'0x{service:02x}' for service in services)}}}")
        return Button(label, _one_of(tests) or entry["filter"], entry["says"])

    def with_layout_of(self, services: Sequence[int]) -> list[int]:
        """Return general services and those of product groups that are like them, with preferences or without."""
        likes = [self.services.like, *self.services.like_if_set.values()]
        return sorted([*services, *(one for like in likes for one, general in like.items() if general in services)])

    def _check_faults(self) -> None:
        """ValueError if a fault has a rule or button that does not exist."""
        rules, buttons = {rule.name for rule in self.rules}, {button.label for button in self.buttons}
        for fault in self.faults:
            if fault.rule not in rules or fault.button not in buttons:
                raise ValueError(f"faults.toml: {fault.name} has a rule or a button that does not exist")

    def field_of(self, item: Item) -> Field:
        """Return the field of an item."""
        return next(field for field in self.fields if field.filter == f"sis.{item.field}")

    def _check_protocols(self) -> None:
        """ValueError if a field or an expert item belongs to no protocol."""
        known = {protocol.key for protocol in self.protocols}
        names = [(field.filter, field.protocol) for field in self.fields]
        for name, protocol in [*names, *((item.filter, item.protocol) for item in self.experts)]:
            if protocol not in known:
                raise ValueError(f"protocols.toml has no protocol for {name}")
