# SPDX-License-Identifier: GPL-2.0-or-later
"""The ledger remembers what was put where, and nobody else's file is touched."""

import errno
import json
import os
import re
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import pytest
from portable import WINDOWS, fifos, links, posix

import sistap.tap.terminal.state
from sistap.commands.install import turn
from sistap.commands.install.ledger import ElsewhereError, Ledger
from sistap.commands.install.turn import alone
from sistap.dissected.wireshark.folders import Own
from sistap.tap.terminal.exits import Refusal
from sistap.tap.terminal.state import StateError
from sistap.tap.terminal.stop import Stop, Stopped

DEEP = pytest.param("[" * 100_000, id="deep")  # no variable of Windows can have such a name in it
no_root = posix("there is no root")


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "wireshark"


@pytest.fixture
def own(place: Path) -> Own:
    """Wireshark's folders: all of them are in `place`."""
    named = {
        "configuration": place,
        "Plugins": place / "plugins/4.0",
        "Lua Plugins": place / "plugins",
        "Extcap path": place / "extcap",
    }
    return Own("".join(f"Personal {name}:\t{folder}\n" for name, folder in named.items()), for_all=False)


def again(ledger: Ledger) -> Ledger:
    """Read what was written, as the next run does."""
    ledger.save()
    return Ledger(for_all=False)


def tree(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*")}


def test_all_that_was_put_is_removed_again(place: Path, own: Own) -> None:
    before = tree(place.parent)
    ledger = Ledger(for_all=False)
    script, plugin = place / "extcap/sistap", place / "plugins/4.0/epan/sis.so"
    assert ledger.put(script, b"#!/bin/sh\n", executable=True) == f"put      {script}"
    assert ledger.put(plugin, b"\x7fELF") == f"put      {plugin}"
    assert WINDOWS or (script.stat().st_mode & 0o777, plugin.stat().st_mode & 0o777) == (0o755, 0o644)
    ledger = again(ledger)
    assert ledger.files == [script, plugin]
    assert [ledger.remove(file, own) for file in ledger.files] == [f"removed  {script}", f"removed  {plugin}"]
    ledger.remove_folders(own)
    ledger.save()
    assert tree(place.parent) == before
    assert not ledger.path.parent.exists()


class Killed(BaseException):
    """SIGKILL: nothing is done any more."""


@pytest.mark.parametrize("goes_on", [True, False])
@pytest.mark.parametrize("moment", ["before", "after"])
@pytest.mark.parametrize("old", [None, b"old"])
@pytest.mark.attack("SIGKILL while install puts a file", "the next install goes on, and uninstall removes all of it")
def test_one_that_is_killed_is_gone_on_with(
    place: Path, own: Own, monkeypatch: pytest.MonkeyPatch, *, old: bytes | None, moment: str, goes_on: bool
) -> None:
    file, before = place / "a/sis.so", tree(place.parent)
    if old:
        ledger = Ledger(for_all=False)
        ledger.put(file, old)
        ledger.save()
    replace = sistap.tap.terminal.state.replace

    def killed(put: Path, content: bytes, *, executable: bool = False) -> None:
        if put != file or moment == "after":
            replace(put, content, executable=executable)
        if put == file:
            raise Killed

    with monkeypatch.context() as killing:
        killing.setattr(sistap.tap.terminal.state, "replace", killed)
        with pytest.raises(Killed):
            Ledger(for_all=False).put(file, b"new")
    ledger = Ledger(for_all=False)
    if goes_on:
        ledger.put(file, b"new")
        ledger = again(ledger)
        assert file.read_bytes() == b"new"
    said = "removed" if file.exists() else "gone"
    assert ledger.remove(file, own).startswith(said)
    ledger.remove_folders(own)
    ledger.save()
    assert tree(place.parent) == before


@pytest.mark.attack("the list of installed files cannot be written", "nothing is installed that could not be removed")
def test_what_could_not_be_remembered_is_not_put(place: Path) -> None:
    ledger = Ledger(for_all=False)
    ledger.path.parent.parent.mkdir(parents=True, exist_ok=True)
    ledger.path.parent.touch()  # a file where the folder has to be
    with pytest.raises(OSError, match=re.escape(repr(str(ledger.path.parent))[1:-1])):
        ledger.put(place / "sis.so", b"")
    assert not place.exists()


@pytest.mark.parametrize("failing", [(Path, "mkdir"), (sistap.tap.terminal.state, "replace")], ids=["folder", "file"])
def test_what_could_not_be_put_is_not_on_the_list(
    place: Path, monkeypatch: pytest.MonkeyPatch, failing: tuple[object, str]
) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "sis.lua", b"")
    ledger.save()
    real = getattr(*failing)

    def full(path: Path, *args: object, **kwargs: object) -> None:
        if path.is_relative_to(place):
            raise OSError(28, "No space left on device", str(path))
        real(path, *args, **kwargs)

    monkeypatch.setattr(*failing, full)
    with pytest.raises(OSError, match="No space left"):
        ledger.put(place / "extcap/sistap", b"")
    assert Ledger(for_all=False).files == [place / "sis.lua"]


