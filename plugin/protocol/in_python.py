# SPDX-License-Identifier: GPL-2.0-or-later
"""The description in Python: what sistap needs of it without Wireshark (sistap/tap/sis/codes.py)."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence

from description import Code, Description, Item, Service, runs

FOLD = 100  # characters of a string in a line

HEAD = '''# SPDX-License-Identifier: GPL-2.0-or-later
"""Codes of services, and what stands in their useful data.

Made by plugin/protocol/generate.py from codes.toml and services.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple


class Item(NamedTuple):
    """A part of the useful data: a field of the dissector without "sis.", and its bytes."""

    field: str
    size: int  # 0: the rest
    may_be_missing: bool = False


class Layout(NamedTuple):
    """What follows a subservice in a command, and in a good reaction."""

    command: Sequence[Item]
    reaction: Sequence[Item]
'''


def _numbers(numbers: Iterable[int]) -> str:
    return ", ".join(f"0x{number:02X}" for number in numbers)


def _pairs(pairs: Mapping[int, int]) -> str:
    return "{" + ", ".join(f"0x{number:02X}: 0x{other:02X}" for number, other in pairs.items()) + "}"


def _ranges(numbers: Sequence[int]) -> str:
    """Return the set of numbers that may be many."""
    ranges = (f"*range(0x{first:02X}, 0x{last + 1:02X})" for first, last in runs(numbers))
    return f"frozenset(({', '.join(ranges)}))"


def _items(items: Sequence[Item]) -> str:
    words = [f'Item("{item.field}", {item.size}{", True" if item.may_be_missing else ""})' for item in items]
    return f"({', '.join(words)}{',' if len(words) == 1 else ''})"


def _layouts(services: Iterable[Service]) -> Iterator[str]:
    for service in services:
        yield f"    0x{service.number:02X}: {{"
        for row in service.layouts:
            yield f"        0x{row.subservice:02X}: Layout({_items(row.command)}, {_items(row.reaction)}),"
        yield "    },"


def codes(description: Description) -> str:
    """Return codes.py."""
    services = description.services
    names: dict[bool, list[Code]] = {True: [], False: []}  # of single services, of ranges
    for code in description.tables["services"].codes:
        names[code.first == code.last].append(code)
    lines = [HEAD, "", "# Services with a name of their own.", "SERVICES = {"]
    lines += [*(f'    0x{code.first:02X}: "{code.text}",' for code in names[True]), "}", ""]
    lines += ["# First and last service of a range, and its name, for services without a name of their own."]
    lines += ["RANGES = (", *(f'    (0x{code.first:02X}, 0x{code.last:02X}, "{code.text}"),' for code in names[False])]
    lines += [")", "", "# Services whose reactions begin with a status byte (chapter 2.1)."]
    lines += [f"WITH_STATUS = {_ranges(services.with_status)}", ""]
    lines += ["# General services with a parameter control byte and a device address first (fig. 8-1)."]
    lines += [f"WITH_CONTROL = frozenset([{_numbers(services.with_control)}])", ""]
    lines += ["# Services of product groups that have the layout of a general one (chapter 8)."]
    lines += ["LIKE: Mapping[int, int] = {"]
    lines += [*(f"    0x{service:02X}: 0x{general:02X}," for service, general in services.like.items()), "}", ""]
    lines += ["# The same, but only if a preference of the dissector is set."]
    lines += ["LIKE_IF_SET: Mapping[str, Mapping[int, int]] = {"]
    lines += [f'    "{preference}": {_pairs(likes)},' for preference, likes in services.like_if_set.items()]
    lines += ["}", "", "# By service and subservice (chapters 3, 5 and 6)."]
    lines += ["LAYOUTS: Mapping[int, Mapping[int, Layout]] = {", *_layouts(services.layouts.values()), "}", ""]
    whole = [one.number for one in services.layouts.values() if not one.subservices]
    lines += ["# Those without subservices: their one layout is that of all useful data."]
    lines += [f"WITHOUT_SUBSERVICES: Collection[int] = frozenset([{_numbers(whole)}])"]
    return "\n".join([*lines, ""])


NAMES = '''# SPDX-License-Identifier: GPL-2.0-or-later
"""Names of S parameters by number, as Wireshark's dissector for SERCOS III has them.

Made by plugin/protocol/generate.py from names.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Mapping

S_NAMES: Mapping[int, str] = {'''


def names(description: Description) -> str:
    """Return names.py."""
    rows = (f"    {number}: {_string(name)}," for number, name in description.s_names.items())
    return "\n".join([NAMES, *rows, "}", ""])


FAULTS = '''# SPDX-License-Identifier: GPL-2.0-or-later
"""What is wrong with a telegram or a record: as the colours and buttons of the profile.

