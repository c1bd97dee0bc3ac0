# SPDX-License-Identifier: GPL-2.0-or-later
"""The profile SIS in a user's folder: it follows the version of sistap, and what the user has changed stays his."""

import os
import shutil
from collections import namedtuple
from hashlib import sha256
from pathlib import Path

import pytest
from portable import WINDOWS, posix

from sistap.commands import doctor
from sistap.commands.install import homes, personal, sources
from sistap.dissected.wireshark import profile
from sistap.tap.terminal.advice import shell_word

OF_VERSION = {file.name: file.read_bytes() for file in sources.profile()}
EARLIER = b"# of an earlier version\n"
MINE = b"# mine\n"
LIST = profile._installed()

# As Wireshark 4.4 writes it.
WIDTHS = """\
gui.zoom_level: 3
column.width:
        %m, 40,
        "%Cus:sis.value", 80,
        %i, 99
gui.conversation_tabs:
	"SIS"
"""


@pytest.fixture(autouse=True)
def _earlier(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profile, "_installed", lambda: LIST | {sha256(EARLIER).hexdigest()})


@pytest.fixture
def configuration(tmp_path: Path) -> Path:
    """A user's folder of Wireshark, in which Wireshark has copied the profile of an earlier version, and then ended."""
    copy = tmp_path / ".config/wireshark/profiles/SIS"
    copy.mkdir(parents=True)
    for name in ("colorfilters", "preferences", "no-longer-there"):
        (copy / name).write_bytes(EARLIER)
    (copy / "recent").write_bytes(WIDTHS.encode())
    common = "# common\ngui.last_used_profile: SIS\nprivs.warn_if_elevated: true\n"
    (tmp_path / ".config/wireshark/recent_common").write_text(common)
    return tmp_path / ".config/wireshark"


def contents(copy: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in copy.iterdir()}


def rest(copy: Path) -> str:
    cure = f"delete {shell_word(str(copy))} to remove it" if WINDOWS else f"`rm -r {shell_word(str(copy))}` removes it"
    return f"the rest of the profile was changed by Wireshark or by you: {cure}"


def test_every_file_of_this_version_is_on_the_list() -> None:
    """Add the line that `sha256sum profile/SIS/*` prints after a change, and keep the old one."""
    assert [name for name, content in OF_VERSION.items() if sha256(content).hexdigest() not in LIST] == []


def test_a_copy_of_an_earlier_version_is_renewed(configuration: Path) -> None:
    copy = configuration / "profiles/SIS"
    lines = list(personal.renew(configuration))
    found = contents(copy)
    recent = found.pop("recent").decode()
    found.pop("no-longer-there")
    assert found == {name: content for name, content in OF_VERSION.items() if name != "recent"}
    assert f"renewed  {copy / 'colorfilters'}" in lines
    assert recent.startswith("gui.zoom_level: 3\n")
    assert '\t"SIS"\n' in recent
    assert '\t"%i", 500,\n' in recent
    assert "99" not in recent
    assert list(personal.renew(configuration)) == []


def test_what_the_user_has_changed_stays_and_is_told(configuration: Path) -> None:
    copy = configuration / "profiles/SIS"
    for name in ("colorfilters", "preferences"):
        (copy / name).write_bytes(MINE)
    lines = list(personal.renew(configuration))
    assert [contents(copy)[name] for name in ("colorfilters", "preferences")] == [MINE, MINE]
    assert contents(copy)["recent"].decode() == WIDTHS  # of the user's own columns
    assert [line.split(": ")[0] for line in lines if line.startswith("kept")] == [
        f"kept     {copy / name}" for name in ("colorfilters", "preferences")
    ]


def test_widths_of_the_same_columns_stay() -> None:
    of_version = OF_VERSION["recent"].decode()
    wider = of_version.replace("500", "900").replace('"%m"', "%m")
    assert profile.with_widths(wider, of_version) == wider
    of_windows = WIDTHS.replace("\n", "\r\n")
    assert profile.with_widths(of_windows, of_windows.replace("99", "98")) == of_windows
    assert "99" not in profile.with_widths(of_windows, of_version)
    assert profile.with_widths("gui.zoom_level: 3\n", of_version).count("column.width") == 1


def test_removed_it_leaves_nothing_and_wireshark_begins_with_another_profile(configuration: Path) -> None:
    """Its colours would complain of fields that nobody knows any more."""
    list(personal.remove(configuration))
    assert not (configuration / "profiles/SIS").exists()
    assert (configuration / "recent_common").read_text() == "# common\nprivs.warn_if_elevated: true\n"


def test_removed_it_leaves_what_the_user_has_changed(configuration: Path) -> None:
    copy = configuration / "profiles/SIS"
    (copy / "colorfilters").write_bytes(MINE)
    lines = list(personal.remove(configuration))
    assert contents(copy) == {"colorfilters": MINE, "recent": WIDTHS.encode()}
    assert lines[-2:] == [f"kept     {copy}: it still has colorfilters, recent", rest(copy)]
    assert "gui.last_used_profile" not in (configuration / "recent_common").read_text()


def test_a_user_without_the_profile_gets_none(tmp_path: Path, state: Path) -> None:
    for act in (personal.renew, personal.remove):
        assert list(act(tmp_path)) == []
    assert [*tmp_path.iterdir(), *state.iterdir()] == []


User = namedtuple("User", "pw_name pw_uid pw_gid pw_dir")


@posix("Windows has no such package")
def test_the_package_acts_for_every_user(
    configuration: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    import pwd

    users = [User("me", 0, 0, str(tmp_path)), User("daemon", 2, 2, str(tmp_path)), User("none", 0, 0, "/nowhere")]
    monkeypatch.setattr(pwd, "getpwall", lambda: users)
    monkeypatch.setattr(os, "initgroups", lambda *_: None)
    homes.main("renew")
    assert capfd.readouterr().out.count(f"renewed  {configuration}/profiles/SIS/colorfilters") == 1
    homes.main("remove")
    assert not (configuration / "profiles/SIS").exists()


def test_doctor_says_what_is_outdated_and_what_is_yours(configuration: Path, tmp_path: Path) -> None:
    own, everybodys = configuration / "profiles/SIS", tmp_path / "global/SIS"
    said = str(doctor._profile(own, everybodys))
    assert said.startswith(f"poor  profile    of another version of sistap in {own}: colorfilters, dfilter_buttons, ")
    list(personal.renew(configuration))
    assert str(doctor._profile(own, everybodys)) == "good  profile    SIS"
    (own / "colorfilters").write_bytes(MINE)
    said = str(doctor._profile(own, everybodys))
    assert said == "good  profile    SIS; changed by you, so an update leaves them: colorfilters"
    shutil.rmtree(own)
    assert "`sistap install` puts it there" in str(doctor._profile(own, everybodys))
    everybodys.mkdir(parents=True)
    assert str(doctor._profile(own, everybodys)) == "good  profile    SIS, for all users"
