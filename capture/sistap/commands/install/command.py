# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap install`: what it installs, where, and whether Wireshark loads it."""

from __future__ import annotations

import argparse
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.commands.install import personal, shell, sources
from sistap.commands.install.ledger import ElsewhereError, Ledger
from sistap.commands.install.shell import launcher, settings
from sistap.commands.install.turn import alone
from sistap.dissected.wireshark import folders, profile
from sistap.dissected.wireshark.tshark import (
    OLDEST_WIRESHARK,
    Loaded,
    Tshark,
    TsharkError,
    Version,
    is_roots_alone,
    loaded,
    version,
)
from sistap.tap.common.packages import is_bundle
from sistap.tap.terminal import programs
from sistap.tap.terminal.advice import advice, shell_word
from sistap.tap.terminal.console import Console, visible
from sistap.tap.terminal.exits import DONE, FAILED
from sistap.tap.terminal.state import is_root
from sistap.tap.terminal.stop import held

DESCRIPTION = """\
Install the dissector, the serial ports among Wireshark's interfaces (extcap) and the profile SIS for the Wireshark of
this computer. Also install the command `sistap` with completion for the shell. sistap prints one line for each file and
asks nothing. Run it again after an update of sistap or Wireshark.
"""

EPILOG = """\
The dissector is the plugin built in this checkout, if it was built for this Wireshark. A plugin fits one version only
(4.0, 4.2 ...). Otherwise sistap installs sis.lua, which fits all versions from 4.0 on. A dissector that Wireshark
already loads from elsewhere stays. So does a plugin of an earlier install, if Wireshark loads it and no newer one was
built. With --lua, sis.lua replaces a plugin of an earlier install.

The command goes into ~/.local/bin; for all users into /usr/local/bin; on Windows into a folder of its own. If that
folder is not in PATH, a message says what to do. A command sistap from a package stays.

As root, sistap installs for all users. Wireshark run as root does not read personal folders. sistap keeps a file that
somebody else put there or has changed. `sistap uninstall` removes everything again.

examples:
  sistap install                                        for this user
  sudo sistap install                                   for all users
  sistap install --plugin build/plugin/plugin/sis.so    this plugin, if it fits
  sistap install --lua                                  the script instead of the plugin
  sistap install --wireshark /opt/wireshark/bin         a Wireshark that is not on PATH
  wireshark -C SIS                                      afterwards: start Wireshark with the profile

exit status:
  0  done
  1  something could not be written, or Wireshark does not load the dissector
  2  wrong usage, or FILE is not a plugin
"""

WINDOWS = os.name == "nt"

_FOR_ALL = "all users: run as root, it skips what is in personal folders"


class InstalledFile(NamedTuple):
    """A file to install."""

    target: Path
    content: bytes
    executable: bool = False


class Asked(NamedTuple):
    """What tshark has said."""

    version: Version
    folders: str
    plugins: list[Loaded]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--plugin", metavar="FILE", type=_existing_file, help="install this plugin, sis.so, if it fits")
    which.add_argument("--lua", action="store_true", help="install sis.lua, even if a plugin fits")
    parser.add_argument(
        "--wireshark",
        metavar="FOLDER",
        type=_with_tshark,
        help="use the Wireshark of this folder, also later: one without an installer, or a portable one",
    )


def run(args: argparse.Namespace) -> int:
    """Install; print a line for each file; return the exit code."""
    console = Console()
    try:
        return _install(args, console)
    except (RuntimeError, OSError) as error:
        console.say(str(error))
        return FAILED


def _existing_file(text: str) -> Path:
    if not Path(text).is_file():
        raise argparse.ArgumentTypeError(f"there is no file {text}")
    return Path(text)


def _with_tshark(text: str) -> Path:
    if not programs.in_folder("tshark", Path(text).absolute()):
        raise argparse.ArgumentTypeError(f"there is no tshark in {text}")
    return Path(text)