Made by plugin/protocol/generate.py from faults.toml and experts.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Fault(NamedTuple):
    """A fault and its tests, of which one must hold: FIELD (it is there), FIELD == NUMBER, or FIELD > NUMBER."""

    name: str
    short: str  # in a few words
    title: str
    tests: Sequence[str]
    live: Sequence[str] = ()  # tests in their place while a capture runs: what later packets tell is not known then
    do: str = ""  # what to do about it

    @property
    def filter(self) -> str:
        """Return the display filter that finds it."""
        return " || ".join(self.tests)

    @property
    def live_tests(self) -> Sequence[str]:
        """Return its tests while a capture runs."""
        return self.live or self.tests


# In the order of the report; where several hold, the first names the packet.
FAULTS = ('''

OWN = {"again", "unexpected", "early", "warning_bit", "against"}  # kinds that an expert item alone tells


def _tuple(texts: Sequence[str]) -> str:
    return f"({', '.join(map(_string, texts))}{',' if len(texts) == 1 else ''})"


def _string(text: str) -> str:
    return '"' + text.replace('"', '\\"') + '"'


def _folded(text: str, end: str = ",") -> Iterator[str]:
    """Return a string as lines of source."""
    *parts, last = textwrap.wrap(text, FOLD, drop_whitespace=False)
    yield from map(_string, parts)
    yield _string(last) + end


def faults(description: Description) -> str:
    """Return faults.py."""
    lines = [FAULTS]
    for fault in description.faults:
        lines += ["    Fault(", *(f"        {_string(text)}," for text in (fault.name, fault.short, fault.title))]
        lines.append(f"        {_tuple(fault.tests)},")
        lines += [f"        {_tuple(fault.live)},"] if fault.live else []
        first, *rest = _folded(fault.expert.do)
        lines += [f"        do={first}", *(f"        {part}" for part in rest), "    ),"]
    writes = [f"sis.service == 0x{service:02x}" for service in description.with_layout_of([0x1E, 0x1F])]
    lines += [")", "", "# What to do where a verdict is unresolved."]
    advice = description.expert("sis.tza.unresolved").do
    lines += ["UNRESOLVED = (", *(f"    {part}" for part in _folded(advice, "")), ")"]
    lines += ["", "# No fault, but found in the same way.", "WRITE = Fault("]
    lines += [
        '    "write",',
        '    "written",',
        '    "Parameter written",',
        "    (",
        *(f"        {_string(one)}," for one in writes),
        "    ),",
    ]
    lines += [
        ")",
        "",
        "# Expert items that tell an episode by themselves, and its kind.",
        "SIGNS: Mapping[str, str] = {",
    ]
    signs = [one for one in description.experts if one.episode in OWN]
    lines += [*(f'    "{one.filter}": "{one.episode}",' for one in signs), "}"]
    return "\n".join([*lines, ""])


STANDARD = '''# SPDX-License-Identifier: GPL-2.0-or-later
"""What SERCOS fixes about standard parameters: only forms and bits, never a scale.

Made by plugin/protocol/generate.py from standard.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
'''


def standard(description: Description) -> str:
    """Return standard.py."""
    said = description.standard
    lines = [STANDARD, "# What the values of a parameter are.", "FORMS: Mapping[str, str] = {"]
    lines += [f'    "{ident}": "{form}",' for form, idents in said["forms"].items() for ident in idents]
    lines += ["}", "", "# Measured values, and the commands that they follow.", "FOLLOWS: Mapping[str, str] = {"]
    lines += [*(f'    "{one}": "{other}",' for one, other in said["follows"].items()), "}", ""]
    lines += ["# Limits of a drive.", "LIMITS: Collection[str] = frozenset(", "    ("]
    return "\n".join([*lines, *(f'        "{ident}",' for ident in said["limits"]["idents"]), "    )", ")", ""])
