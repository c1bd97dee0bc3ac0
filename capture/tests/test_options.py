# SPDX-License-Identifier: GPL-2.0-or-later
"""The options of a capture from any front end: their meaning, and contradictions."""

from __future__ import annotations

import argparse
from dataclasses import FrozenInstanceError, replace

import pytest

from sistap.tap.capture import command
from sistap.tap.capture.options import CaptureOptions, checked, rate
from sistap.tap.files.output import FileLimits
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.cut import PROCEDURE_3964R, Cut
from sistap.tap.terminal.exits import Refusal

pytestmark = pytest.mark.tap

PORT = "/dev/ttyTEST"
PLAIN = CaptureOptions(ports=(PORT,))


def test_nobody_changes_options_afterwards() -> None:
    with pytest.raises(FrozenInstanceError):
        PLAIN.baud = 19200  # type: ignore[misc]


def test_defaults_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    told = vars(parser.parse_args(["-i", PORT]))
    for name, value in vars(replace(PLAIN, ports=[PORT], autostop=[], ring=[])).items():  # type: ignore[arg-type]
        assert told[name] == value, name


def test_lines_are_numbered_by_how_many_ports_there_are() -> None:
    assert PLAIN.lines == (0,)
    assert replace(PLAIN, ports=(PORT, "/dev/ttyOTHER")).lines == (1, 2)


def test_formats_are_looked_for_only_with_the_rate() -> None:
    assert PLAIN.formats == ()
    assert replace(PLAIN, baud=None).formats == ("8E1", "8N1")
    assert replace(PLAIN, baud=None, format="8O1").formats == ("8O1",)


def test_limits() -> None:
    ring = replace(PLAIN, file="x", ring={"filesize": 3.0, "files": 2.0}, autostop={"files": 5.0})
    assert ring.limits == FileLimits(size=3000, duration_s=None, several=True, keep=2, files=5)
    with pytest.raises(Refusal, match="need a file: say it with -w"):
        replace(ring, file=None).limits  # noqa: B018 - it checks


def test_what_they_come_to() -> None:
    assert checked(PLAIN) == (LineSettings(9600), None)
    with pytest.raises(Refusal, match="--baud auto needs SIS telegrams"):
        checked(replace(PLAIN, baud=None, framing=Cut.parse("silence:5")))


@pytest.mark.parametrize("link_type", ["upper-pdu", "rtac"])
def test_link_types_of_3964r(link_type: str) -> None:
    checked(replace(PLAIN, file="x", framing=PROCEDURE_3964R, link_type=link_type))


def test_what_does_not_go_with_3964r() -> None:
    with pytest.raises(Refusal, match="--link-type user3 is for SIS telegrams.*: use upper-pdu or rtac"):
        checked(replace(PLAIN, file="x", framing=PROCEDURE_3964R, link_type="user3"))
    with pytest.raises(Refusal, match="--baud auto needs SIS telegrams: leave out --framing"):
        checked(replace(PLAIN, baud=None, framing=PROCEDURE_3964R))
    with pytest.raises(Refusal, match="--follow-baud needs SIS telegrams: leave out --framing"):
        checked(replace(PLAIN, follow_baud=True, framing=PROCEDURE_3964R))


@pytest.mark.parametrize(
    "ports",
    [
        ("bus://pi:5000", PORT),
        (PORT, "bus://pi:5000"),
        ("bus://pi:5000", "bus://127.0.0.1:5000"),
    ],
)
def test_times_of_two_clocks_are_not_mixed(ports: tuple[str, str]) -> None:
    with pytest.raises(Refusal, match="have two clocks, and their times cannot be compared: tap both at one computer"):
        checked(replace(PLAIN, ports=ports))


@pytest.mark.parametrize("ports", [("bus://pi:5000", "bus://PI:5001"), ("bus:///run/one", PORT), ("/dev/a", "/dev/b")])
def test_two_ports_of_one_computer(ports: tuple[str, str]) -> None:
    checked(replace(PLAIN, ports=ports))


@pytest.mark.parametrize(("text", "baud"), [("auto", None), ("19200", 19200), ("4294967295", 4294967295)])
def test_a_rate(text: str, baud: int | None) -> None:
    assert rate(text) == baud


@pytest.mark.parametrize("text", ["", "0", "-9600", "4294967296", "fast"])
def test_what_is_no_rate(text: str) -> None:
    with pytest.raises(ValueError, match=f"'{text}' is neither auto nor a rate"):
        rate(text)