def _install(args: argparse.Namespace, console: Console) -> int:
    for_all = is_root()
    if args.wireshark:
        programs.remember(args.wireshark)
    with Tshark(drop_rights=False) as tshark:
        wireshark = _supported_version(tshark)
        named = tshark.answer("-G", "folders")
        there = loaded(tshark.ask("-G", "plugins").stdout)
    with alone(for_all=for_all) as ledger:
        print(f"Wireshark {wireshark.text}, for {_FOR_ALL if for_all else 'this user'}", flush=True)
        _put(args, Asked(wireshark, named, there), ledger, console)
    if for_all:
        _warn_of_others_rights(console)
    return _check(console)


def _put(args: argparse.Namespace, asked: Asked, ledger: Ledger, console: Console) -> None:
    """Put all files. Raise RuntimeError or OSError."""
    for_all = is_root()
    places = folders.parse(asked.folders, for_all=for_all)
    files = list(_others(places))
    if not for_all:
        personal.adopt(ledger, places.profiles / profile.NAME)
        files = list(_not_there_for_all(files, list(_others(folders.parse(asked.folders, for_all=True)))))
    script = args.lua or (WINDOWS and not args.plugin)  # a build here would be one of Linux, in a copied checkout
    chosen = sources.Dissector(sources.lua(), False, []) if script else sources.dissector(args.plugin, asked.version)
    foreign = _foreign(asked.plugins, ledger)
    if foreign:
        _tell(f"kept     {foreign}: Wireshark loads it, and `sistap install` did not put it there")
    else:
        working = next((Path(found.file) for found in asked.plugins if not found.file.endswith(".lua")), None)
        files.append(_dissector(chosen, places, working, console, replace=args.lua))
    where = shell.places(for_all=for_all, windows=WINDOWS)
    files += _for_a_shell(args, where, ledger)
    _bring_up_to_date(ledger, files, own_folders(asked.folders, for_all=for_all))
    on_path = [Path(folder) for folder in os.environ.get("PATH", "").split(os.pathsep)]
    if where.command in ledger.files and where.command.parent not in on_path:
        cure = advice().path.format(folder=shell_word(str(where.command.parent)))
        console.say(f"{where.command.parent} is not in PATH: {cure}")


def _tell(line: str) -> None:
    """Print a line. File names in it come from others, so make them visible."""
    print(visible(line), flush=True)


def named_folders() -> str:
    """Return what tshark says of its folders. Raise TsharkError."""
    with Tshark(drop_rights=False) as tshark:
        return tshark.answer("-G", "folders")


def own_folders(named: str, *, for_all: bool) -> folders.Own:
    """Return all folders into which install puts files: Wireshark's own and those of a shell. Raise TsharkError."""
    return folders.Own(named, for_all=for_all, others=shell.folders(shell.places(for_all=for_all, windows=WINDOWS)))


def _supported_version(tshark: Tshark) -> Version:
    found = version(tshark.answer("--version"))
    if not found:
        raise TsharkError("tshark does not say its version: install tshark 4.0 or later")
    if (found.major, found.minor) < OLDEST_WIRESHARK:
        raise TsharkError(f"Wireshark {found.text} is too old: install 4.0 or later")
    return found


def _foreign(there: list[Loaded], ledger: Ledger) -> str:
    """Return the dissector that Wireshark loads and that install did not put there."""
    ours = [file.resolve() for file in ledger.files]
    return next((found.file for found in there if Path(found.file).resolve() not in ours), "")


def _dissector(
    chosen: sources.Dissector, places: folders.Folders, working: Path | None, console: Console, *, replace: bool
) -> InstalledFile:
    """Return the file of the dissector. With `replace`, the script replaces a plugin that works."""
    if working and not chosen.is_module and not replace:
        for note in chosen.notes:
            console.say(f"{note}; {working} stays")
        _tell(
            f"kept     {working}: Wireshark loads it, and there is no other plugin for it here; `sistap install "
            "--plugin FILE` takes one, `sistap install --lua` takes sis.lua"
        )
        return InstalledFile(working, working.read_bytes())
    for note in chosen.notes:
        console.say(note if chosen.is_module else f"{note}; sis.lua takes its place")
    target = places.plugins / "sis.so" if chosen.is_module else places.lua / "sis.lua"
    return InstalledFile(target, chosen.file.read_bytes())


def _others(places: folders.Folders) -> Iterator[InstalledFile]:
    """Yield all files but the dissector."""
    yield from _launchers(places.extcap, sources.PACKAGE.parent)
    for target, content in personal.files(places.profiles / profile.NAME):
        yield InstalledFile(target, content)