@pytest.mark.attack("two installs at once", "one waits for the other, and uninstall removes all of both")
def test_a_second_install_waits_for_the_first(place: Path, own: Own, monkeypatch: pytest.MonkeyPatch) -> None:
    before = tree(place.parent)
    with ExitStack() as first:
        ledger = first.enter_context(alone(for_all=False))

        def end_the_first(seconds: float) -> None:
            ledger.put(place / "plugins/sis.lua", b"")
            ledger.save()
            first.close()

        monkeypatch.setattr(turn, "time", SimpleNamespace(monotonic=time.monotonic, sleep=end_the_first))
        with alone(for_all=False) as second:
            second.put(place / "extcap/sistap", b"")
            second.save()
    with alone(for_all=False) as last:
        assert last.files == [place / "plugins/sis.lua", place / "extcap/sistap"]
        for file in last.files:
            last.remove(file, own)
        last.remove_folders(own)
        last.save()
    assert tree(place.parent) == before


def test_a_second_install_waits_no_longer_than_that(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turn, "WAIT_S", 0)
    with alone(for_all=False), pytest.raises(Refusal, match="another .* is under way: try again when it has ended"):
        alone(for_all=False).__enter__()
    with alone(for_all=False):  # the first has ended
        pass
    assert not Ledger(for_all=False).path.parent.exists()


@posix("Windows has no such modes")
def test_nobody_else_can_make_an_install_wait() -> None:
    with alone(for_all=False) as ledger:
        assert (ledger.path.parent / turn.NAME).stat().st_mode & 0o077 == 0


def test_a_lock_of_one_that_was_killed_is_taken() -> None:
    lock = Ledger(for_all=False).path.parent / turn.NAME
    lock.parent.mkdir(parents=True)
    lock.touch()
    with alone(for_all=False):
        pass
    assert not lock.parent.exists()


def failing(number: int, at: Path) -> Callable[..., int]:
    """Return what takes the place of os.open: a file cannot be opened."""
    real = os.open

    def opened(path: Path, *args: int, **kwargs: int) -> int:
        if Path(path) == at:
            raise OSError(number, os.strerror(number), str(path))
        return real(path, *args, **kwargs)

    return opened


