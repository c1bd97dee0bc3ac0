# SPDX-License-Identifier: GPL-2.0-or-later
"""Wireshark's questions to an extcap before a capture, and the launcher that it uses."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from portable import WINDOWS, libpcap, posix

from sistap import cli
from sistap.commands.extcap import command, interfaces, started
from sistap.commands.install.shell import launcher
from sistap.tap.analyser import probe
from sistap.tap.line import ports
from sistap.tap.line.ports import Adapter

CAPTURE = Path(__file__).parents[1]

# Those that Wireshark 4.0 knows; an unknown one makes it drop the field.
TYPES = set("integer unsigned long double string password boolean boolflag fileselect selector radio".split()) | {
    "multicheck",
    "timestamp",
}
RATES = ["9600", "19200", "38400", "57600", "115200"]  # IF02 fig. 6-11

Sentence = tuple[str, dict[str, str]]


def parsed(text: str) -> list[Sentence]:
    """Parse sentences as Wireshark does: a value ends at a brace before another, a space or the end."""
    sentences = []
    for line in text.splitlines():
        kind, _, rest = line.partition(" ")
        sentences.append((kind, dict(re.findall(r"\{([a-zA-Z_-]*?)=(.*?)\}(?=\{|$|\s)", rest))))
    return sentences


@pytest.fixture(autouse=True)
def _without_analyser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(probe, "program", lambda: None)


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Plug two adapters in, one with a name of its own; return the folder of names."""
    monkeypatch.setattr(interfaces, "BY_ID", tmp_path)
    if not WINDOWS:
        (tmp_path / "usb-FTDI_FT232R_A1-if00-port0").symlink_to("/nowhere/ttyUSB0")
    found = [("/nowhere/ttyS0", Adapter("16550A UART")), ("/nowhere/ttyUSB0", Adapter("FT{232}R"))]
    monkeypatch.setattr(ports, "found", lambda: found)
    return tmp_path


