# SPDX-License-Identifier: GPL-2.0-or-later
"""The bundle for Windows: what is in it, the same bytes each time; sis.dll, where it is built: imports and exports."""

import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from sistap import __version__
from sistap.cli import COMMANDS

CHECKOUT = Path(__file__).resolve().parents[2]
BUNDLE = CHECKOUT / "capture/bundle"
sys.path.insert(0, str(BUNDLE))

import contents  # noqa: E402 - beside build

# What each Wireshark imports of a profile: the names that it asks for when it starts. Those from 4.4 on ask for
# dfilter_macros only to make dmacros of it.
IMPORTED = {"colorfilters", "dfilter_buttons", "dfilter_macros", "io_graphs", "preferences", "recent"}

DOWNLOADED = (
    "python/python.exe python/python3.dll python/python314.dll python/lib/os.py python/lib/encodings/utf_8.py "
    "python/lib/_socket.pyd python/lib/_ssl.pyd python/lib/libcrypto-3.dll python/lib/vcruntime140.dll "
    "python/lib/libffi-8.dll python/lib/test/test_os.py python/lib/tkinter/__init__.py "
    "python/lib/encodings/__pycache__/x.pyc wheel/serial/__init__.py "
    "python/lib/pyexpat.pyd wheel/pyarrow/lib.pyd wheel/pyarrow/arrow.lib wheel/pyarrow.libs/msvcp140.dll "
    "wheel/pyarrow-1.dist-info/licenses/LICENSE.txt doc/mingw-w64-common/copyright doc/python3-serial/copyright "
    "checkout/build/sis.html checkout/build/docs/index.html"
).split()
USED = (
    "python.exe python3.dll python314.dll python314._pth vcruntime140.dll lib/os.py lib/encodings/utf_8.py "
    "lib/_socket.pyd lib/pyexpat.pyd lib/libffi-8.dll"
).split()
OURS = "sistap.exe app/sistap/sistap.exe app/sistap/sis.lua app/serial/__init__.py SIS.zip experimental/4.4/sis.dll "
OURS += "source.zip demo.cmd CHECKLIST.html docs/index.html sis.html"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The bundle with stand-ins for what is downloaded or compiled."""
    place = tmp_path_factory.mktemp("bundle")
    for name in DOWNLOADED:
        contents.put(place / name, b"x")
    for name in contents.FILES:
        source = CHECKOUT / name
        contents.put(place / "checkout" / name, source.read_bytes() if source.exists() else b"x")
    contents.put(place / "checkout" / contents.MODULES / "4.4/sis.dll", b"x")
    for name in contents.SOURCES:
        source = CHECKOUT / name
        if source.is_dir():
            shutil.copytree(source, place / "checkout" / name, dirs_exist_ok=True)
        else:
            shutil.copy(source, place / "checkout" / name)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contents, "CHECKOUT", place / "checkout")
        patch.setattr(contents, "DOCUMENTS", place / "doc")
        contents.main(str(place / "made"), str(place / "python"), str(place / "wheel"))
    yield place / "made"


def test_the_profile_has_what_every_wireshark_imports(made: Path) -> None:
    with zipfile.ZipFile(made / "SIS.zip") as archive:
        assert archive.namelist() == [f"SIS/{name}" for name in sorted(IMPORTED)]
        for name in IMPORTED:
            assert archive.read(f"SIS/{name}") == (contents.CAPTURE / "sistap/profile/SIS" / name).read_bytes()


def test_the_bundle_runs_by_itself(made: Path) -> None:
    folder = made / contents.NAME
    modules = [file for name in ("sistap", "sisbus") for file in contents.modules(contents.CAPTURE / name)]
    names = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    assert {f"app/{file.relative_to(contents.CAPTURE).as_posix()}" for file in modules} <= names
    python = {name.removeprefix("python/") for name in names if name.startswith("python/")}
    assert python == set(USED)
    assert set(OURS.split()) <= names


def test_the_full_zip_has_what_tables_needs_besides(made: Path) -> None:
    names = []
    for kind in ("", "-full"):
        with zipfile.ZipFile(made / f"{contents.NAME}-windows{kind}.zip") as archive:
            names.append({name.removeprefix(f"{contents.NAME}/") for name in archive.namelist()})
    assert names[1] - names[0] == {"app/pyarrow/lib.pyd", "app/pyarrow.libs/msvcp140.dll", "licences/pyarrow.txt"}


def test_it_has_the_source_of_its_programs_and_every_licence(made: Path) -> None:
    with zipfile.ZipFile(made / contents.NAME / "source.zip") as archive:
        names = set(archive.namelist())
    plugin = {file.relative_to(CHECKOUT).as_posix() for file in (CHECKOUT / "plugin").rglob("*.[ch]")}
    assert plugin | {"LICENSE", "capture/launcher/sistap.c", "capture/bundle/build", "capture/bundle/module"} <= names
    page = (made / contents.NAME / "README.html").read_text("utf-8")
    licences = {file.name for file in (made / contents.NAME / "licences").iterdir()}
    assert licences == {"hacl.txt", "microsoft.txt", "mingw-w64.txt", "pyserial.txt", "python.txt"}
    assert all(f"licences\\{name}" in page for name in licences)


def test_it_has_no_other_path_than_its_own(made: Path) -> None:
    lines = (made / contents.NAME / "python/python314._pth").read_text().split()
    assert [(made / contents.NAME / "python" / line.replace("\\", "/")).resolve().name for line in lines] == [
        "lib",
        "app",
    ]


@pytest.mark.parametrize(("command", "page"), [("web", "sis.html"), ("help", "docs/index.html")])
def test_a_command_opens_the_page_of_the_bundle(made: Path, tmp_path: Path, command: str, page: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(made / contents.NAME / "app"), "DISPLAY": "", "WAYLAND_DISPLAY": ""}
    words = [sys.executable, "-m", "sistap", command]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == (f"{(made / contents.NAME / page).as_uri()}\n", "")


def test_every_command_is_tried() -> None:
    """Under wine, in `check`; the installation with its scripts."""
    typed = re.findall(r'(?:Command\(|bus=)"(\w+)', (BUNDLE / "trial.py").read_text("utf-8"))
    assert set(typed) >= COMMANDS.keys() - {"install", "uninstall"}


def test_what_windows_reads_has_its_line_ends(made: Path) -> None:
    for name in ("install.cmd", "LICENSE.txt"):
        content = (made / contents.NAME / name).read_bytes()
        assert content.count(b"\n") == content.count(b"\r\n") > 1


def test_a_zip_has_the_same_bytes_each_time(made: Path, tmp_path: Path) -> None:
    files = [(file.name, file) for file in (made / contents.NAME / "pictures").iterdir()]
    contents.write_zip(tmp_path / "a.zip", files)
    os.utime(files[0][1], (1e9, 1e9))
    contents.write_zip(tmp_path / "b.zip", reversed(files))
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()


def test_a_missing_licence_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    contents.put(tmp_path / "mingw-w64-common/copyright", b"x")
    monkeypatch.setattr(contents, "DOCUMENTS", tmp_path)
    with pytest.raises(FileNotFoundError, match="Debian's package python3-serial is missing: install it"):
        list(contents.licences())


def test_the_uninstaller_removes_what_was_installed_and_no_more(made: Path) -> None:
    script = (BUNDLE / "installer.nsi").read_text()
    macro = script.partition("!macro RemoveBundle")[2].partition("!macroend")[0]
    lines = re.findall(r'^    (RMDir /r|Delete) "\$INSTDIR\\(.+)"$', macro, re.MULTILINE)
    removed = {name: how for how, name in lines}
    folders = {entry.name: "RMDir /r" if entry.is_dir() else "Delete" for entry in (made / contents.NAME).iterdir()}
    assert removed == folders


@pytest.mark.parametrize(("name", "count"), [("README.html", 12), ("CHECKLIST.html", 2)])
def test_a_page_names_what_is_there(made: Path, name: str, count: int) -> None:
    page = (made / contents.NAME / name).read_text("utf-8")
    named = re.findall(r'src="([^"]+)"', page) + [
        name.replace("\\", "/") for name in re.findall(r"<code>([\w.\\-]+\.(?:cmd|txt|lua|zip|dll|html))</code>", page)
    ]
    assert len(named) > count
    assert [name for name in named if not (made / contents.NAME / name).exists()] == []


MODULES = sorted((CHECKOUT / contents.MODULES).glob("*/sis.dll"))
OWN = {"libwireshark.dll", "libwiretap.dll", "libwsutil.dll", "glib-2.0-0.dll"}
SYSTEM = {"kernel32.dll", "msvcrt.dll"}
ENTRIES = {"plugin_version", "plugin_want_major", "plugin_want_minor", "plugin_register", "plugin_describe"}


class Image:
    """A DLL of 64 bits, read as Microsoft's description of the format says."""

    def __init__(self, file: Path) -> None:
        self.data = file.read_bytes()
        (header,) = struct.unpack_from("<I", self.data, 0x3C)
        assert self.data[header : header + 4] == b"PE\0\0"
        machine, count, _, _, _, size, _ = struct.unpack_from("<HHIIIHH", self.data, header + 4)
        assert machine == 0x8664  # x64
        (magic,) = struct.unpack_from("<H", self.data, header + 24)
        assert magic == 0x20B  # PE32+
        self.exports, self.imports = (
            struct.unpack_from("<I", self.data, header + 24 + place)[0] for place in (112, 120)
        )
        first = header + 24 + size
        self.sections = [struct.unpack_from("<IIII", self.data, first + 40 * index + 8) for index in range(count)]

    def at(self, address: int) -> int:
        """Return where in the file an address is."""
        for size, start, _, offset in self.sections:
            if start <= address < start + size:
                return int(offset + address - start)
        raise AssertionError(hex(address))

    def text(self, address: int) -> str:
        start = self.at(address)
        return self.data[start : self.data.index(b"\0", start)].decode()

    def imported(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        place = self.at(self.imports)
        while True:
            names, _, _, library, _ = struct.unpack_from("<5I", self.data, place)
            if not library:
                return found
            entry = self.at(names)
            while name := struct.unpack_from("<Q", self.data, entry)[0]:
                found.setdefault(self.text(library).lower(), []).append(self.text(name + 2))
                entry += 8
            place += 20

    def exported(self) -> dict[str, int]:
        """Return where in the file each name is."""
        count, functions, names, ordinals = struct.unpack_from("<IIII", self.data, self.at(self.exports) + 24)
        found = {}
        for index in range(count):
            (name,) = struct.unpack_from("<I", self.data, self.at(names) + 4 * index)
            (ordinal,) = struct.unpack_from("<H", self.data, self.at(ordinals) + 2 * index)
            (address,) = struct.unpack_from("<I", self.data, self.at(functions) + 4 * ordinal)
            found[self.text(name)] = self.at(address)
        return found


@pytest.mark.skipif(not MODULES, reason="sis.dll is not built: capture/bundle/build")
@pytest.mark.parametrize("file", MODULES, ids=[file.parent.name for file in MODULES])
def test_a_module_has_what_its_wireshark_looks_for(file: Path) -> None:
    image = Image(file)
    exported = image.exported()
    assert exported.keys() == ENTRIES
    wants = [struct.unpack_from("<i", image.data, exported[f"plugin_want_{part}"])[0] for part in ("major", "minor")]
    assert ".".join(map(str, wants)) == file.parent.name
    version = image.data[exported["plugin_version"] :].partition(b"\0")[0].decode()
    assert version == __version__


@pytest.mark.skipif(not MODULES, reason="sis.dll is not built: capture/bundle/build")
@pytest.mark.parametrize("file", MODULES, ids=[file.parent.name for file in MODULES])
def test_a_module_imports_from_wireshark_and_windows_alone(file: Path) -> None:
    imported = Image(file).imported()
    assert imported.keys() <= OWN | SYSTEM
    assert {"proto_register_plugin", "proto_tree_add_item", "find_dissector"} <= set(imported["libwireshark.dll"])
    assert "g_free" in imported["glib-2.0-0.dll"]
