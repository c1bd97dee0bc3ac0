# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders by what `tshark -G folders` says: recorded on Debian; on macOS and Windows as its manual names them."""

from pathlib import Path, PurePosixPath, PureWindowsPath

import pytest

from sistap.dissected.wireshark import folders
from sistap.dissected.wireshark.tshark import TsharkError

DEBIAN_40 = """\
Temp:                	/tmp
Personal configuration:	/home/u/.config/wireshark
Global configuration:	/usr/share/wireshark
System:              	/etc
Program:             	/usr/bin
Personal Plugins:    	/home/u/.local/lib/wireshark/plugins/4.0
Global Plugins:      	/usr/lib/x86_64-linux-gnu/wireshark/plugins/4.0
Personal Lua Plugins:	/home/u/.local/lib/wireshark/plugins
Global Lua Plugins:  	/usr/lib/x86_64-linux-gnu/wireshark/plugins
Extcap path:         	/usr/lib/x86_64-linux-gnu/wireshark/extcap
MaxMind database path:	/usr/share/GeoIP
MaxMind database path:	/var/lib/GeoIP
"""
DEBIAN_46 = """\
Temp:                	/tmp
Personal configuration:	/home/u/.config/wireshark
Global configuration:	/usr/share/wireshark
System:              	/etc
Program:             	/usr/bin
Personal Plugins:    	/home/u/.local/lib/wireshark/plugins/4.6
Global Plugins:      	/usr/lib/x86_64-linux-gnu/wireshark/plugins/4.6
Personal Lua Plugins:	/home/u/.local/lib/wireshark/plugins
Global Lua Plugins:  	/usr/lib/x86_64-linux-gnu/wireshark/plugins
Personal Extcap path:	/home/u/.local/lib/wireshark/extcap
Global Extcap path:  	/usr/libexec/wireshark/extcap
MaxMind database path:	/usr/share/GeoIP
"""
MACOS = """\
Temp:                	/var/folders/zz/T
Personal configuration:	/Users/u/.config/wireshark
Global configuration:	/Applications/Wireshark.app/Contents/Resources/share/wireshark
System:              	/etc
Program:             	/Applications/Wireshark.app/Contents/MacOS
Personal Plugins:    	/Users/u/.local/lib/wireshark/plugins/4-4
Global Plugins:      	/Applications/Wireshark.app/Contents/PlugIns/wireshark/4-4
Personal Lua Plugins:	/Users/u/.local/lib/wireshark/plugins
Global Lua Plugins:  	/Applications/Wireshark.app/Contents/PlugIns/wireshark
Personal Extcap path:	/Users/u/.local/lib/wireshark/extcap
Global Extcap path:  	/Applications/Wireshark.app/Contents/MacOS/extcap
"""
WINDOWS = """\
Temp:                	C:\\Users\\u\\AppData\\Local\\Temp\r
Personal configuration:	C:\\Users\\u\\AppData\\Roaming\\Wireshark\\\r
Global configuration:	C:\\Program Files\\Wireshark\r
System:              	C:\\Program Files\\Wireshark\r
Program:             	C:\\Program Files\\Wireshark\r
Personal Plugins:    	C:\\Users\\u\\AppData\\Roaming\\Wireshark\\plugins\\4.4\r
Global Plugins:      	C:\\Program Files\\Wireshark\\plugins\\4.4\r
Personal Lua Plugins:	C:\\Users\\u\\AppData\\Roaming\\Wireshark\\plugins\r
Global Lua Plugins:  	C:\\Program Files\\Wireshark\\plugins\r
Personal Extcap path:	C:\\Users\\u\\AppData\\Roaming\\Wireshark\\extcap\r
Global Extcap path:  	C:\\Program Files\\Wireshark\\extcap\r
"""
DEBIAN_PLUGINS = "/usr/lib/x86_64-linux-gnu/wireshark/plugins"
APP = "/Applications/Wireshark.app/Contents"
ROAMING = "C:\\Users\\u\\AppData\\Roaming\\Wireshark"
PROGRAM = "C:\\Program Files\\Wireshark"


