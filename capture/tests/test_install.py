# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall`: which dissector, what is said, and, with the real Wireshark, that it all works."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path

import pytest
from portable import WINDOWS, posix, unpackaged

import sisbus
import sistap.tap.terminal.state
from sistap import cli
from sistap.commands.install import command, shell, sources, turn, uninstall
from sistap.dissected.wireshark.tshark import NOBODY, TsharkError
from sistap.tap.terminal import rights
from sistap.tap.terminal.advice import advice, shell_word

REPOSITORY = Path(__file__).resolve().parents[2]
ON_PATH = os.environ.get("PATH", os.defpath)
VERSION = "TShark (Wireshark) 4.0.17 (Git v4.0.17 packaged as 4.0.17-0+deb12u3).\n"

no_root = posix("there is no root")


class FakeTshark:
    """A Wireshark 4.0 whose folders are in `root`; it loads what lies in its plugin folders."""

    root = Path()
    version = VERSION
    complaint = ""

    def __init__(self, *, drop_rights: bool = True) -> None: ...

    def __enter__(self) -> "FakeTshark":
        return self

    def __exit__(self, *error: object) -> None: ...

    def answer(self, *arguments: str) -> str:
        if arguments == ("--version",):
            return self.version
        assert arguments == ("-G", "folders")
        return "".join(
            f"{kind} {name}:\t{self.root}/{kind}/{below}\n"
            for kind in ("Personal", "Global")
            for name, below in {
                "Plugins": "plugins/4.0",
                "Lua Plugins": "plugins",
                "Extcap path": "extcap",
                "configuration": "wireshark",
            }.items()
        )

    def ask(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        assert arguments == ("-G", "plugins")
        found = [] if self.complaint else [*self.root.rglob("sis.so"), *self.root.rglob("sis.lua")]
        listed = "".join(f"{file.name}\t0.1.0\tdissector\t{file}\n" for file in found)
        return subprocess.CompletedProcess(arguments, 0, listed, self.complaint)


@pytest.fixture(autouse=True)
def root(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The folders of a Wireshark, with a home; no plugin is here, and the user is an ordinary one."""
    FakeTshark.root = tmp_path / "wireshark"
    monkeypatch.setenv("HOME", str(FakeTshark.root / "home"))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setattr(shell, "FOR_ALL", FakeTshark.root / "usr/local")
    on_path = [FakeTshark.root / "home/.local/bin", FakeTshark.root / "usr/local/bin"]  # not /usr/bin: a package
    monkeypatch.setenv("PATH", os.pathsep.join(map(str, on_path)))
    checkout = tmp_path / "checkout"
    (checkout / "capture/sistap").mkdir(parents=True)
    (checkout / "lua-fallback").mkdir()
    (checkout / "lua-fallback/sis.lua").write_text("-- the script\n")
    shutil.copytree(sources.PACKAGE / "profile", checkout / "capture/sistap/profile")
    monkeypatch.setattr(sources, "PACKAGE", checkout / "capture/sistap")
    monkeypatch.setattr(command, "Tshark", FakeTshark)
    monkeypatch.setattr(FakeTshark, "version", VERSION)
    monkeypatch.setattr(command, "WINDOWS", False)
    become(monkeypatch, 1000)
    return FakeTshark.root


def become(monkeypatch: pytest.MonkeyPatch, user: int) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: user, raising=False)


def build(folder: Path, minor: int) -> Path:
    """Make a plugin for Wireshark 4.`minor`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "sis.version").write_text(f"4.{minor}.6\n")
    (folder / "sis.so").write_text(f"a plugin for 4.{minor}: plugin_want_major")
    return folder / "sis.so"


def builds() -> Path:
    return sources.PACKAGE.parents[1] / "build"


Said = tuple[int, str, str]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Run sistap; return exit code, stdout and stderr."""

    def run(*arguments: str) -> Said:
        code = cli.main(arguments)
        return code, *capfd.readouterr()

    return run


Run = Callable[..., Said]
PROFILE = {f"wireshark/profiles/SIS/{file.name}" for file in sources.profile()}


SHELL = {"bin/sistap", "share/bash-completion/completions/sistap", "share/zsh/site-functions/_sistap"}
OF_THE_USER = {f"home/.local/{name}" for name in SHELL}


def files(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


@posix("the command is for another shell there")
def test_without_a_build_the_script(root: Path, run: Run) -> None:
    code, out, err = run("install")
    assert (code, err) == (0, "")
    assert files(root / "Personal") == {"plugins/sis.lua", "extcap/sistap"} | PROFILE
    assert files(root) == {f"Personal/{name}" for name in files(root / "Personal")} | OF_THE_USER
    assert out.startswith("Wireshark 4.0.17, for this user\n")
    assert out.endswith(f"Wireshark loads sis.lua 0.1.0; {advice().started}\n")
    assert all(f"put      {root / 'Personal' / name}\n" in out for name in files(root / "Personal"))


def test_the_launcher_names_interpreter_and_package(root: Path, run: Run) -> None:
    run("install")
    launcher = root / "Personal/extcap/sistap"
    assert WINDOWS or launcher.stat().st_mode & 0o111 == 0o111
    assert sys.executable in launcher.read_text()
    assert str(sources.PACKAGE.parent) in launcher.read_text()


def test_windows_gets_a_batch_file(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "WINDOWS", True)
    assert run("install")[0] == 0
    assert b"\r\n" in (root / "Personal/extcap/sistap.bat").read_bytes()
    assert not (root / "Personal/extcap/sistap").exists()


def test_windows_gets_the_program_where_it_was_built(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "WINDOWS", True)
    run("install")
    program = builds() / "windows/sistap.exe"
    program.parent.mkdir(parents=True)
    program.write_bytes(b"MZ")
    assert run("install")[0] == 0
    assert files(root / "Personal/extcap") == {"sistap.exe", "sistap.cfg"}  # the .bat is taken away
    assert (root / "Personal/extcap/sistap.exe").read_bytes() == b"MZ"
    lines = (root / "Personal/extcap/sistap.cfg").read_text().splitlines()
    assert lines == [sys.executable, str(sources.PACKAGE.parent)]
    assert run("uninstall")[0] == 0
    assert not (root / "Personal/extcap").exists()


def test_windows_takes_no_build_of_linux(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "WINDOWS", True)
    build(builds() / "plugin/plugin", 0)
    code, out, _ = run("install")
    assert code == 0
    assert "Wireshark loads sis.lua" in out
    assert not (root / "Personal/plugins/4.0").exists()


def test_the_newest_build_that_fits(root: Path, run: Run) -> None:
    old, new = build(builds() / "one/plugin", 0), build(builds() / "two/plugin", 0)
    with new.open("ab") as file:
        file.write(b"newer")
    os.utime(old, (1, 1))
    code, out, err = run("install")
    assert (code, err) == (0, "")
    assert (root / "Personal/plugins/4.0/epan/sis.so").read_bytes() == new.read_bytes()
    assert not (root / "Personal/plugins/sis.lua").exists()
    assert "Wireshark loads sis.so" in out


def test_a_build_for_another_wireshark_is_refused_with_the_cure(root: Path, run: Run) -> None:
    other = build(builds() / "plugin/plugin", 4)
    code, _, err = run("install")
    assert code == 0
    assert err.startswith(f"sistap: {other} was built for Wireshark 4.4, this is 4.0.17: `cmake -S . -B build/plugin")
    assert err.endswith("; sis.lua takes its place\n")
    assert err.count("\n") == 1
    assert "Personal/plugins/sis.lua" in files(root)
    assert not list(root.rglob("sis.so"))


def test_a_named_plugin_goes_before_builds(root: Path, run: Run, tmp_path: Path) -> None:
    build(builds() / "plugin/plugin", 0)
    named = build(tmp_path / "elsewhere", 0)
    with named.open("ab") as file:
        file.write(b"this one")
    named = named.rename(named.with_name("sis-4.0.so"))
    assert run("install", "--plugin", str(named))[0] == 0
    assert (root / "Personal/plugins/4.0/epan/sis.so").read_bytes() == named.read_bytes()


def test_a_named_plugin_for_another_wireshark(root: Path, run: Run, tmp_path: Path) -> None:
    named = build(tmp_path / "elsewhere", 6)
    code, _, err = run("install", "--plugin", str(named))
    assert code == 0
    assert "was built for Wireshark 4.6, this is 4.0.17" in err
    assert "Personal/plugins/sis.lua" in files(root)


def test_what_is_no_plugin_is_wrong_usage(root: Path, run: Run, tmp_path: Path) -> None:
    (tmp_path / "text.so").write_text("hello")
    code, _, err = run("install", "--plugin", str(tmp_path / "text.so"))
    assert (code, err.count("\n")) == (2, 1)
    assert not root.exists()
    with pytest.raises(SystemExit, match="2"):
        run("install", "--plugin", str(tmp_path / "missing.so"))


def test_the_plugin_takes_the_place_of_the_script_and_back(root: Path, run: Run) -> None:
    run("install")
    build(builds() / "plugin/plugin", 0)
    _, out, _ = run("install")
    assert f"removed  {root / 'Personal/plugins/sis.lua'}\n" in out
    assert "Personal/plugins/4.0/epan/sis.so" in files(root)
    _, out, _ = run("install", "--lua")
    assert f"removed  {root / 'Personal/plugins/4.0/epan/sis.so'}\n" in out
    assert "Personal/plugins/sis.lua" in files(root)
    assert not (root / "Personal/plugins/4.0").exists()


@posix("the command is for another shell there")
def test_again_changes_nothing(root: Path, run: Run) -> None:
    run("install")
    before = {file: file.stat().st_mtime_ns for file in root.rglob("*")}
    code, out, err = run("install")
    assert (code, err) == (0, "")
    assert all(line.startswith("same ") for line in out.splitlines()[1:-1])
    assert {file: file.stat().st_mtime_ns for file in root.rglob("*")} == before


def test_uninstall_leaves_nothing(root: Path, run: Run, tmp_path: Path) -> None:
    before = files(tmp_path)
    run("install")
    installed = files(root)
    measured = sistap.tap.terminal.state.save("selftest.json", b"")
    code, out, err = run("uninstall")
    assert (code, err) == (0, "")
    assert all(f"removed  {root / name}\n" in out for name in installed)
    assert files(tmp_path) == before
    assert not root.exists()
    assert not measured.parent.exists()
    assert run("uninstall") == (0, "nothing to remove: nothing was installed for this user\n", "")


def test_uninstall_names_what_wireshark_has_written_anew(root: Path, run: Run) -> None:
    """As 4.0 does when somebody closes its preferences with OK. Other profiles and settings are no matter of ours."""
    run("install")
    wireshark = root / "Personal/wireshark"
    kept = {"preferences", "profiles/SIS/decode_as_entries", "profiles/SIS/preferences", "profiles/Mine/preferences"}
    for name in kept:
        (wireshark / name).parent.mkdir(exist_ok=True)
        (wireshark / name).write_text("# as Wireshark writes it\n")
    rest = f"the rest of the profile was changed by Wireshark or by you: {advice().remove}\n"
    rest = rest.format(folder=shell_word(str(wireshark / "profiles/SIS")))
    code, out, err = run("uninstall")
    assert (code, err) == (0, "") and out.endswith(rest)
    assert files(root) == {f"Personal/wireshark/{name}" for name in kept}
    assert run("uninstall") == (0, "nothing to remove: nothing was installed for this user\n", "")


@posix("Windows has no such package")
def test_uninstall_names_the_package(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uninstall, "OF_PACKAGE", Path(uninstall.__file__).parent)
    monkeypatch.setattr(rights, "needs_sudo", lambda: True)
    run("install")
    for said in (run("uninstall"), run("uninstall")):
        assert said[1].endswith("`sudo apt-get remove sistap` removes the Debian package\n")


def test_uninstall_goes_on_after_what_cannot_be_removed(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    run("install")
    launcher = root / "Personal/extcap/sistap"
    unlink = Path.unlink

    def refuse(self: Path, missing_ok: bool = False) -> None:
        if self == launcher:
            raise PermissionError(13, "Permission denied", str(self))
        unlink(self, missing_ok)

    with monkeypatch.context() as refusing:
        refusing.setattr(Path, "unlink", refuse)
        code, _, err = run("uninstall")
    refusal = (
        f"{launcher} stays as it is: {advice().held}" if WINDOWS else f"[Errno 13] Permission denied: '{launcher}'"
    )
    assert (code, err) == (1, f"sistap: {refusal}\n")
    assert files(root) == {"Personal/extcap/sistap"}
    assert run("uninstall")[0] == 0
    assert not root.exists()


def test_what_was_put_when_signals_come_is_on_the_list(
    root: Path, run: Run, state: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = sistap.tap.terminal.state.replace
    counts = iter(range(100))

    def interrupted(file: Path, content: bytes, *, executable: bool = False) -> None:
        replace(file, content, executable=executable)
        if next(counts) == 3:
            for number in (signal.SIGINT, signal.SIGTERM) * 15:
                signal.raise_signal(number)

    monkeypatch.setattr(sistap.tap.terminal.state, "replace", interrupted)
    code, out, _ = run("install")
    (listed,) = state.rglob("*.json")
    assert code == 0
    assert {str(root / name) for name in files(root)} == set(json.loads(listed.read_text())["files"])
    assert out.count("\nput ") == len(files(root))


def test_uninstall_leaves_what_a_list_names_elsewhere(root: Path, run: Run, state: Path, tmp_path: Path) -> None:
    run("install")
    secret = tmp_path / "secret"
    secret.write_text("of somebody")
    lists = [*state.rglob("*.json")]
    named = json.loads(lists[0].read_text())
    named["files"][str(secret)] = sha256(secret.read_bytes()).hexdigest()
    lists[0].write_text(json.dumps(named))
    for _ in range(2):
        code, _, err = run("uninstall")
        assert (code, err.count("\n")) == (1, 1)
        assert err.startswith(
            f"sistap: kept {secret}: {lists[0]} names it, but it is in none of the folders of `sistap install`"
        )
    assert secret.exists()
    assert not root.exists()
    assert f"kept {secret}: " in run("install")[1]
    assert secret.exists()


@no_root
def test_root_believes_no_list_that_an_environment_names(
    root: Path, run: Run, state: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`sudo -E` has the environment of an ordinary user."""
    run("install")
    (state / "sistap/installed.json").rename(state / "sistap/installed-for-all.json")
    (state / "sistap").chmod(0o777)
    before = files(root)
    become(monkeypatch, 0)
    monkeypatch.setattr(sistap.tap.terminal.state, "FOR_ROOT", tmp_path / "var/lib/sistap")
    assert run("uninstall")[:2] == (0, "nothing to remove: nothing was installed for all users\n")
    assert files(root) == before


def test_uninstall_without_wireshark(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    run("install")
    before = files(root)

    def missing(*, drop_rights: bool) -> None:
        raise TsharkError("tshark is not on PATH")

    monkeypatch.setattr(command, "Tshark", missing)
    said = "sistap: nothing is removed, as only tshark knows which folders are Wireshark's: tshark is not on PATH\n"
    assert run("uninstall") == (1, "", said)
    assert files(root) == before


def test_nobody_waits_while_uninstall_asks_tshark(run: Run, state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A slow disk needs some seconds for all plugins."""
    run("install")
    real, locks = FakeTshark.answer, []

    def answer(self: FakeTshark, *arguments: str) -> str:
        locks.append((state / "sistap" / turn.NAME).exists())
        return real(self, *arguments)

    monkeypatch.setattr(FakeTshark, "answer", answer)
    assert run("uninstall")[0] == 0
    assert locks == [False]


@no_root
def test_root_installs_for_all(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """As root, Wireshark silently skips personal plugins."""
    become(monkeypatch, 0)
    code, out, _ = run("install")
    assert code == 0
    assert out.startswith("Wireshark 4.0.17, for all users: run as root, it skips what is in personal folders\n")
    of_all = {f"usr/local/{name}" for name in SHELL}
    assert files(root) == {f"Global/{name}" for name in {"plugins/sis.lua", "extcap/sistap"} | PROFILE} | of_all
    become(monkeypatch, 1000)
    assert run("uninstall")[1].startswith("nothing to remove")
    become(monkeypatch, 0)
    assert run("uninstall")[0] == 0
    assert not root.exists()


@no_root
def test_root_hears_that_others_cannot_enter(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    become(monkeypatch, 0)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(sources.PACKAGE.parents[1], folder, dirs_exist_ok=True)
        monkeypatch.setattr(sources, "PACKAGE", Path(folder, "capture/sistap"))
        for path in (Path(folder), *Path(folder).rglob("*")):
            path.chmod(0o755)
        assert run("install")[2] == ""
        Path(folder).chmod(0o700)
        code, _, err = run("install")
    assert code == 0
    assert err.startswith(f"sistap: other users get no serial ports in Wireshark, as they may not enter {folder}: ")


@no_root
def test_what_all_users_have_is_not_put_a_second_time(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    become(monkeypatch, 0)
    run("install")
    become(monkeypatch, 1000)
    code, out, _ = run("install")
    assert code == 0
    assert not (root / "Personal").exists()
    assert not (root / "home").exists()
    assert f"same     {root}/Global/extcap/sistap: all users have it\n" in out
    assert f"kept     {root}/usr/local/bin/sistap: the command sistap is there already" in out
    assert f"kept     {root}/Global/plugins/sis.lua: Wireshark loads it, " in out


def test_an_old_wireshark(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeTshark, "version", "TShark (Wireshark) 3.6.2 (Git)\n")
    assert run("install") == (1, "", "sistap: Wireshark 3.6.2 is too old: install 4.0 or later\n")
    assert not root.exists()


def test_no_wireshark(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*, drop_rights: bool) -> None:
        raise TsharkError("tshark is not on PATH")

    monkeypatch.setattr(command, "Tshark", missing)
    assert run("install") == (1, "", "sistap: tshark is not on PATH\n")


def test_what_cannot_be_written_is_one_line_and_what_was_put_is_remembered(root: Path, run: Run) -> None:
    (root / "Personal").mkdir(parents=True)
    (root / "Personal/wireshark").touch()  # a file where a folder has to be
    code, _, err = run("install")
    assert (code, err.count("\n")) == (1, 1)
    assert str(root / "Personal/wireshark") in err.replace("\\\\", "\\")
    assert run("uninstall")[0] == 0
    assert files(root) == {"Personal/wireshark"}


@posix("its home has another variable")
@pytest.mark.parametrize("home", ["", "somewhere"])
def test_a_relative_home_is_refused(
    root: Path, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, home: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", home)
    monkeypatch.delenv("XDG_STATE_HOME")
    before = files(tmp_path)
    for words in ("install", "uninstall"):
        assert run(words) == (
            1,
            "",
            f"sistap: HOME is {home!r}, which is no absolute path: set it to your home folder\n",
        )
    assert files(tmp_path) == before


def test_wireshark_that_does_not_load_it(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeTshark, "complaint", "some\nsis.lua:7: no\n")
    code, _, err = run("install")
    assert (code, err) == (1, "sistap: Wireshark does not load the dissector: sis.lua:7: no\n")


def test_an_environment_that_names_another_folder(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeTshark, "complaint", "some\n")
    monkeypatch.setenv("WIRESHARK_PLUGIN_DIR", "/elsewhere")
    code, _, err = run("install")
    assert code == 1
    assert err.endswith("WIRESHARK_PLUGIN_DIR is set, so it looks in /elsewhere alone; unset it\n")


def test_a_package_without_the_script(run: Run) -> None:
    sources.lua().unlink()
    code, _, err = run("install")
    assert (code, err.count("\n")) == (1, 1)
    assert "sis.lua is missing" in err


def test_a_module_for_nobody_knows_what_is_no_reason_to_stop(root: Path, run: Run) -> None:
    (builds() / "plugin").mkdir(parents=True)
    for version in (None, b"", b"4", b"four.two", b"\xff.\xff"):
        (builds() / "plugin/sis.so").write_bytes(b"a module")
        if version is not None:
            (builds() / "plugin/sis.version").write_bytes(version)
        code, _, err = run("install")
        assert (code, err.count("\n")) == (0, 1)
        assert f"{Path('plugin/sis.so')} has no sis.version beside it" in err
        assert "Personal/plugins/sis.lua" in files(root)


def test_what_is_no_plugin_is_not_installed(root: Path, run: Run) -> None:
    """Named, it is refused. Of a build that went wrong, sis.lua takes the place."""
    module = build(builds() / "plugin", 0)
    module.write_bytes(b"junk")
    code, _, err = run("install", "--plugin", str(module))
    assert (code, err) == (2, f"sistap: {module} is no plugin of Wireshark: build it again\n")
    assert "Personal/plugins/4.0/epan/sis.so" not in files(root)
    code, _, err = run("install")
    assert (code, "is no plugin of Wireshark" in err) == (0, True)
    assert "Personal/plugins/sis.lua" in files(root)


def test_the_script_never_takes_the_place_of_a_plugin_that_works(root: Path, run: Run) -> None:
    plugin = root / "Personal/plugins/4.0/epan/sis.so"
    build(builds() / "plugin/plugin", 0)
    run("install")
    content = plugin.read_bytes()
    shutil.rmtree(builds())
    other = build(builds() / "plugin/plugin", 4)
    for arguments in ((), ("--plugin", str(other))):
        code, out, err = run("install", *arguments)
        assert (code, plugin.read_bytes()) == (0, content)
        assert f"kept     {plugin}: Wireshark loads it" in out
        assert "`sistap install --lua` takes sis.lua" in out
        assert err.endswith(f"; {plugin} stays\n")
        assert "Personal/plugins/sis.lua" not in files(root)
        assert "Wireshark loads sis.so" in out
    run("uninstall")
    assert not root.exists() or not files(root)


def test_a_plugin_that_wireshark_does_not_load_gives_way_to_the_script(
    root: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    build(builds() / "plugin/plugin", 0)
    run("install")
    shutil.rmtree(builds())
    with monkeypatch.context() as later:
        later.setattr(FakeTshark, "complaint", "sis.so was built for another one\n")
        run("install")
    assert "Personal/plugins/sis.lua" in files(root)
    assert not list(root.rglob("sis.so"))


def test_plugin_or_script_not_both(run: Run, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="2"):
        run("install", "--lua", "--plugin", str(build(tmp_path, 0)))


@posix("the command is for another shell there")
def test_the_command_runs_this_package(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "PACKAGE", REPOSITORY / "capture/sistap")
    run("install", "--lua")
    done = subprocess.run(["sistap", "--version"], cwd="/", capture_output=True, text=True, check=True)
    assert done.stdout == f"sistap {sistap.__version__}\n"
    assert shutil.which("sistap") == str(root / "home/.local/bin/sistap")


@posix("the command is for another shell there")
def test_the_cure_where_the_command_is_not_on_path(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(root / "bin"))
    code, _, err = run("install")
    place = root / "home/.local/bin"
    assert (code, err.count("\n")) == (0, 1)
    assert err.startswith(f'sistap: {place} is not in PATH: `export PATH={place}:"$PATH"`')


@posix("the cure is a command of a shell")
@pytest.mark.attack("the name of a home has a command of a shell in it", "the cure for PATH quotes it")
def test_the_cure_for_path_runs_nothing(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    home = root / "a 'b\"$(touch ran);`touch ran`"
    monkeypatch.setenv("HOME", str(home))
    cure = run("install")[2].partition("is not in PATH: `")[2].rpartition("`, also")[0]
    script = f"cd {tmp_path}; {cure}; echo $PATH"
    said = subprocess.run(["/bin/sh", "-c", script], capture_output=True, text=True, check=True).stdout
    assert said.startswith(f"{home}/.local/bin:")
    assert not (tmp_path / "ran").exists()


def test_windows_gets_a_command_and_words(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "WINDOWS", True)
    monkeypatch.setenv("LOCALAPPDATA", str(root / "local"))
    monkeypatch.setattr(command, "advice", lambda: advice("win32"))
    code, _, err = run("install")
    assert code == 0
    assert "Environment Variables > Path" in err
    assert b"-P -X utf8 -m sistap %*\r\n" in (root / "local/Programs/sistap/sistap.bat").read_bytes()
    assert not (root / "home").exists()
    run("uninstall")
    assert not root.exists()


def test_the_bundle_has_the_command_itself(root: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    python = root.parent / "bundle/python/python.exe"
    python.parent.mkdir(parents=True)
    python.with_name("python314._pth").touch()
    monkeypatch.setattr(sys, "executable", str(python))
    monkeypatch.setattr(command, "WINDOWS", True)
    monkeypatch.setenv("LOCALAPPDATA", str(root / "local"))
    code, _, err = run("install")
    assert (code, err) == (0, "")
    assert not (root / "local/Programs").exists()


@posix("the command is for another shell there")
@pytest.mark.parametrize("where", ["home/.local/bin", "usr/local/bin"])
def test_a_command_of_somebody_else_is_kept(root: Path, run: Run, where: str) -> None:
    foreign = root / where / "sistap"
    foreign.parent.mkdir(parents=True)
    foreign.write_text("#!/bin/sh\n")
    foreign.chmod(0o755)
    code, out, err = run("install")
    assert (code, err) == (0, "")
    assert f"kept     {foreign}: the command sistap is there already" in out
    assert foreign.read_text() == "#!/bin/sh\n"
    assert files(root) & (OF_THE_USER | {f"{where}/sistap"}) == {f"{where}/sistap"}
    run("uninstall")
    assert files(root) == {f"{where}/sistap"}


@posix("the command is for another shell there")
def test_what_is_no_command_is_not_replaced_either(root: Path, run: Run) -> None:
    """A shell does not find it, because it is not executable; and a link must not lead elsewhere."""
    notes = root / "home/notes"
    link = root / "home/.local/bin/sistap"
    link.parent.mkdir(parents=True)
    notes.write_text("mine")
    link.symlink_to(notes)
    assert f"kept     {link}: " in run("install")[1]
    assert (link.is_symlink(), notes.read_text()) == (True, "mine")


@posix("the command is for another shell there")
def test_the_command_of_an_active_environment_does_not_count(
    root: Path, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It goes away with the environment."""
    program = tmp_path / "environment/bin/sistap"
    program.parent.mkdir(parents=True)
    program.touch(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "environment"))
    run("install")
    assert files(root) >= OF_THE_USER


@posix("files have no owner")
def test_root_hears_that_others_can_change_what_all_run(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(sources.PACKAGE.parents[1], folder, dirs_exist_ok=True)
        monkeypatch.setattr(sources, "PACKAGE", Path(folder, "capture/sistap"))
        for path in (Path(folder), *Path(folder).rglob("*")):
            path.chmod(0o755)
        become(monkeypatch, 0)
        assert run("install")[2] == ""
        for path in (Path(folder, "capture"), sources.PACKAGE / "profile/SIS/colorfilters"):
            path.chmod(0o777)
            code, _, err = run("install")
            assert (code, err.count("\n")) == (0, 1)
            assert err.startswith("sistap: others than root can write ")
            assert "install the .deb" in err
            path.chmod(0o755)
        become(monkeypatch, 1000)
        Path(folder, "capture").chmod(0o777)
        assert run("install")[2] == ""


# From here on the real Wireshark, run by an ordinary user with an empty home.


@pytest.fixture
def home() -> Iterator[Path]:
    """A home, and in it a copy of sistap, that an ordinary user may enter; no plugin is built there."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        path.chmod(0o755)
        for package in (sistap, sisbus):
            place = path / "checkout/capture" / package.__name__
            shutil.copytree(package.__path__[0], place, ignore=shutil.ignore_patterns("__pycache__"))
        (path / "checkout/lua-fallback").mkdir()
        shutil.copy(REPOSITORY / "lua-fallback/sis.lua", path / "checkout/lua-fallback")
        (path / "home").mkdir()
        if os.getuid() == 0:
            os.chown(path / "home", NOBODY, NOBODY)
        yield path


def as_user(home: Path, *arguments: str | Path) -> str:
    """Run a command in that home; return its stdout. It must succeed, and print nothing else."""
    nobody = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.getuid() == 0 else {}
    path = f"{home}/home/.local/bin:{ON_PATH}"
    environment = {"PATH": path, "HOME": str(home / "home"), "PYTHONDONTWRITEBYTECODE": "1"}
    folder = home / "checkout/capture"
    done: subprocess.CompletedProcess[str] = subprocess.run(  # type: ignore[call-overload]
        arguments, check=False, capture_output=True, text=True, cwd=folder, env=environment, **nobody
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def in_wireshark(home: Path) -> list[str]:
    """Return the columns of figure 6-14, sets 9600 Bd, as the profile has them."""
    capture = home / "capture.pcapng"
    shutil.copy(REPOSITORY / "test-captures/specification.pcapng", capture)
    row = as_user(home, "tshark", "-C", "SIS", "-r", capture, "-Y", "frame.number == 7", "-T", "tabs")
    return [column.strip() for column in row.rstrip("\n").split("\t")]


# The interpreter below the virtual environment: everybody may run it.
SISTAP = (Path(sys.base_prefix) / "bin/python3", "-m", "sistap")


@posix("no Wireshark for Windows is here")
@unpackaged
@pytest.mark.parametrize("kind", ["sis.so", pytest.param("sis.lua", marks=pytest.mark.thorough)])
def test_from_a_read_only_checkout_into_wireshark_and_out_again(home: Path, kind: str) -> None:
    arguments: tuple[str | Path, ...] = ()
    if kind == "sis.so":
        module = next(Path(os.environ["WIRESHARK_PLUGIN_DIR"]).rglob("sis.so"))  # of FOLDER/4.0/epan
        (home / "sis.version").write_text(f"{module.parents[1].name}.0\n")
        arguments = ("--plugin", shutil.copy(module, home))
    said = as_user(home, *SISTAP, "install", *arguments)
    assert f"\nWireshark loads {kind}" in said
    row = in_wireshark(home)
    assert row[2] == "16 -> 3  Command  Set baud rate: 9600"
    as_user(home, *SISTAP, "uninstall")
    assert not [file for file in (home / "home").rglob("*") if file.is_file()]
    assert not (home / "home/.local/lib").exists()
