# SPDX-License-Identifier: GPL-2.0-or-later
"""The contents of the bundle for Windows, and reproducible zips of it.

contents.py FOLDER PYTHON WHEELS makes SIS.zip in FOLDER, the folder of the bundle, the zip of that, and the full zip.
PYTHON is the folder of a Python for Windows, WHEELS that of unpacked wheels: pyserial and pyarrow.
"""

from __future__ import annotations

import shutil
import sys
import zipfile
from collections.abc import Iterable, Iterator
from fnmatch import fnmatch
from pathlib import Path

CAPTURE = Path(__file__).resolve().parents[1]
CHECKOUT = CAPTURE.parent
sys.path.insert(0, str(CAPTURE))

from sistap import __version__  # noqa: E402 - of the checkout

NAME = f"sistap-{__version__}"
TIME = (1980, 1, 1, 0, 0, 0)  # of every file: the earliest time in a zip

# Wireshark imports only those files of a profile whose names it knew when it started. It learns plots when their window
# opens. 4.0 knows neither dmacros nor profile_settings; later versions make dmacros from dfilter_macros.
NOT_IMPORTED = ("dmacros", "plots", "profile_settings")

# The source of each file, and its place in the bundle.
FILES = {
    "LICENSE": "LICENSE.txt",
    "capture/bundle/CHECKLIST.html": "CHECKLIST.html",
    "capture/bundle/README.html": "README.html",
    "capture/bundle/demo.cmd": "demo.cmd",
    "capture/bundle/install.cmd": "install.cmd",
    "capture/bundle/uninstall.cmd": "uninstall.cmd",
    "capture/bundle/licences/hacl.txt": "licences/hacl.txt",
    "capture/bundle/licences/microsoft.txt": "licences/microsoft.txt",
    "capture/bundle/licences/python.txt": "licences/python.txt",
    "capture/pictures/live.png": "pictures/live.png",
    "capture/pictures/options.png": "pictures/options.png",
    "plugin/pictures/wireshark.png": "pictures/wireshark.png",
    "build/windows/command/sistap.exe": "sistap.exe",
    "build/windows/sistap.exe": "app/sistap/sistap.exe",
    "lua-fallback/sis.lua": "app/sistap/sis.lua",
}
MODULES = "build/windows/module"  # VERSION/sis.dll in it
PAGES = ("docs", "sis.html")  # in build/, if they were made: the handbook, and the page with the course
TEXTS = (".cmd", ".txt")  # with the line ends of Windows

# The source of what is compiled here, as the GPL wants it beside the programs. All else in the bundle is source itself.
SOURCES = ("CMakeLists.txt", "LICENSE", "plugin", "capture/launcher", "capture/bundle")

# Debian's packages with the licences of pyserial and of the runtime of mingw-w64, which the binaries lack.
LICENCES = {"mingw-w64-common": "licences/mingw-w64.txt", "python3-serial": "licences/pyserial.txt"}
DOCUMENTS = Path("/usr/share/doc")

# What `sistap tables` needs; a compiler's part of it is left out.
FULL = ("pyarrow", "pyarrow.libs")
NOT_FULL = ("pyarrow/include/*", "pyarrow/tests/*", "*.lib", "*.pxd", "*.pyx", "*.pxi", "*.h", "*.cc")
LICENCE_OF_FULL = ("pyarrow-*.dist-info/licenses/LICENSE.txt", "licences/pyarrow.txt")

# Python's C modules that sistap, pyserial and pyarrow need, with their libraries. OpenSSL, SQLite and Tcl are large and
# left out.
BINARIES = (
    "vcruntime140*.dll libffi-*.dll _ctypes.pyd _decimal.pyd _queue.pyd _socket.pyd _zoneinfo.pyd pyexpat.pyd "
    "select.pyd unicodedata.pyd"
).split()
# Python modules that nothing here needs.
LEFT_OUT = (
    "test idlelib tkinter turtle* ensurepip pip* venv sqlite3 dbm curses unittest pydoc* doctest.py asyncio "
    "multiprocessing concurrent wsgiref xmlrpc site-packages _pyrepl __phello__ __pycache__"
).split()

# Python takes its path from this file alone: no variable and no other Python of this Windows can change it.
PATH = "lib\r\n..\\app\r\n"


def profile() -> list[Path]:
    """Return the files of SIS.zip."""
    return [file for file in sorted((CAPTURE / "sistap/profile/SIS").iterdir()) if file.name not in NOT_IMPORTED]