@pytest.mark.parametrize(
    ("text", "for_all", "kind", "expected"),
    [
        (
            DEBIAN_40,
            False,
            PurePosixPath,
            (
                "/home/u/.local/lib/wireshark/plugins/4.0/epan",
                "/home/u/.local/lib/wireshark/plugins",
                "/home/u/.config/wireshark/extcap",
                "/home/u/.config/wireshark/profiles",
            ),
        ),
        (
            DEBIAN_40,
            True,
            PurePosixPath,
            (
                f"{DEBIAN_PLUGINS}/4.0/epan",
                DEBIAN_PLUGINS,
                "/usr/lib/x86_64-linux-gnu/wireshark/extcap",
                "/usr/share/wireshark/profiles",
            ),
        ),
        (
            DEBIAN_46,
            False,
            PurePosixPath,
            (
                "/home/u/.local/lib/wireshark/plugins/4.6/epan",
                "/home/u/.local/lib/wireshark/plugins",
                "/home/u/.local/lib/wireshark/extcap",
                "/home/u/.config/wireshark/profiles",
            ),
        ),
        (
            DEBIAN_46,
            True,
            PurePosixPath,
            (
                f"{DEBIAN_PLUGINS}/4.6/epan",
                DEBIAN_PLUGINS,
                "/usr/libexec/wireshark/extcap",
                "/usr/share/wireshark/profiles",
            ),
        ),
        (
            MACOS,
            False,
            PurePosixPath,
            (
                "/Users/u/.local/lib/wireshark/plugins/4-4/epan",
                "/Users/u/.local/lib/wireshark/plugins",
                "/Users/u/.local/lib/wireshark/extcap",
                "/Users/u/.config/wireshark/profiles",
            ),
        ),
        (
            MACOS,
            True,
            PurePosixPath,
            (
                f"{APP}/PlugIns/wireshark/4-4/epan",
                f"{APP}/PlugIns/wireshark",
                f"{APP}/MacOS/extcap",
                f"{APP}/Resources/share/wireshark/profiles",
            ),
        ),
        (
            WINDOWS,
            False,
            PureWindowsPath,
            (
                f"{ROAMING}\\plugins\\4.4\\epan",
                f"{ROAMING}\\plugins",
                f"{ROAMING}\\extcap",
                f"{ROAMING}\\profiles",
            ),
        ),
        (
            WINDOWS,
            True,
            PureWindowsPath,
            (f"{PROGRAM}\\plugins\\4.4\\epan", f"{PROGRAM}\\plugins", f"{PROGRAM}\\extcap", f"{PROGRAM}\\profiles"),
        ),
    ],
    ids=[
        f"{system}, {whose}"
        for system in ("Debian 12", "Debian testing", "macOS", "Windows")
        for whose in ("one", "all")
    ],
)
def test_folders(
    monkeypatch: pytest.MonkeyPatch, text: str, for_all: bool, kind: type[Path], expected: tuple[str, ...]
) -> None:
    monkeypatch.setattr(folders, "Path", kind)
    assert folders.parse(text, for_all=for_all) == tuple(kind(path) for path in expected)


def test_a_wireshark_without_lua(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(folders, "Path", PurePosixPath)
    without = "".join(line for line in DEBIAN_40.splitlines(keepends=True) if "Lua" not in line)
    with pytest.raises(TsharkError, match="names no Personal Lua Plugins"):
        folders.parse(without, for_all=False)


HOSTILE = {
    "a line break": DEBIAN_40.replace("/home/u/", "/home/u\nv/"),
    "relative": DEBIAN_40.replace("/home/u/.local", ".local"),
    "relative configuration": DEBIAN_40.replace("/home/u/.config", "x"),
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
@pytest.mark.attack(
    "HOME or XDG_CONFIG_HOME is relative or has a line break", "refused in one line; nothing is installed"
)
def test_folders_of_a_strange_home(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(folders, "Path", PurePosixPath)
    with pytest.raises(TsharkError, match="HOME.*XDG_CONFIG_HOME"):
        folders.parse(text, for_all=False)
    assert folders.parse(DEBIAN_40, for_all=True)
