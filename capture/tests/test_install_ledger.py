# SPDX-License-Identifier: GPL-2.0-or-later
"""What was put where is remembered, and nobody else's file is touched."""

from pathlib import Path

import pytest

from sistap.install.ledger import Ledger, LedgerError


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "wireshark"


def again(ledger: Ledger) -> Ledger:
    """Read what was written, as the next run does."""
    ledger.save()
    return Ledger(for_all=False)


def tree(folder: Path) -> set[str]:
    return {str(file.relative_to(folder)) for file in folder.rglob("*")}


def test_all_that_was_put_is_removed_again(place: Path) -> None:
    before = tree(place.parent)
    ledger = Ledger(for_all=False)
    script, plugin = place / "extcap/sistap", place / "plugins/4.0/epan/sis.so"
    assert ledger.put(script, b"#!/bin/sh\n", executable=True) == f"put      {script}"
    assert ledger.put(plugin, b"\x7fELF") == f"put      {plugin}"
    assert (script.stat().st_mode & 0o777, plugin.stat().st_mode & 0o777) == (0o755, 0o644)
    ledger = again(ledger)
    assert ledger.files == [script, plugin]
    assert [ledger.remove(file) for file in ledger.files] == [f"removed  {script}", f"removed  {plugin}"]
    ledger.remove_folders()
    ledger.save()
    assert tree(place.parent) == before
    assert not ledger.path.parent.exists()


def test_folders_that_were_there_stay(place: Path) -> None:
    place.mkdir()
    ledger = Ledger(for_all=False)
    ledger.put(place / "extcap/sistap", b"")
    ledger = again(ledger)
    ledger.remove(place / "extcap/sistap")
    ledger.remove_folders()
    assert tree(place.parent) == {"wireshark"}


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


def test_what_somebody_has_changed_is_kept(place: Path) -> None:
    file = place / "preferences"
    ledger = Ledger(for_all=False)
    ledger.put(file, b"ours")
    file.write_bytes(b"theirs")
    ledger = again(ledger)
    assert ledger.put(file, b"newer").startswith(f"kept     {file}: ")
    assert ledger.remove(file) == f"kept     {file}: it was changed since it was put there"
    assert ledger.remove_folders() == [f"kept     {place}: others have put preferences there"]
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


def test_what_somebody_has_put_beside_it_is_kept(place: Path) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "SIS/preferences", b"")
    (place / "SIS/recent").touch()  # Wireshark, when the profile was used
    ledger.remove(place / "SIS/preferences")
    assert ledger.remove_folders() == [f"kept     {place / 'SIS'}: others have put recent there"]
    assert tree(place) == {"SIS", "SIS/recent"}


def test_what_is_gone_already_is_no_trouble(place: Path) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "a/sistap", b"")
    (place / "a/sistap").unlink()
    (place / "a").rmdir()
    assert ledger.remove(place / "a/sistap").startswith(f"gone     {place / 'a/sistap'}")
    assert ledger.remove_folders() == [f"removed  {place}"]


def test_a_file_that_cannot_be_written_leaves_the_old_one(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ledger = Ledger(for_all=False)
    ledger.put(place / "sis.so", b"old")

    def full(self: Path, data: bytes) -> int:
        self.touch()
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr(Path, "write_bytes", full)
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


@pytest.mark.parametrize("text", ["", "[]", '{"files": 1, "folders": []}', '{"files": {}}', "[" * 100_000, "\udcff"])
def test_a_list_that_is_something_else(text: str) -> None:
    path = Ledger(for_all=False).path
    path.parent.mkdir()
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(LedgerError, match="is not what `sistap install` writes"):
        Ledger(for_all=False)
