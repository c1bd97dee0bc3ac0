# SPDX-License-Identifier: GPL-2.0-or-later
"""Of numbers, sis.lua says what the C plugin says, in every locale."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import locales
from make import HERE
from sistap.dissected.wireshark.tshark import Tshark

FIRST, *REST = ("timing-reads", "phases", "timing-pauses", "timing-cycle", "values", "records")


@pytest.fixture(scope="module")
def german() -> Iterator[dict[str, str]]:
    with locales.german() as environment:
        yield environment


@pytest.mark.parametrize("name", [FIRST, *(pytest.param(name, marks=pytest.mark.thorough) for name in REST)])
def test_locale(name: str, german: dict[str, str], plugin: Tshark, script: Tshark) -> None:
    """test_numbers.py shows that tshark speaks German then, and that the plugin's numbers do not."""
    arguments = ("-r", str(HERE / f"{name}.pcapng"), "-P", "-V", "-O", "sertap,sis", "-o", "sis.tza_ms:5")
    assert locales.said(script, german, *arguments) == locales.said(plugin, {}, *arguments)
