# SPDX-License-Identifier: GPL-2.0-or-later
"""What is behind a port of Windows, read from a simulated registry."""

from __future__ import annotations

import sys
from collections.abc import Mapping

import pytest

from sistap.tap.line import ports

pytestmark = pytest.mark.tap

FTDI = r"SYSTEM\CurrentControlSet\Enum\FTDIBUS"


class Values:
    """A registry: values by key and name."""

    def __init__(self, adapters: Mapping[str, Mapping[str, object]]) -> None:
        self._values: dict[tuple[str, str], object] = {}
        for device, values in adapters.items():
            for name, value in values.items():
                of_port = name in ("PortName", "LatencyTimer")
                key = rf"{FTDI}\{device}\0000" + (r"\Device Parameters" if of_port else "")
                self._values[key, name] = value

    def keys(self, path: str) -> list[str]:
        below = {key.removeprefix(path + "\\").partition("\\")[0] for key, _ in self._values if key.startswith(path)}
        return sorted(below)

    def value(self, path: str, name: str) -> object:
        return self._values.get((path, name))


ADAPTERS = Values(
    {
        "VID_0403+PID_6001+FT0000001A": {"PortName": "COM15", "LatencyTimer": 1, "FriendlyName": "RS485 (COM15)"},
        "VID_0403+PID_6001+A50285BIA": {
            "PortName": "COM5",
            "LatencyTimer": 16,
            "FriendlyName": "USB Serial Port (COM5)",
            "Service": "FTSER2K",
        },
        "ODD": {"PortName": 7, "LatencyTimer": "16"},
        "VID_0403+PID_6015+X1A": {"PortName": "COM7"},
    }
)


@pytest.mark.parametrize("port", ["COM5", "com5", r"\\.\COM5"])
def test_an_ftdi_adapter(port: str) -> None:
    behind = ports.of_windows(port, ADAPTERS)
    assert behind == ports.Adapter("USB Serial Port (COM5)", "FTSER2K", latency_ms=16, serial="A50285BI")
    assert str(behind) == "USB Serial Port (COM5) (FTSER2K, latency timer 16 ms)"


def test_a_port_above_9() -> None:
    assert ports.of_windows("COM15", ADAPTERS).latency_ms == 1


def test_what_the_registry_does_not_say() -> None:
    assert ports.ftdi("COM7", ADAPTERS) == ports.Ftdi("", "", "X1", None)
    assert ports.of_windows("COM1", ADAPTERS) == ports.Adapter()
    assert ports.of_windows("COM5", Values({})) == ports.Adapter()


def test_a_system_without_a_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "winreg", None)
    assert ports.ftdi("COM5", None) is None
