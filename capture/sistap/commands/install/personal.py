# SPDX-License-Identifier: GPL-2.0-or-later
"""The profile SIS in a user's folder: it follows the version of sistap, except for what the user has changed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from sistap.commands.install import sources
from sistap.commands.install.ledger import ElsewhereError, Ledger
from sistap.commands.install.turn import alone
from sistap.dissected.wireshark import profile
from sistap.dissected.wireshark.folders import Own
from sistap.tap.line import measurement
from sistap.tap.terminal import state
from sistap.tap.terminal.advice import advice, shell_word

_LAST_USED = f"gui.last_used_profile: {profile.NAME}"


def adopt(ledger: Ledger, copy: Path) -> None:
    """Put on the list what is as some version of sistap has it: Wireshark may have copied it. May raise OSError.

    Also what Wireshark writes itself, unless it belongs to changes of the user.
    """
    if not copy.is_dir():
        return
    changed = profile.look(copy, sources.profile()).changed
    for file in sorted(copy.iterdir()):
        if profile.is_as_installed(file) or (file.name == profile.RECENT and not changed and not file.is_symlink()):
            ledger.adopt(file)


def files(copy: Path) -> Iterator[tuple[Path, bytes]]:
    """Yield what a copy should have: files and their contents. May raise OSError."""
    for file in sources.profile():
        content, own = file.read_bytes(), copy / file.name
        if file.name == profile.RECENT and own.is_file():
            content = _recent(own.read_bytes(), content, copy / profile.COLUMNS)
        yield own, content


def _recent(own: bytes, of_version: bytes, columns: Path) -> bytes:
    """Return what Wireshark has written, with the widths of new columns unless the columns are the user's."""
    if columns.is_file() and not profile.is_as_installed(columns):
        return own
    text = own.decode("utf-8", "surrogateescape")
    return profile.with_widths(text, of_version.decode()).encode("utf-8", "surrogateescape")


def renew(configuration: Path) -> Iterator[str]:
    """Renew the copy in a user's folder of Wireshark, if there is one; yield a line for each change."""
    copy = configuration / "profiles" / profile.NAME
    if copy.is_dir():
        with alone(for_all=False) as ledger:
            adopt(ledger, copy)
            lines = [ledger.put(file, content) for file, content in files(copy)]
            ledger.save()
        yield from (line for line in lines if not line.startswith("same"))


def remove(configuration: Path) -> Iterator[str]:
    """Remove the copy in a user's folder of Wireshark, except for what the user has changed; yield a line for each."""
    copy = configuration / "profiles" / profile.NAME
    own = Own.of([configuration])
    with alone(for_all=False) as ledger:
        adopt(ledger, copy)
        for file in [file for file in ledger.files if file.parent == copy]:
            try:
                yield ledger.remove(file, own)
            except ElsewhereError as error:
                yield str(error)
        yield from ledger.remove_folders(own)
        yield from left(copy, ledger)
        ledger.save()
    forget(configuration)
    measurement.forget()


def left(copy: Path, ledger: Ledger) -> Iterator[str]:
    """Yield a line about what is left of a removed copy: when a setting changes, Wireshark writes files anew."""
    if copy in ledger.removed_from and copy.is_dir():
        cure = advice().remove.format(folder=shell_word(str(copy)))
        yield f"the rest of the profile was changed by Wireshark or by you: {cure}"


def forget(configuration: Path) -> None:
    """Let Wireshark begin with another profile: this one's colours need the dissector. May raise OSError."""
    common = configuration / "recent_common"
    if common.is_file() and not common.is_symlink():
        lines = common.read_bytes().splitlines(keepends=True)
        left = [line for line in lines if line.strip() != _LAST_USED.encode()]
        if left != lines:
            state.replace(common, b"".join(left))
