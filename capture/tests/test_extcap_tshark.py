# SPDX-License-Identifier: GPL-2.0-or-later
"""The extcap as a real tshark finds and runs it; not as root, because Wireshark then skips such programs."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import sisbus
import sistap
from sistap.commands.install.shell import launcher
from sistap.dissected.wireshark.tshark import Tshark

NOT_LONGER = ["-a", "duration:60"]


def is_open_to_others(program: str | None) -> bool:
    return program is not None and bool(Path(program).stat().st_mode & 0o001)


pytestmark = pytest.mark.skipif(
    os.geteuid() == 0 and not is_open_to_others(shutil.which("dumpcap")), reason="dumpcap is not for everybody here"
)


@pytest.fixture(scope="module")
def tshark() -> Iterator[Tshark]:
    """Yield a tshark whose only extcap is sistap, installed where every user may read it."""
    folder = Path(tempfile.mkdtemp(prefix="sistap-extcap-"))
    folder.chmod(0o755)
    for package in (sistap, sisbus):
        shutil.copytree(package.__path__[0], folder / "package" / package.__name__)
    extcap = folder / "extcap"
    extcap.mkdir()
    file = extcap / "sistap"
    file.write_text(launcher(os.path.realpath(sys.executable), folder / "package", windows=False))
    file.chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WIRESHARK_EXTCAP_DIR", str(extcap))
        with Tshark() as program:
            yield program
    shutil.rmtree(folder)


@pytest.mark.thorough
def test_the_demo_bus_is_listed(tshark: Tshark) -> None:
    assert any("sistap-demo (SIS demo bus" in line for line in tshark.output("-D").splitlines())


def test_the_demo_bus_is_captured(tshark: Tshark) -> None:
    fields = ["-T", "fields", "-e", "sertap.event", "-e", "sertap.type", "-e", "sertap.baud"]
    done = tshark.run(["-i", "sistap-demo", "-c", "8", *NOT_LONGER, *fields])
    assert done.returncode == 0
    # The event that starts it, the text that a drive says at power-on, then telegrams.
    assert done.stdout.splitlines() == ["1\t2\t9600", "\t1\t9600", *6 * ["\t0\t9600"]]
    assert "extcap" not in done.stderr


@pytest.mark.thorough
def test_a_capture_filter_sees_telegrams(tshark: Tshark) -> None:
    capture = ["-i", "sistap-demo", "-f", "link[7] == 4", "-c", "8", *NOT_LONGER, "-T", "fields", "-e", "sis.receiver"]
    assert [line for line in tshark.run(capture).stdout.splitlines() if line] == 6 * ["4"]


@pytest.mark.thorough
def test_options_come_from_the_preferences(tshark: Tshark) -> None:
    capture = ["-i", "sistap-demo", "-c", "1", *NOT_LONGER, "-T", "fields", "-e", "sertap.baud"]
    rate = ["-o", "extcap.sistap_demo.baud:19200"]
    assert tshark.run([*rate, *capture]).stdout.splitlines() == ["19200"]
    # A rate of one's own goes before the one that was chosen.
    other = ["-o", "extcap.sistap_demo.otherbaud:1200"]
    assert tshark.run([*rate, *other, *capture]).stdout.splitlines() == ["1200"]


@pytest.mark.thorough
def test_an_error_arrives_in_words_and_alone(tshark: Tshark) -> None:
    done = tshark.run(["-i", "sistap-demo", "-f", "link[5] =", *NOT_LONGER])
    (said,) = (line for line in done.stderr.splitlines() if line.startswith("tshark:"))
    assert "sistap: filter 'link[5] ='" in said