@pytest.mark.parametrize("number", [errno.EMFILE, errno.EIO])
def test_without_its_turn_nothing_is_done(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    path = Ledger(for_all=False).path.parent / turn.NAME
    monkeypatch.setattr(os, "open", failing(number, path))
    with pytest.raises(OSError, match=os.strerror(number)):
        alone(for_all=False).__enter__()


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.ENOSPC])
def test_where_no_list_can_be_saved_nobody_waits(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    path = Ledger(for_all=False).path.parent / turn.NAME
    monkeypatch.setattr(os, "open", failing(number, path))
    with alone(for_all=False) as ledger:
        assert ledger.is_empty


def test_the_other_removes_the_folder_while_one_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then Python's mkdir says that the folder exists."""
    folder, real = Ledger(for_all=False).path.parent, os.mkdir
    there = iter([True])

    def mkdir(path: Path, *args: int) -> None:
        if Path(path) == folder and next(there, False):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
        real(path, *args)

    monkeypatch.setattr(os, "mkdir", mkdir)
    with alone(for_all=False):
        assert (folder / turn.NAME).exists()


def test_windows_denies_access_for_a_moment_while_the_other_removes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """That is no reason to go on without a turn."""
    path, real = Ledger(for_all=False).path.parent / turn.NAME, os.open
    denied = iter(range(2))

    def opened(file: Path, *args: int, **kwargs: int) -> int:
        if Path(file) == path and next(denied, None) is not None:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return real(file, *args, **kwargs)

    monkeypatch.setattr(sistap.tap.terminal.state, "WINDOWS", True)
    monkeypatch.setattr(os, "open", opened)
    with alone(for_all=False):
        assert path.exists()
    assert not path.parent.exists()


@pytest.mark.parametrize("moment", ["opened", "removed"])
def test_a_signal_leaves_no_lock(monkeypatch: pytest.MonkeyPatch, moment: str) -> None:
    """It comes when the file has just been made, or is about to be removed."""
    folder = Ledger(for_all=False).path.parent
    where, name = {"opened": (turn, "_is"), "removed": (sistap.tap.terminal.state, "forget")}[moment]
    real = getattr(where, name)

    def signalled(*args: object) -> object:
        signal.raise_signal(signal.SIGINT)
        return real(*args)

    monkeypatch.setattr(where, name, signalled)
    with pytest.raises(Stopped), Stop(), alone(for_all=False):
        pass
    assert not folder.exists()


def test_folders_that_were_there_stay(place: Path, own: Own) -> None:
    place.mkdir()
    ledger = Ledger(for_all=False)
    ledger.put(place / "extcap/sistap", b"")
    ledger = again(ledger)
    ledger.remove(place / "extcap/sistap", own)
    ledger.remove_folders(own)
    assert tree(place.parent) == {"wireshark"}


@posix("a file that is open stays")
def test_what_is_new_takes_the_place_of_the_old_at_once(place: Path) -> None:
    """A running Wireshark has the old module mapped: its file must not change under it."""
    file = place / "sis.so"
    ledger = Ledger(for_all=False)
    ledger.put(file, b"old")
    ledger = again(ledger)
    with file.open("rb") as mapped:
        assert ledger.put(file, b"new") == f"renewed  {file}"
        assert mapped.read() == b"old"
    assert file.read_bytes() == b"new"
    assert ledger.put(file, b"new") == f"same     {file}"
    assert tree(place) == {"sis.so"}


def test_what_somebody_has_changed_is_kept(place: Path, own: Own) -> None:
    file = place / "preferences"
    ledger = Ledger(for_all=False)
    ledger.put(file, b"ours")
    file.write_bytes(b"theirs")
    ledger = again(ledger)
    assert ledger.put(file, b"newer").startswith(f"kept     {file}: ")
    assert ledger.remove(file, own) == f"kept     {file}: it was changed since it was put there"
    assert ledger.remove_folders(own) == [f"kept     {place}: it still has preferences"]
    assert file.read_bytes() == b"theirs"
    assert again(ledger).files == []


def test_what_somebody_else_has_put_is_kept(place: Path) -> None:
    place.mkdir()
    (place / "sis.lua").write_bytes(b"theirs")
    ledger = Ledger(for_all=False)
    assert ledger.put(place / "sis.lua", b"ours").startswith(f"kept     {place / 'sis.lua'}: ")
    assert (place / "sis.lua").read_bytes() == b"theirs"
    assert again(ledger).files == []


def test_the_same_file_put_by_somebody_else_is_not_ours(place: Path) -> None:
    """A Debian package, for instance."""
    place.mkdir()
    (place / "sis.lua").write_bytes(b"the same")
    ledger = Ledger(for_all=False)
    assert ledger.put(place / "sis.lua", b"the same") == f"same     {place / 'sis.lua'}"
    assert again(ledger).files == []


def test_what_somebody_has_put_beside_it_is_kept(place: Path, own: Own) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "SIS/preferences", b"")
    (place / "SIS/recent").touch()  # Wireshark, when the profile was used
    ledger.remove(place / "SIS/preferences", own)
    assert ledger.remove_folders(own) == [f"kept     {place / 'SIS'}: it still has recent"]
    assert tree(place) == {"SIS", "SIS/recent"}


