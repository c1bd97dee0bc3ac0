# SPDX-License-Identifier: GPL-2.0-or-later
"""Filters are libpcap's own, on the plain telegram."""

from __future__ import annotations

import ctypes.util
import re

import pytest
from portable import libpcap
from specification import TELEGRAMS

from sistap.tap.capture import filter as bpf
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.exits import Refusal

pytestmark = pytest.mark.tap


def passing(text: str) -> set[str]:
    only = bpf.Filter(text)
    return {figure for figure, telegram in TELEGRAMS.items() if only.matches(telegram)}


@libpcap
def test_the_fifth_byte_is_the_service() -> None:
    assert passing("link[5] == 0x04") == {"7-1", "7-2"}
    assert passing("link[5] == 0x92 or link[5] == 0x9d") == {"8-20", "8-21", "8-23", "8-24", "8-25"}
    assert passing("link[7] == 255") == {"6-24"}  # broadcast
    assert passing("link[4] & 0x10 != 0") == {"2-13", "2-14", "2-15", "7-2", "8-21", "8-24"}  # reactions


@libpcap
def test_a_telegram_shorter_than_the_filter_asks_for_does_not_pass() -> None:
    assert passing("link[40] == 0x04") == set()
    assert passing("len > 40") == {"7-2"}


@libpcap
def test_a_wrong_filter_is_told_in_the_words_of_libpcap() -> None:
    with pytest.raises(Refusal, match=r"'link\[5': can't parse filter expression: syntax error"):
        bpf.Filter("link[5")
    with pytest.raises(Refusal):
        bpf.Filter("link[5] == ä")


def test_without_libpcap_it_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.setattr(ctypes, "CDLL", missing)
    with pytest.raises(Refusal, match=re.escape(advice().libpcap)):
        bpf.Filter("link[5] == 0x10")