def asked(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[Sentence]:
    assert cli.main(["extcap", *arguments]) == 0
    return parsed(capsys.readouterr().out)


def of_kind(kind: str, sentences: list[Sentence]) -> list[dict[str, str]]:
    return [values for which, values in sentences if which == kind]


def fields(capsys: pytest.CaptureFixture[str], interface: str) -> dict[str, dict[str, str]]:
    sentences = asked(capsys, "--extcap-config", "--extcap-interface", interface)
    return {field["call"]: field for field in of_kind("arg", sentences)}


def choices(sentences: list[Sentence], number: str) -> list[str]:
    return [values["value"] for values in of_kind("value", sentences) if values.get("arg") == number]


@posix("no names by /dev/serial/by-id")
@pytest.mark.usefixtures("plugged")
def test_ports_and_the_demo_bus_are_interfaces(capsys: pytest.CaptureFixture[str]) -> None:
    sentences = asked(capsys, "--extcap-interfaces", "--extcap-version=4.0")
    assert of_kind("interface", sentences) == [
        {"value": "sistap-ttyS0", "display": "SIS tap: ttyS0 (16550A UART)"},
        # Braces would end the value.
        {"value": "sistap-usb-FTDI_FT232R_A1-if00-port0", "display": "SIS tap: ttyUSB0 (FT(232)R)"},
        {"value": "sistap-demo", "display": "SIS demo bus"},
    ]
    assert [set(values) for values in of_kind("extcap", sentences)] == [{"version", "display"}]


@posix("no names by /dev/serial/by-id")
def test_an_adapter_keeps_its_name_where_it_is_plugged_in_again(plugged: Path) -> None:
    name = interfaces.found()[1].name
    assert interfaces.port_of(name) == "/nowhere/ttyUSB0"
    link = plugged / name.removeprefix("sistap-")
    link.unlink()
    link.symlink_to("/nowhere/ttyUSB7")
    assert interfaces.port_of(name) == "/nowhere/ttyUSB7"
    assert interfaces.port_of("sistap-ttyS0") == "/dev/ttyS0"


def test_without_pyserial_the_demo_bus_says_why_it_is_alone(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "serial.tools", None)
    (only,) = of_kind("interface", asked(capsys, "--extcap-interfaces"))
    assert only["value"] == "sistap-demo"
    assert f"pyserial is missing for {sys.executable}" in only["display"]


def test_every_interface_has_one_link_type(capsys: pytest.CaptureFixture[str]) -> None:
    (link_type,) = asked(capsys, "--extcap-dlts", "--extcap-interface", "sistap-demo")
    assert link_type[0] == "dlt"
    assert link_type[1]["number"] == "252"  # LINKTYPE_WIRESHARK_UPPER_PDU
    assert set(link_type[1]) == {"number", "name", "display"}  # with one missing Wireshark drops the interface


@pytest.mark.usefixtures("plugged")
def test_the_toolbar_is_described_with_the_interfaces(capsys: pytest.CaptureFixture[str]) -> None:
    sentences = asked(capsys, "--extcap-interfaces")
    controls = {control["display"]: control for control in of_kind("control", sentences)}
    assert {name: control["type"] for name, control in controls.items()} == {
        "Rate": "selector",
        "Marker": "string",
        "Counters": "button",
        "Log": "button",
    }
    assert controls["Log"]["role"] == "logger"
    assert len({control["number"] for control in controls.values()}) == len(controls)
    values = [value["value"] for value in of_kind("value", sentences) if value["control"] == controls["Rate"]["number"]]
    assert values == [*RATES, "auto"]


@pytest.mark.usefixtures("plugged")
@pytest.mark.parametrize("interface", ["sistap-ttyS0", "sistap-demo"])
def test_the_dialog_is_one_that_wireshark_understands(capsys: pytest.CaptureFixture[str], interface: str) -> None:
    sentences = asked(capsys, "--extcap-config", "--extcap-interface", interface)
    numbers = [field["number"] for field in of_kind("arg", sentences)]
    assert len(set(numbers)) == len(numbers)
    for field in of_kind("arg", sentences):
        assert field["type"] in TYPES
        assert field["display"] and field["tooltip"] and field["group"]
        defaults = [
            value for value in of_kind("value", sentences) if value["arg"] == field["number"] and "default" in value
        ]
        assert len(defaults) == (field["type"] == "selector")


@pytest.mark.usefixtures("plugged")
def test_rate_and_format_are_chosen_from_what_sis_and_the_field_have(capsys: pytest.CaptureFixture[str]) -> None:
    sentences = asked(capsys, "--extcap-config", "--extcap-interface", "sistap-ttyS0")
    number = {field["call"]: field["number"] for field in of_kind("arg", sentences)}
    assert choices(sentences, number["--baud"]) == [*RATES, "auto"]
    assert choices(sentences, number["--format"]) == ["", "8E1", "8N1"]
    assert choices(sentences, number["--framing"]) == ["sis", "3964r", "ascii"]


@pytest.mark.usefixtures("plugged")
@pytest.mark.parametrize(
    ("interface", "call", "right", "wrong"),
    [
        ("sistap-ttyS0", "--other-baud", ["1200", "31250", "500000"], ["0", "-9600", "9600 Bd", "1e4"]),
        ("sistap-ttyS0", "--tza", ["5", "65535"], ["0", "5 ms", "0.5"]),
        ("sistap-demo", "--faults", ["checksum=0.02", "parity=0.5,break=1"], ["checksum", "checksum=0.02,", "pause=x"]),
    ],
)
def test_fields_are_checked_as_they_are_filled_in(
    capsys: pytest.CaptureFixture[str], interface: str, call: str, right: list[str], wrong: list[str]
) -> None:
    field = fields(capsys, interface)[call]
    assert all(re.search(field["validation"], text) for text in right)
    assert not any(re.search(field["validation"], text) for text in wrong)


@pytest.mark.usefixtures("plugged")
def test_ports_and_the_demo_bus_have_fields_of_their_own(capsys: pytest.CaptureFixture[str]) -> None:
    port, demo = set(fields(capsys, "sistap-ttyS0")), set(fields(capsys, "sistap-demo"))
    assert port - demo == {"--framing", "--second-port", "--uncertainty", "--tza", "--trs"}
    assert demo - port == {"--scenario", "--faults"}


@posix("no names by /dev/serial/by-id")
@pytest.mark.usefixtures("plugged")
@pytest.mark.parametrize("option", ["second-port", "--second-port"])
def test_ports_of_the_other_direction_are_listed_again(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    field = fields(capsys, "sistap-ttyS0")["--second-port"]
    assert field["reload"] == "true"
    new = [*ports.found(), ("/dev/ttyACM0", Adapter("CP2102"))]
    monkeypatch.setattr(ports, "found", lambda: new)
    reload = ["--extcap-config", "--extcap-interface", "sistap-ttyS0", f"--extcap-reload-option={option}"]
    sentences = asked(capsys, *reload)
    assert {kind for kind, _ in sentences} == {"value"}
    # None, and all but the port itself and the demo bus.
    assert choices(sentences, field["number"]) == ["", "sistap-usb-FTDI_FT232R_A1-if00-port0", "sistap-ttyACM0"]


@libpcap
def test_a_filter_is_checked_without_a_capture(capsys: pytest.CaptureFixture[str]) -> None:
    about = ["--extcap-interface", "sistap-demo", "--extcap-capture-filter"]
    assert cli.main(["extcap", *about, "link[5] == 0x1f"]) == 0
    assert capsys.readouterr().out == ""
    # Wireshark drops what a program says that ends with anything but 0.
    assert cli.main(["extcap", *about, "link[5] ="]) == 0
    assert re.fullmatch("filter 'link\\[5\\] =': .+\n", capsys.readouterr().out)


@pytest.mark.parametrize("arguments", [[], ["--capture", "--extcap-interface", "sistap-demo"], ["--capture"]])
def test_what_wireshark_would_not_ask_is_refused_in_one_line(
    capfd: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    assert cli.main(["extcap", *arguments]) == 2
    assert re.fullmatch("sistap: .+\n", capfd.readouterr().err)


@posix("its launcher is another one")
def test_the_launcher_needs_nothing_of_where_it_is_started(tmp_path: Path) -> None:
    package = tmp_path / "it's here"
    package.symlink_to(CAPTURE)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    for module in ("sistap", "argparse", "serial"):
        (elsewhere / f"{module}.py").write_text("raise SystemExit('taken from the current folder')")
    file = tmp_path / "sis tap"
    file.write_text(launcher(sys.executable, package, windows=False))
    file.chmod(0o755)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [file, "--extcap-interfaces"], cwd=elsewhere, env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "sistap-demo" in [values["value"] for values in of_kind("interface", parsed(done.stdout))]


def test_the_launcher_of_windows_is_a_batch_file() -> None:
    lines = launcher(r"C:\Program Files\Python\python.exe", Path("D:/100% SIS"), windows=True).split("\r\n")
    assert lines[0] == "@echo off"
    assert f'set "PYTHONPATH={Path("D:/100%% SIS")}"' in lines
    assert lines[-2:] == [r'"C:\Program Files\Python\python.exe" -P -X utf8 -m sistap extcap %*', ""]


def test_an_analyser_is_an_interface(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(probe, "program", lambda: "/usr/bin/sigrok-cli")
    found = probe.Analyser("Logic {8}", "1.2", Path("/dev/bus/usb/001/002"))
    monkeypatch.setattr(probe, "plugged_in", lambda: [found])
    listed = of_kind("interface", asked(capsys, "--extcap-interfaces"))
    assert {"value": "sistap-sigrok", "display": "SIS tap: logic analyser (Logic (8))"} in listed
    shown = fields(capsys, "sistap-sigrok")
    assert {"--driver", "--channel", "--second-channel", "--samplerate", "--invert", "--baud"} <= shown.keys()
    assert not {"--second-port", "--uncertainty", "--scenario"} & shown.keys()


def test_the_dialog_of_an_analyser_is_its_address() -> None:
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    chosen = ["--driver", "fx2lafw:conn=1.2", "--second-channel", "D1", "--samplerate", "8m", "--invert", "tx"]
    args = parser.parse_args(["--extcap-interface", "sistap-sigrok", "--fifo", "pipe", *chosen])
    (port,) = started._options(args).ports
    assert port == "sigrok:fx2lafw:conn=1.2?rx=D0&tx=D1&samplerate=8m&invert=tx"
    assert probe.Probe.parse(port).inverted == (False, True)
