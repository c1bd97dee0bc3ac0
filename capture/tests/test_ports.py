# SPDX-License-Identifier: GPL-2.0-or-later
"""What is behind a port, read from a sysfs that the test builds, and the table of ports.

The ports are in a folder that no computer has: what is plugged into this one must not matter.
"""

import argparse
import json
import os
import pty
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from sistap import cli
from sistap.tap import ports as command
from sistap.tap.analyser import probe
from sistap.tap.line import drivers, ports
from sistap.tap.line.drivers import ErrorPlace


def put(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text + "\n")


def link(place: Path, target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.symlink_to(target)


@pytest.fixture
def sysfs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An FTDI adapter as ttyUSB0, a CDC ACM one as ttyACM0, a UART as ttyS0, no hardware as ttyS1 (Linux 6.5 on)."""
    monkeypatch.setattr(probe, "plugged_in", list)
    usb = tmp_path / "devices/usb1/1-1"
    put(usb / "product", "FT232R USB UART")
    link(usb / "1-1:1.0/ttyUSB0/driver", tmp_path / "bus/usb-serial/drivers/ftdi_sio")
    link(usb / "1-1:1.0/driver", tmp_path / "bus/usb/drivers/ftdi_sio_interface")
    link(tmp_path / "class/tty/ttyUSB0/device", usb / "1-1:1.0/ttyUSB0")
    put(usb / "1-1:1.0/ttyUSB0/latency_timer", "16")
    link(tmp_path / "bus/usb-serial/devices/ttyUSB0", usb / "1-1:1.0/ttyUSB0")

    acm = tmp_path / "devices/usb1/1-2"
    put(acm / "product", "USB-RS485 Cable")
    link(acm / "1-2:1.0/driver", tmp_path / "bus/usb/drivers/cdc_acm")
    link(tmp_path / "class/tty/ttyACM0/device", acm / "1-2:1.0")

    pnp = tmp_path / "devices/pnp0/00:01"
    link(pnp / "driver", tmp_path / "bus/pnp/drivers/serial")
    link(pnp / "00:01:0/driver", tmp_path / "bus/serial-base/drivers/ctrl")
    link(pnp / "00:01:0/00:01:0.0/driver", tmp_path / "bus/serial-base/drivers/port")
    link(tmp_path / "class/tty/ttyS0/device", pnp / "00:01:0/00:01:0.0")
    put(tmp_path / "class/tty/ttyS0/type", "4")
    put(tmp_path / "class/tty/ttyS0/rx_trig_bytes", "8")

    put(tmp_path / "class/tty/ttyS1/type", "0")
    return tmp_path


def test_adapters(sysfs: Path) -> None:
    ftdi = ports.adapter("/nowhere/ttyUSB0", sysfs)
    assert ftdi == ports.Adapter("FT232R USB UART", "ftdi_sio", latency_ms=16)
    assert str(ftdi) == "FT232R USB UART (ftdi_sio, latency timer 16 ms)"
    assert str(ports.adapter("/nowhere/ttyACM0", sysfs)) == "USB-RS485 Cable (cdc_acm)"
    uart = ports.adapter("/nowhere/ttyS0", sysfs)
    assert uart == ports.Adapter("16550A UART", "serial", fifo_trigger=8, is_uart=True)
    assert str(uart) == "16550A UART (serial, FIFO trigger 8)"
    assert str(ports.adapter("/nowhere/ttyNONE0", sysfs)) == "unknown adapter"


def test_what_a_driver_says_about_line_errors(sysfs: Path) -> None:
    link(sysfs / "class/tty/ttyUSB1/device", sysfs / "devices/usb1/1-3/1-3:1.0/ttyUSB1")
    link(sysfs / "devices/usb1/1-3/1-3:1.0/ttyUSB1/driver", sysfs / "bus/usb-serial/drivers/ch341-uart")
    told = {
        name: ports.adapter(f"/nowhere/{name}", sysfs).tells.place
        for name in ("ttyUSB0", "ttyUSB1", "ttyACM0", "ttyS0")
    }
    assert list(told.values()) == [ErrorPlace.PACKET, ErrorPlace.NOWHERE, ErrorPlace.READ, ErrorPlace.CHARACTER]
    assert ports.adapter("/nowhere/ttyNONE0", sysfs).tells is drivers.UNKNOWN


def test_adapter_behind_a_link(sysfs: Path, tmp_path: Path) -> None:
    by_id = tmp_path / "usb-FTDI-if00"
    by_id.symlink_to("/nowhere/ttyUSB0")
    assert ports.adapter(str(by_id), sysfs).driver == "ftdi_sio"


def test_identity(sysfs: Path, tmp_path: Path) -> None:
    put(tmp_path / "devices/usb1/serial", "0000:00:14.0")  # of the host controller, not of what is plugged in
    without_serial = ports.adapter("/nowhere/ttyUSB0", sysfs)
    assert ports.identity("/nowhere/ttyUSB0", without_serial) == "FT232R USB UART at /nowhere/ttyUSB0"
    put(tmp_path / "devices/usb1/1-1/serial", "A50285BI")
    by_id = tmp_path / "usb-FTDI-if00"
    by_id.symlink_to("/nowhere/ttyUSB0")
    for port in ("/nowhere/ttyUSB0", str(by_id)):
        assert ports.identity(port, ports.adapter(port, sysfs)) == "FT232R USB UART A50285BI"
    assert ports.identity("/nowhere/ttyS0", ports.adapter("/nowhere/ttyS0", sysfs)) == "16550A UART at /nowhere/ttyS0"
    assert ports.identity("/nowhere/ttyNONE0", ports.Adapter()) == "unknown adapter at /nowhere/ttyNONE0"


def test_pseudo_terminal(sysfs: Path, tmp_path: Path) -> None:
    master, slave = pty.openpty()
    by_name = tmp_path / "link-to-pty"
    by_name.symlink_to(os.ttyname(slave))
    for port in (os.ttyname(slave), str(by_name)):
        assert str(ports.adapter(port, sysfs)) == "pseudo terminal"
        assert ports.adapter(port, sysfs).pseudo_terminal
    os.close(master)
    os.close(slave)


def show(monkeypatch: pytest.MonkeyPatch, sysfs: Path, names: list[str]) -> int:
    monkeypatch.setattr(list_ports, "comports", lambda: [ListPortInfo(f"/nowhere/{name}") for name in names])
    monkeypatch.setattr(ports.found, "__defaults__", (sysfs,))
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return command.run(parser.parse_args([]))


def test_table(monkeypatch: pytest.MonkeyPatch, sysfs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert show(monkeypatch, sysfs, ["ttyUSB0", "ttyS1", "ttyS0", "ttyACM0"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "port              adapter          driver    latency              line errors",
        "/nowhere/ttyACM0  USB-RS485 Cable  cdc_acm   -                    somewhere in a read",
        "/nowhere/ttyS0    16550A UART      serial    FIFO trigger 8       at the character",
        "/nowhere/ttyUSB0  FT232R USB UART  ftdi_sio  latency timer 16 ms  somewhere in a USB packet",
    ]


def test_no_ports(monkeypatch: pytest.MonkeyPatch, sysfs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert show(monkeypatch, sysfs, ["ttyS1"]) == 0
    out = capsys.readouterr().out
    assert len(out.splitlines()) == 1
    assert out.startswith("no serial port found: ")


@pytest.mark.parametrize(("described", "name"), [("USB Serial Port (COM3)", "USB Serial Port (COM3)"), ("n/a", "")])
def test_where_there_is_no_sysfs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, described: str, name: str) -> None:
    info = SimpleNamespace(device="COM3", description=described)
    monkeypatch.setattr(list_ports, "comports", lambda: [info])
    assert ports.found(tmp_path) == [("COM3", ports.Adapter(name))]


def test_analysers_are_listed(
    monkeypatch: pytest.MonkeyPatch, sysfs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(probe, "plugged_in", lambda: [probe.Analyser("Logic", "1.2", tmp_path)])
    assert show(monkeypatch, sysfs, []) == 0
    assert capsys.readouterr().out.splitlines() == [
        "port                           adapter  driver   latency          line errors",
        "sigrok:fx2lafw:conn=1.2?rx=D0  Logic    fx2lafw  samples the bus  at the character",
    ]


def test_ports_for_programs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    adapter = ports.Adapter("FT232R USB UART", "ftdi_sio", latency_ms=16, serial="A1")
    monkeypatch.setattr(ports, "found", lambda: [("/dev/ttyUSB0", adapter), ("/dev/ttyS0", ports.Adapter())])
    monkeypatch.setattr(probe, "plugged_in", list)
    assert cli.main(["ports", "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)
    assert first == {
        "port": "/dev/ttyUSB0",
        "adapter": "FT232R USB UART",
        "driver": "ftdi_sio",
        "latency_timer_ms": 16,
        "fifo_trigger": None,
        "serial": "A1",
        "line_errors": "somewhere in a USB packet",
    }
    assert second["port"] == "/dev/ttyS0"
    assert second["adapter"] is second["line_errors"] is None


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("ttyUSB0", "{}/ttyUSB0"),
        ("/dev/ttyUSB0", "/dev/ttyUSB0"),
        ("ttyUSB9", "ttyUSB9"),
        ("socket://ttyUSB0", "socket://ttyUSB0"),
        ("", ""),
    ],
)
def test_a_port_without_its_folder(given: str, meant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ttyUSB0").touch()
    monkeypatch.setattr(ports, "DEVICES", tmp_path)
    assert ports.short(given) == meant.format(tmp_path)


@pytest.mark.parametrize(
    ("found", "words"),
    [
        ([], "no serial port found: plug the adapter in, or name a PORT with -i"),
        (["/dev/ttyUSB0", "/dev/ttyUSB1"], "there are 2 ports: name one with -i (/dev/ttyUSB0, /dev/ttyUSB1)"),
    ],
)
def test_a_capture_without_a_port(
    found: list[str], words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(ports, "found", lambda: [(port, ports.Adapter()) for port in found])
    assert cli.main(["capture"]) == 2
    assert words in capfd.readouterr().err


def test_a_capture_of_the_only_port(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """It is the one that cannot be opened here."""
    monkeypatch.setattr(ports, "found", lambda: [(str(tmp_path / "gone"), ports.Adapter())])
    assert cli.main(["capture"]) == 3
    assert f"{tmp_path}/gone" in capfd.readouterr().err


def test_a_command_that_is_misspelt(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["captrue"]) == 2
    assert capfd.readouterr().err == "sistap: there is no command 'captrue': did you mean `sistap capture`?\n"


def test_without_a_command_it_shows_all(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 2
    shown = capfd.readouterr()
    assert shown.out == ""
    assert all(re.search(rf"^    {name}\b", shown.err, re.MULTILINE) for name in cli.COMMANDS)


@pytest.mark.parametrize("rate", ["9600", "auto"])
def test_a_rate_given_with_b(capfd: pytest.CaptureFixture[str], rate: str) -> None:
    """`-b` begins files, as dumpcap's; who comes from other programs means the baud rate."""
    with pytest.raises(SystemExit):
        cli.main(["capture", "-b", rate])
    assert f"write --baud {rate}" in capfd.readouterr().err
