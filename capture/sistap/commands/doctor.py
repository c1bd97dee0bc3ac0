# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap doctor`: checks whether a capture works here, is readable, and has exact times."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.wireshark import folders, profile
from sistap.dissected.wireshark.tshark import OLDEST_WIRESHARK, Tshark, TsharkError, loaded, version
from sistap.tap.analyser import probe
from sistap.tap.capture.filter import Filter
from sistap.tap.common.packages import missing
from sistap.tap.line import drivers, measurement, others, ports, priority
from sistap.tap.line.others import Others
from sistap.tap.line.reader import PortError, open_reader
from sistap.tap.line.settings import LineSettings, in_ms
from sistap.tap.terminal import programs
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import DONE, FAILED, PORT, Refusal
from sistap.tap.terminal.rights import as_typed
from sistap.tap.terminal.state import is_root

DESCRIPTION = """\
Check what a capture needs. Print one line for each point. With -i, check the port as well.
"""

EPILOG = """\
good  as it should be
poor  a capture works, but could be better; the line says how
bad   a capture does not work, or Wireshark cannot read it; the line says what to do

With -i, sistap opens the port for a moment, as a capture does. It writes nothing to the port and switches RTS and DTR
off. It restores the settings that it tuned. It names other programs that can read the port; root sees those of all
users.

examples:
  sistap doctor                                         this computer
  sistap doctor -i /dev/ttyUSB0                         this computer and one port
  sistap doctor -i 'sigrok:fx2lafw?rx=D0'               this computer and a logic analyser

exit status:
  0  a capture works and can be read
  1  something is missing
  2  wrong usage
  3  the port cannot be opened
"""

UNITS = (Path("/etc/systemd/system"), Path("/usr/local/lib/systemd/system"), Path("/lib/systemd/system"))
RECORDER = "sistap-recorder.service"

_AS_ROOT = "run as root, Wireshark skips personal plugins and WIRESHARK_PLUGIN_DIR: start it as an ordinary user"


class Point(NamedTuple):
    """One thing that was checked."""

    mark: str  # "good", "poor" or "bad"
    subject: str
    text: str  # what was found, and the cure if that is not good

    def __str__(self) -> str:
        return f"{self.mark:5} {self.subject:10} {visible(as_typed(self.text))}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "-i", dest="port", metavar="PORT", type=ports.short, help="check this port as well (written as for capture)"
    )


@priority.real_time()
def run(args: argparse.Namespace) -> int:
    """Print a line for each point; return the exit code."""
    code = DONE
    for look in _LOOKS:
        for point in look():
            print(point, flush=True)
            if point.mark == "bad":
                code = FAILED
    if args.port and (probe.is_analyser(args.port) or _has_pyserial()):
        for point in port_points(args.port):
            print(point, flush=True)
            if point.mark == "bad":
                code = PORT
    return code


def port_points(port: str) -> Iterator[Point]:
    """Open a port as a capture does and yield what that showed."""
    if ports.is_own_terminal(port):
        yield Point("bad", "port", f"{port} is the terminal that sistap itself reads or writes: choose another port")
        return
    if probe.is_analyser(port):
        yield from _before_samples(port)
    device = "://" not in port and not probe.is_analyser(port)
    shared = others.look(port)
    try:
        reader = open_reader(port, LineSettings())
    except PortError as error:
        yield from _up_to_the_trouble(port, str(error)) if device else [Point("bad", "port", str(error))]
        return
    reader.close()
    if device:
        for subject, text, _ in _hurdles()[:-1]:
            yield Point("good", subject, text)
        yield _opens(port, shared)
    yield Point("good", "adapter", reader.adapter)
    tells = ports.adapter(port).tells if device else drivers.UNKNOWN
    notes = [note for note in reader.notes if note not in (tells.warning(port), shared.warning(port))]
    yield Point("poor" if notes else "good", "times", reader.timing)
    for note in notes:
        yield Point("poor", "times", note)
    if tells.explanation:
        yield Point("good" if tells.breaks else "poor", "errors", tells.explanation)


