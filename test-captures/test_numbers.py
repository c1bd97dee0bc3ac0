# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers as text: rounded, and with a decimal point in every locale. People compare them and filter for them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import locales
from make import HERE, START_NS
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Record, Type

# Seconds, milliseconds, percent, scaled values, intervals of characters.
FIRST, *REST = ("timing-reads", "values", "phases", "timing-pauses", "timing-cycle", "records")


@pytest.fixture(scope="module")
def german() -> Iterator[dict[str, str]]:
    with locales.german() as environment:
        yield environment


@pytest.mark.thorough
def test_tshark_speaks_german(german: dict[str, str], tshark: Tshark) -> None:
    """Otherwise the other tests here would prove nothing. Rates and percents of a statistics tree are Wireshark's
    own.
    """
    arguments = ("-r", str(HERE / "statistics.pcapng"), "-q", "-z", "sis,tree")
    assert re.search(r"\d,\d\d%", locales.said(tshark, german, *arguments))


@pytest.mark.parametrize("name", [FIRST, *(pytest.param(name, marks=pytest.mark.thorough) for name in REST)])
def test_trees(name: str, german: dict[str, str], tshark: Tshark) -> None:
    arguments = ("-r", str(HERE / f"{name}.pcapng"), "-P", "-V", "-O", "sertap,sis", "-o", "sis.tza_ms:5")
    text = locales.said(tshark, german, *arguments)
    assert re.search(r"\d\.\d", text)
    assert text == locales.said(tshark, {}, *arguments)


# Intervals in ns and their texts: half a microsecond goes up.
ROUNDED = {
    1_145_833: "1.146 ms",
    1_145_499: "1.145 ms",
    1_145_500: "1.146 ms",
    999_999_499: "999.999 ms",
    999_999_500: "1000.000 ms",
    4_500: "0.005 ms",
    500: "0.001 ms",
    499: "0.000 ms",
    0: "0.000 ms",
    4_294_967_295: "4294.967 ms",
}


def test_milliseconds_are_rounded(tshark: Tshark, tmp_path: Path) -> None:
    intervals = list(ROUNDED)
    data, flags = bytes(len(intervals)), bytes(len(intervals))
    made = Record(0, Type.OTHER, 0, LineSettings(115_200), data, intervals, flags, 310_500)  # none is its usual one
    capture = tmp_path / "rounded.pcapng"
    capture.write_bytes(
        pcapng.section_header("", "")
        + pcapng.interface_description(pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "rounded"))
        + pcapng.enhanced_packet(0, START_NS, pcapng.upper_pdu("sertap", made.pack()))
    )
    text = tshark.output("-r", str(capture), "-V", "-O", "sertap")
    assert re.findall(r"Character \d+: 0x00, after (.*)", text) == list(ROUNDED.values())
    assert "Uncertainty of the times: 0.311 ms" in text
