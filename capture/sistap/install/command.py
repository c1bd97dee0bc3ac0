# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap install`: what it puts, where, and whether Wireshark takes it."""

from __future__ import annotations

import argparse
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.install import module, sources
from sistap.install.launching import launcher, settings
from sistap.install.ledger import ElsewhereError, Ledger, LedgerError
from sistap.terminal.advice import advice
from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED, USAGE
from sistap.terminal.state import is_root
from sistap.terminal.stop import held
from sistap.wireshark import folders
from sistap.wireshark.tshark import OLDEST_WIRESHARK, Loaded, Tshark, TsharkError, Version, loaded, version

DESCRIPTION = """\
Put the dissector, the serial ports among Wireshark's interfaces (extcap) and the profile SIS where the Wireshark of
this machine looks for them. Says in a line each what it did; asks nothing; safe to run again, also for a newer sistap
or after a new Wireshark.
"""

EPILOG = """\
The dissector is the plugin built in this checkout, if it was built for this Wireshark (4.0, 4.2 ...: a plugin fits
one of them only), and else sis.lua, which fits all from 4.0 on. What Wireshark loads already from elsewhere is kept.

Run as root it installs for all users: as root, Wireshark skips what is in personal folders.
A file that somebody else put there, or has changed since, is kept. `sistap uninstall` takes everything away again.

examples:
  sistap install                                        for this user
  sudo sistap install                                   for all users
  sistap install --plugin build/plugin/plugin/sis.so    this plugin, if it fits
  wireshark -C SIS                                      then: Wireshark with the profile

exit status:
  0  done
  1  something could not be written, or Wireshark does not load it
  2  wrong usage, or FILE is no plugin
"""

WINDOWS = os.name == "nt"

_FOR_ALL = "all users: run as root, it skips what is in personal folders"


class File(NamedTuple):
    """One file to put."""

    target: Path
    content: bytes
    executable: bool = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.add_argument("--plugin", metavar="FILE", type=_existing_file, help="take this plugin, sis.so, if it fits")


def run(args: argparse.Namespace) -> int:
    """Install; print a line for each file; return the exit code."""
    console = Console()
    try:
        return _install(args.plugin, console)
    except module.ModuleError as error:
        console.say(str(error))
        return USAGE
    except (TsharkError, folders.FoldersError, sources.SourceError, LedgerError, RuntimeError, OSError) as error:
        console.say(str(error))
        return FAILED


def _existing_file(text: str) -> Path:
    if not Path(text).is_file():
        raise argparse.ArgumentTypeError(f"there is no file {text}")
    return Path(text)


def _install(plugin: Path | None, console: Console) -> int:
    for_all = is_root()
    with Tshark(drop_rights=False) as tshark:
        wireshark = _supported_version(tshark)
        named = tshark.output("-G", "folders")
        there = loaded(tshark.run(["-G", "plugins"]).stdout)
    ledger = Ledger(for_all=for_all)
    for note in ledger.notes:
        console.say(note)
    print(f"Wireshark {wireshark.text}, for {_FOR_ALL if for_all else 'this user'}", flush=True)
    places = folders.parse(named, for_all=for_all)
    files = list(_others(places))
    if not for_all:
        files = list(_not_there_for_all(files, list(_others(folders.parse(named, for_all=True)))))
    foreign = _foreign(there, ledger)
    if foreign:
        print(f"kept     {foreign}: Wireshark loads it, and `sistap install` did not put it there", flush=True)
    else:
        files.append(_dissector(plugin, wireshark, places, console))
    _bring_up_to_date(ledger, files, folders.Own(named, for_all=for_all))
    if for_all:
        _warn_of_others_rights(console)
    return _check(console)


def own_folders() -> folders.Own:
    """Ask Wireshark which folders are its own: as root those for all users. TsharkError, folders.FoldersError."""
    with Tshark(drop_rights=False) as tshark:
        return folders.Own(tshark.output("-G", "folders"), for_all=is_root())


def _supported_version(tshark: Tshark) -> Version:
    found = version(tshark.output("--version"))
    if not found:
        raise TsharkError("tshark does not say its version: install tshark 4.0 or later")
    if (found.major, found.minor) < OLDEST_WIRESHARK:
        raise TsharkError(f"Wireshark {found.text} is too old: install 4.0 or later")
    return found