# What can keep a device from being opened, in this order: subject, text when it is well, and the check. A port of
# Windows is not a file, so these checks do not apply there.
_HURDLES: tuple[tuple[str, str, Callable[[str], bool]], ...] = (
    ("port", "it exists", lambda port: Path(port).exists()),
    ("rights", "you may open it", lambda port: os.access(port, os.R_OK | os.W_OK)),
    ("opens", "", lambda port: False),
)


def _opens(port: str, shared: Others) -> Point:
    """Say who else has a port that could be opened."""
    if shared.known:
        return Point("bad", "opens", shared.warning(port))
    if shared.unknown:
        return Point("good", "opens", f"it opens; whether another program has it cannot be known: {shared.unknown}")
    return Point("good", "opens", "it opens, and no other program has it")


def _hurdles() -> Sequence[tuple[str, str, Callable[[str], bool]]]:
    return _HURDLES[-1:] if sys.platform == "win32" else _HURDLES


def _up_to_the_trouble(port: str, trouble: str) -> Iterator[Point]:
    for subject, text, is_well in _hurdles():
        if not is_well(port):
            yield Point("bad", subject, trouble)
            return
        yield Point("good", subject, text)


def _before_samples(port: str) -> Iterator[Point]:
    """Yield what an analyser needs before it can be opened."""
    path = probe.program()
    yield Point("good", "sigrok-cli", path) if path else Point("bad", "sigrok-cli", probe.MISSING)
    if port.removeprefix(probe.PREFIX).startswith(probe.DRIVER) and not any(_analysers()):
        yield Point("bad", "analyser", f"none on USB that the driver {probe.DRIVER} knows: plug it in")


def _analysers() -> Iterator[Point]:
    for found in probe.plugged_in():
        trouble = found.missing
        text = f"{found.name} ({found.port})"
        yield (Point("poor", "analyser", f"{text}: {trouble}") if trouble else Point("good", "analyser", text))


def _has_pyserial() -> bool:
    try:
        import serial  # noqa: F401
    except ImportError:
        return False
    return True


def _pyserial() -> Iterator[Point]:
    if not _has_pyserial():
        yield Point("bad", "pyserial", missing("pyserial"))
        return
    import serial

    yield Point("good", "pyserial", serial.__version__)
    found = ports.found()
    if found:
        yield Point("good", "ports", ", ".join(f"{port} ({behind})" for port, behind in found))
    else:
        yield Point("poor", "ports", f"none: plug the adapter in; {advice().no_port}")
        yield from _rights()


def _rights() -> Iterator[Point]:
    """Say before there is a port whether its group will be missing: joining it takes a new login."""
    if sys.platform != "linux" or is_root():
        return
    import grp  # noqa: PLC0415 - not on Windows

    name = advice().ports_group
    try:
        group = grp.getgrnam(name)
    except KeyError:  # another distribution's name
        return
    if group.gr_gid not in {*os.getgroups(), os.getegid()}:
        cure = f"`sudo usermod -aG {name} $USER`, then log in again"
        yield Point("poor", "group", f"you are not in group {name}, to which serial ports belong: {cure}")


def _grabbers() -> Iterator[Point]:
    names = set()
    for file in others.PROC.glob("[0-9]*/comm"):
        try:
            names.add(file.read_text().strip())
        except OSError:  # the process has ended
            continue
    for name, cure in others.GRABBERS.items():
        if name in names:
            yield Point("poor", "others", f"{name} is running: {cure}")


def _clock() -> Iterator[Point]:
    if priority.is_real_time():
        yield Point("good", "priority", "a capture gets real-time priority")
    else:
        yield Point("poor", "priority", f"other programs can make a capture late: {advice().late}")
    results, trouble = measurement.load()
    result, misfit = measurement.fitting(results, measurement.MACHINE, measurement.conditions())
    if result:
        text = f"of {result.date}: 99.9 % of {result.characters} characters within {in_ms(result.p999_ns)}"
        yield Point("good", "self-test", text)
    else:
        cure = "none: `sistap selftest` measures how exact the times are; until then, a capture measures when it starts"
        yield Point("poor", "self-test", trouble or misfit or cure)


def _libpcap() -> Iterator[Point]:
    try:
        Filter("link[5] == 0x10")
        yield Point("good", "libpcap", "capture filters work (-f)")
    except Refusal as error:
        yield Point("poor", "libpcap", str(error))


