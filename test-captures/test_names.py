# SPDX-License-Identifier: GPL-2.0-or-later
"""The names in Python are those of plugin/sis/names.c, the one source."""

from __future__ import annotations

import re
from pathlib import Path

from sistap.sis import names

SOURCE = Path(__file__).parent.parent / "plugin" / "sis" / "names.c"


def table(name: str) -> list[tuple[int, int, str]]:
    """Read a range_string table: first, last, text."""
    body = re.search(rf"{name}\[\] = \{{\n(.*?)\n\}};", SOURCE.read_text(), re.DOTALL)
    assert body, name
    rows = re.findall(r'\{(\w+), (\w+), "([^"]*)"\}', body.group(1))
    return [(int(first, 0), int(last, 0), text) for first, last, text in rows]


def test_services() -> None:
    rows = table("sis_services")
    assert dict(names.SERVICES) == {first: text for first, last, text in rows if first == last}
    assert list(names.RANGES) == [row for row in rows if row[0] != row[1]]


def test_single_services_come_first() -> None:
    """The first entry that fits gives a service its name."""
    singles = [first == last for first, last, _ in table("sis_services")]
    assert singles == sorted(singles, reverse=True)


def test_every_code_has_a_text() -> None:
    """No code of a byte may be shown as unknown if a document names its range."""
    for name in ("sis_services", "sis_status"):
        covered = {code for first, last, _ in table(name) for code in range(first, last + 1)}
        assert covered == set(range(256)), name