def _for_a_shell(args: argparse.Namespace, where: shell.Places, ledger: Ledger) -> Iterator[InstalledFile]:
    """Yield the command and its completion, unless a shell has a command `sistap` from elsewhere."""
    if is_bundle():  # which has the command
        return
    if found := shell.foreign(ledger.files):
        _tell(f"kept     {found}: the command sistap is there already, and `sistap install` did not put it there")
        return
    for file, content in shell.files(where, sources.PACKAGE.parent, args.whole_parser(), windows=WINDOWS).items():
        yield InstalledFile(file, content, executable=file == where.command)


def _launchers(folder: Path, package_root: Path) -> Iterator[InstalledFile]:
    """Yield the launchers by which Wireshark starts sistap. On Windows use a program if possible: cmd.exe garbles
    filters.
    """
    text = launcher(sys.executable, package_root, WINDOWS)
    if not WINDOWS:
        yield InstalledFile(folder / "sistap", text.encode(), executable=True)
    elif program := sources.executable():
        yield InstalledFile(folder / "sistap.exe", program.read_bytes(), executable=True)
        yield InstalledFile(folder / "sistap.cfg", settings(sys.executable, package_root).encode())
    else:
        yield InstalledFile(folder / "sistap.bat", text.encode(), executable=True)


def _not_there_for_all(files: list[InstalledFile], for_all: list[InstalledFile]) -> Iterator[InstalledFile]:
    """Leave out what all users have: Wireshark would show each port twice. A user's own profile hides that of all."""
    for file, everybodys in zip(files, for_all, strict=True):
        is_hidden = file.target.parent.name == profile.NAME and file.target.parent.exists()
        if everybodys.target.exists() and not is_hidden:
            _tell(f"same     {everybodys.target}: all users have it")
        else:
            yield file


def _bring_up_to_date(ledger: Ledger, files: list[InstalledFile], own: folders.Own) -> None:
    """Put new files; remove what an earlier install put elsewhere (sis.lua, another Wireshark). May raise OSError."""
    lines: list[str] = []
    try:
        with held():  # so that the list names every file that was put, whenever a signal comes
            try:
                for line in _changes(ledger, files, own):
                    lines.append(line)
            finally:
                ledger.save()
    finally:
        for line in lines:
            _tell(line)


def _changes(ledger: Ledger, files: list[InstalledFile], own: folders.Own) -> Iterator[str]:
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
    """Warn if other users cannot run what the launcher names, or can change what all users then run."""
    closed = [path for path in (sources.PACKAGE, *sources.PACKAGE.parents) if not path.stat().st_mode & stat.S_IXOTH]
    if closed:
        console.say(
            f"other users get no serial ports in Wireshark, as they may not enter {closed[-1]}: run install from a "
            "folder that is open to all"
        )
    packages = (sources.PACKAGE, sources.PACKAGE.with_name("sisbus"))
    run = (*(file for package in packages for file in package.rglob("*")), Path(sys.executable).resolve())
    changeable = next((path for path in run if not is_roots_alone(path)), None)
    if changeable:
        console.say(
            f"others than root can write {changeable}, or a folder on the way to it, and so change what all users run: "
            "install the .deb, or run install from a folder that only root can write, such as a copy in /opt"
        )


def _silent_reason() -> str:
    """Return why Wireshark may load nothing from its folders without an error."""
    if folder := os.environ.get("WIRESHARK_PLUGIN_DIR"):
        return f"WIRESHARK_PLUGIN_DIR is set, so it looks in {folder} alone; unset it"
    return "it does not say why"


def _check(console: Console) -> int:
    """Ask Wireshark, as an ordinary user, whether it loads the dissector."""
    with Tshark() as tshark:
        done = tshark.ask("-G", "plugins")
    found = loaded(done.stdout)
    if not found:
        why = next((line for line in done.stderr.splitlines() if "sis" in line), _silent_reason())
        console.say(f"Wireshark does not load the dissector: {why}")
        return FAILED
    _tell(f"Wireshark loads {found[0].name} {found[0].version}".rstrip() + f"; {advice().started}")
    return DONE