def _foreign(there: list[Loaded], ledger: Ledger) -> str:
    """Return the file of a dissector that Wireshark loads and that install has not put."""
    ours = [file.resolve() for file in ledger.files]
    return next((found.file for found in there if Path(found.file).resolve() not in ours), "")


def _dissector(plugin: Path | None, wireshark: Version, places: folders.Folders, console: Console) -> File:
    chosen = sources.dissector(plugin, wireshark)
    for note in chosen.notes:
        console.say(note if chosen.is_module else f"{note}; sis.lua takes its place")
    target = places.plugins / "sis.so" if chosen.is_module else places.lua / "sis.lua"
    return File(target, chosen.file.read_bytes())


def _others(places: folders.Folders) -> Iterator[File]:
    """Yield all but the dissector."""
    yield from _launchers(places.extcap, sources.PACKAGE.parent)
    for file in sources.profile():
        yield File(places.profiles / sources.PROFILE / file.name, file.read_bytes())


def _launchers(folder: Path, package_root: Path) -> Iterator[File]:
    """Yield by what Wireshark starts sistap; on Windows a program where there is one: cmd.exe garbles filters."""
    text = launcher(sys.executable, package_root, WINDOWS)
    if not WINDOWS:
        yield File(folder / "sistap", text.encode(), executable=True)
    elif program := sources.executable():
        yield File(folder / "sistap.exe", program.read_bytes(), executable=True)
        yield File(folder / "sistap.cfg", settings(sys.executable, package_root).encode())
    else:
        yield File(folder / "sistap.bat", text.encode(), executable=True)


def _not_there_for_all(files: list[File], for_all: list[File]) -> Iterator[File]:
    """Leave out what all users have: Wireshark would show each port twice."""
    for file, everybodys in zip(files, for_all, strict=True):
        if everybodys.target.exists():
            print(f"same     {everybodys.target}: all users have it", flush=True)
        else:
            yield file


def _bring_up_to_date(ledger: Ledger, files: list[File], own: folders.Own) -> None:
    """Put what is new, remove what an earlier install has put elsewhere (sis.lua, another Wireshark). OSError."""
    lines: list[str] = []
    try:
        with held():  # what was put is on the list, whenever a signal comes
            try:
                for line in _changes(ledger, files, own):
                    lines.append(line)
            finally:
                ledger.save()
    finally:
        for line in lines:
            print(line, flush=True)


def _changes(ledger: Ledger, files: list[File], own: folders.Own) -> Iterator[str]:
    wanted = {file.target for file in files}
    for old in ledger.files:
        if old not in wanted:
            try:
                yield ledger.remove(old, own)
            except ElsewhereError as error:
                yield str(error)
    for file in files:
        yield ledger.put(file.target, file.content, executable=file.executable)
    yield from ledger.remove_folders(own)


def _warn_of_others_rights(console: Console) -> None:
    """Say it if the other users cannot run what the launcher names."""
    closed = [path for path in (sources.PACKAGE, *sources.PACKAGE.parents) if not path.stat().st_mode & stat.S_IXOTH]
    if closed:
        console.say(
            f"other users get no serial ports in Wireshark, as they may not enter {closed[-1]}: run install from a "
            "folder that is open to all"
        )


def _silent_reason() -> str:
    """Say why Wireshark may load nothing from its folders without a word."""
    if folder := os.environ.get("WIRESHARK_PLUGIN_DIR"):
        return f"WIRESHARK_PLUGIN_DIR is set, so it looks in {folder} alone; unset it"
    return "it does not say why"


def _check(console: Console) -> int:
    """Ask Wireshark, as an ordinary user, whether it loads the dissector."""
    with Tshark() as tshark:
        done = tshark.run(["-G", "plugins"])
    found = loaded(done.stdout)
    if not found:
        why = next((line for line in done.stderr.splitlines() if "sis" in line), _silent_reason())
        console.say(f"Wireshark does not load the dissector: {why}")
        return FAILED
    print(f"Wireshark loads {found[0].name} {found[0].version}".rstrip() + f"; {advice().started}")
    return DONE