def write_zip(target: Path, files: Iterable[tuple[str, Path]]) -> None:
    """Write files, each with its name, in the order of the names; folders have no entries of their own."""
    with zipfile.ZipFile(target, "w") as archive:
        for name, file in sorted(files):
            entry = zipfile.ZipInfo(name, TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 0  # Windows
            archive.writestr(entry, file.read_bytes())


def put(target: Path, content: bytes) -> None:
    """Write a file, and its parent folders."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.suffix in TEXTS:
        content = content.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n")
    target.write_bytes(content)


def put_tree(source: Path, target: Path, files: Iterable[Path]) -> None:
    """Copy files of one folder into another, each to the same relative place."""
    for file in files:
        put(target / file.relative_to(source), file.read_bytes())


def modules(folder: Path) -> Iterator[Path]:
    """Return all files below a folder, except compiled Python."""
    return (file for file in folder.rglob("*") if file.is_file() and "__pycache__" not in file.parts)


def of_python(folder: Path) -> Iterator[Path]:
    """Return the files of a Python for Windows that the bundle needs."""
    yield folder / "python.exe"
    yield from folder.glob("python3*.dll")
    for entry in (folder / "lib").iterdir():
        if entry.suffix in {".dll", ".pyd"}:
            if any(fnmatch(entry.name, name) for name in BINARIES):
                yield entry
        elif not any(fnmatch(entry.name, name) for name in LEFT_OUT):
            yield from modules(entry) if entry.is_dir() else [entry]


def licences() -> Iterator[tuple[str, Path]]:
    """Return the licence texts to include, each with its name. Raise FileNotFoundError."""
    for package, name in LICENCES.items():
        found = sorted(DOCUMENTS.glob(f"{package}/copyright"))
        if not found:
            raise FileNotFoundError(f"the licence in Debian's package {package} is missing: install it")
        yield name, found[-1]


def sources() -> Iterator[tuple[str, Path]]:
    """Return the files of source.zip, each with its name; pictures are no source."""
    for name in SOURCES:
        place = CHECKOUT / name
        for file in modules(place) if place.is_dir() else [place]:
            if file.suffix != ".png":
                yield file.relative_to(CHECKOUT).as_posix(), file


def full(wheels: Path) -> Iterator[tuple[str, Path]]:
    """Return what the full zip has besides, each file with its name."""
    pattern, name = LICENCE_OF_FULL
    yield name, next(wheels.glob(pattern))
    for folder in FULL:
        for file in modules(wheels / folder):
            place = file.relative_to(wheels).as_posix()
            if not any(fnmatch(place, pattern) for pattern in NOT_FULL):
                yield f"app/{place}", file


def make_folder(bundle: Path, python: Path, wheels: Path) -> None:
    """Put everything in its place in the bundle."""
    shutil.rmtree(bundle, ignore_errors=True)
    put_tree(python, bundle / "python", of_python(python))
    # Python looks for its libraries beside itself and in the folders of its path.
    for library in (bundle / "python/lib").glob("vcruntime*.dll"):
        library.rename(bundle / "python" / library.name)
    (dll,) = (file for file in (bundle / "python").glob("python3*.dll") if file.stem != "python3")
    put(bundle / f"python/{dll.stem}._pth", PATH.encode())
    for package in ("sistap", "sisbus"):
        put_tree(CAPTURE, bundle / "app", modules(CAPTURE / package))
    put_tree(wheels / "serial", bundle / "app/serial", modules(wheels / "serial"))
    for source, name in FILES.items():
        put(bundle / name, (CHECKOUT / source).read_bytes())
    for name, file in licences():
        put(bundle / name, file.read_bytes())
    for page in (CHECKOUT / "build" / name for name in PAGES):
        put_tree(CHECKOUT / "build", bundle, modules(page) if page.is_dir() else filter(Path.exists, [page]))
    write_zip(bundle / "source.zip", sources())
    write_zip(bundle / "SIS.zip", ((f"SIS/{file.name}", file) for file in profile()))
    for file in (CHECKOUT / MODULES).glob("*/sis.dll"):
        put(bundle / "experimental" / file.parent.name / file.name, file.read_bytes())


def main(folder: str, python: str, wheels: str) -> None:
    """Make SIS.zip, the bundle, and its zips."""
    bundle = Path(folder, NAME)
    make_folder(bundle, Path(python), Path(wheels))
    shutil.copy(bundle / "SIS.zip", folder)
    inside = [(f"{NAME}/{file.relative_to(bundle).as_posix()}", file) for file in bundle.rglob("*") if file.is_file()]
    more = [(f"{NAME}/{name}", file) for name, file in full(Path(wheels))]
    write_zip(Path(folder, f"{NAME}-windows.zip"), inside)
    write_zip(Path(folder, f"{NAME}-windows-full.zip"), inside + more)


if __name__ == "__main__":
    main(*sys.argv[1:])