def _wireshark() -> Iterator[Point]:
    try:
        with Tshark() as tshark:
            yield _version(tshark.answer("--version"))
            done = tshark.ask("-G", "plugins")
            named = tshark.answer("-G", "folders")
    except (TsharkError, OSError) as error:
        yield Point("bad", "tshark", f"{error}")
        return
    yield _plugin(done.stdout, done.stderr)
    if not is_root():  # for whom tshark runs as somebody else
        with suppress(TsharkError, OSError):
            own, everybodys = (folders.parse(named, for_all=for_all).profiles for for_all in (False, True))
            yield _profile(own / profile.NAME, everybodys / profile.NAME)


def _profile(own: Path, everybodys: Path) -> Point:
    """Compare the profile that Wireshark uses with that of this version. May raise OSError."""
    if not own.is_dir():
        if everybodys.is_dir():
            return Point("good", "profile", f"{profile.NAME}, for all users")
        return Point("poor", "profile", f"there is no profile {profile.NAME}: `sistap install` puts it there")
    found = profile.look(own, sorted((profile.FOLDER / profile.NAME).iterdir()))
    if found.outdated:
        names = ", ".join(found.outdated)
        return Point("poor", "profile", f"of another version of sistap in {own}: {names}: run `sistap install`")
    yours = f"; changed by you, so an update leaves them: {', '.join(found.changed)}" if found.changed else ""
    return Point("good", "profile", f"{profile.NAME}{yours}")


def _version(text: str) -> Point:
    found = version(text)
    if not found:
        return Point("bad", "tshark", "it does not print its version: install tshark 4.0 or later")
    if (found.major, found.minor) < OLDEST_WIRESHARK:
        return Point("bad", "tshark", f"{found.text} is too old: install 4.0 or later")
    if not programs.of_wireshark("wireshark"):
        return Point("poor", "tshark", f"{found.text}, but no Wireshark: {advice().wireshark}")
    return Point("good", "tshark", f"{found.text}, with Wireshark")


def _recorder() -> Iterator[Point]:
    """Check whether the service of a recorder runs, if it is installed."""
    if not any((folder / RECORDER).exists() for folder in UNITS):
        return
    try:
        asked = subprocess.run(["systemctl", "is-active", RECORDER], capture_output=True, text=True, check=False)
        state = asked.stdout.strip() or "not known"
    except OSError:
        state = "without systemd"
    if state == "active":
        yield Point("good", "recorder", f"{RECORDER} runs")
    else:
        cure = f"`sudo systemctl enable --now sistap-recorder`; `journalctl -u {RECORDER}` says why it has ended"
        yield Point("poor", "recorder", f"{RECORDER} is installed, but {state}: {cure}")


def _dumpcap() -> Iterator[Point]:
    """Check whether Wireshark may start dumpcap, which it needs for serial ports, too."""
    # F_OK: find one that this user may not run as well
    path = programs.of_wireshark("dumpcap") if sys.platform == "win32" else shutil.which("dumpcap", mode=os.F_OK)
    if sys.platform != "win32" and path and not os.access(path, os.X_OK):
        group = Path(path).group()
        cure = f"`sudo usermod -aG {group} $USER`, then log in again"
        yield Point("bad", "dumpcap", f"Wireshark cannot capture: {path} is for group {group}: {cure}")
    elif path:
        yield Point("good", "dumpcap", "Wireshark may capture")


def _plugin(listed: str, complaints: str) -> Point:
    """Judge the output of `tshark -G plugins`."""
    found = [f"{plugin.name} {plugin.version}".strip() for plugin in loaded(listed)]
    as_root = f"; {_AS_ROOT}" if hasattr(os, "geteuid") and os.geteuid() == 0 else ""
    if found:
        return Point("good", "plugin", ", ".join(found) + as_root)
    why = next((f" ({line})" for line in complaints.splitlines() if "sis" in line), "")
    text = f"neither sis.so nor sis.lua is loaded{why}: `sistap install` puts it where this Wireshark looks"
    return Point("bad", "plugin", text + as_root)


_LOOKS = (_pyserial, _analysers, _grabbers, _clock, _libpcap, _wireshark, _dumpcap, _recorder)