def test_what_is_gone_already_is_no_trouble(place: Path, own: Own) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "a/sistap", b"")
    (place / "a/sistap").unlink()
    (place / "a").rmdir()
    assert ledger.remove(place / "a/sistap", own).startswith(f"gone     {place / 'a/sistap'}")
    assert ledger.remove_folders(own) == [f"removed  {place}"]


def test_a_file_that_cannot_be_written_leaves_the_old_one(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "sis.so", b"old")

    def full(self: Path, mode: int) -> None:
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr(Path, "chmod", full)
    with pytest.raises(OSError, match="No space left"):
        ledger.put(place / "sis.so", b"new")
    assert tree(place) == {"sis.so"}
    assert (place / "sis.so").read_bytes() == b"old"


def test_users_and_root_have_lists_of_their_own(place: Path) -> None:
    everybodys = Ledger(for_all=True)
    everybodys.put(place / "sis.so", b"")
    everybodys.save()
    assert Ledger(for_all=False).files == []
    assert Ledger(for_all=True).files == [place / "sis.so"]


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", '{"files": 1, "folders": []}', '{"files": {}}', DEEP, "\udcff"),
        '{"files": {"/a\\u0000b": ""}, "folders": []}',
        pytest.param('{"files": {}, "folders": ["/\\ud800"]}', marks=posix("names are UTF-16")),
    ],
)
def test_a_list_that_is_something_else(text: str) -> None:
    path = Ledger(for_all=False).path
    path.parent.mkdir()
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(Refusal, match="is not what `sistap install` writes"):
        Ledger(for_all=False)


@fifos
@pytest.mark.attack("a pipe in the place of a file of install, or of its list", "never waited for; a message names it")
@pytest.mark.timeout(20)
def test_pipes(place: Path) -> None:
    place.mkdir()
    os.mkfifo(place / "sis.lua")
    ledger = Ledger(for_all=False)
    assert ledger.put(place / "sis.lua", b"ours").startswith(f"kept     {place / 'sis.lua'}: ")
    ledger.path.parent.mkdir()
    os.mkfifo(ledger.path)
    with pytest.raises(Refusal, match="is not what `sistap install` writes"):
        Ledger(for_all=False)


def listed(*files: Path, folders: tuple[Path, ...] = (), at: Path | None = None) -> Path:
    """Write a list as an attacker could: with the right sums of the files."""
    path = at or Ledger(for_all=False).path
    path.parent.mkdir(parents=True, exist_ok=True)
    sums = {str(file): sha256(file.read_bytes()).hexdigest() for file in files}
    path.write_text(json.dumps({"files": sums, "folders": [str(folder) for folder in folders]}))
    return path


@pytest.mark.parametrize(
    "named",
    ["elsewhere/secret", "wireshark/../elsewhere/secret", pytest.param("wireshark/link/secret", marks=links)],
)
def test_nothing_outside_of_wiresharks_folders_is_removed(place: Path, own: Own, named: str) -> None:
    secret = place.parent / "elsewhere/secret"
    secret.parent.mkdir()
    secret.write_text("of root")
    place.mkdir()
    if not WINDOWS:
        (place / "link").symlink_to(secret.parent)
    path = listed(place.parent / named)
    ledger = Ledger(for_all=False)
    (file,) = ledger.files
    kept = f"kept {file}: {path} names it, but it is in none of the folders of `sistap install`"
    with pytest.raises(ElsewhereError, match=f"^{re.escape(kept)}"):
        ledger.remove(file, own)
    assert secret.exists()
    assert again(ledger).files == [file]


def test_no_folder_outside_of_them_is_removed(place: Path, own: Own) -> None:
    elsewhere = place.parent / "elsewhere"
    elsewhere.mkdir()
    path = listed(folders=(elsewhere,))
    (line,) = Ledger(for_all=False).remove_folders(own)
    assert line.startswith(f"kept     {elsewhere}: {path} names it, ")
    assert elsewhere.exists()


@links
def test_a_link_in_the_place_of_a_file_is_kept(place: Path, own: Own) -> None:
    place.mkdir()
    target, link = place.parent / "target", place / "sis.lua"
    target.write_text("the same")
    link.symlink_to(target)
    listed(link)
    ledger = Ledger(for_all=False)
    assert ledger.remove(link, own) == f"kept     {link}: it was changed since it was put there"
    assert target.exists() and link.is_symlink()


@links
def test_no_link_leads_to_another_file_while_one_is_written(place: Path) -> None:
    """Whoever may write to a folder can foresee a name made of the process number."""
    place.mkdir()
    victim = place.parent / "victim"
    victim.write_text("precious")
    ledger = Ledger(for_all=False)
    ledger.path.parent.mkdir(parents=True)
    for folder, name in ((place, "sis.so"), (ledger.path.parent, ledger.path.name)):
        (folder / f".{name}.{os.getpid()}").symlink_to(victim)
    ledger.put(place / "sis.so", b"new")
    ledger.save()
    assert victim.read_text() == "precious"


@pytest.fixture
def root(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Be root; return root's folder, which does not exist yet."""
    monkeypatch.setattr(os, "geteuid", lambda: 0, raising=False)
    monkeypatch.setattr(sistap.tap.terminal.state, "FOR_ROOT", tmp_path / "var/lib/sistap")
    return sistap.tap.terminal.state.FOR_ROOT


@no_root
def test_root_does_not_take_a_list_of_somebody_else(root: Path, state: Path, place: Path) -> None:
    """As `sudo -E` has it in its environment."""
    place.mkdir()
    (place / "sis.so").touch()
    old = listed(place / "sis.so", at=state / "sistap/installed-for-all.json")
    old.parent.chmod(0o777)
    ledger = Ledger(for_all=True)
    assert ledger.files == []
    ledger.put(place / "sistap", b"")
    ledger.save()
    assert tree(root) == {"installed-for-all.json"}
    assert old.exists()


@pytest.mark.attack(
    "as root: others can write to the folder of root's list of installed files", "refused; the message says what to do"
)
@no_root
@pytest.mark.parametrize("who", ["a folder for all", "a link", "a list for all"])
def test_a_folder_of_root_that_others_could_write_is_not_used(root: Path, tmp_path: Path, who: str) -> None:
    real = tmp_path / "elsewhere" if who == "a link" else root
    path = listed(at=real / "installed-for-all.json")
    root.parent.mkdir(parents=True, exist_ok=True)
    if who == "a link":
        root.symlink_to(real)
    else:
        (root if who == "a folder for all" else path).chmod(0o666 if who == "a list for all" else 0o777)
    with pytest.raises(StateError, match="is not used, because others than root could have written it: .*chmod go-w"):
        Ledger(for_all=True)
    if who != "a list for all":
        with pytest.raises(StateError):
            sistap.tap.terminal.state.save("selftest.json", b"")
