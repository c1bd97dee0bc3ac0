# SPDX-License-Identifier: GPL-2.0-or-later
"""tshark's rows where no process can run: in a browser. There Wireshark is a module of WebAssembly with sis.lua.

Its page hands it over as the module `wireshark_of_page` (lua-fallback/page/src/tap/rows.js).
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Generator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any

from sistap.dissected.wireshark.trouble import TsharkError

_NO_CAPTURE = 'tshark: The file "{}" isn\'t a capture file in a format TShark understands.'
_CUT = 'tshark: The file "{}" appears to have been cut short in the middle of a packet.'
_ALONE = ("-2", "-n", "-l", "-q")  # wiregasm always reads in two passes, and resolves no names
# It prints nothing but fields; a read filter that leaves all is for fields in the first pass, which page.lua has; two
# protocols are always disabled (OWN_FILES in sistap.js).
_USUAL = {("-T", "fields"), ("-R", "frame"), ("--disable-protocol", "ftdi-ft"), ("--disable-protocol", "usbcom")}


@dataclass
class Asked:
    """What a command line of tshark asks for."""

    file: str = ""
    names: list[str] = field(default_factory=list)
    joint: str = ","
    has_header: bool = False
    filter: str = ""
    preferences: dict[str, str] = field(default_factory=dict)
    most: int = 0  # packets; 0: all

    @classmethod
    def parse(cls, arguments: Sequence[str]) -> Asked:
        """Parse the options that sistap uses for rows of fields."""
        asked = cls()
        words = iter(word for word in arguments if word not in _ALONE)
        for option, value in zip(words, words, strict=True):
            asked._take(option, value)
        return asked

    def _take(self, option: str, value: str) -> None:
        name, _, text = value.partition("=" if option == "-E" else ":")
        match option:
            case "-r":
                self.file = value
            case "-e":
                self.names.append(value)
            case "-E" if name == "aggregator":
                self.joint = text
            case "-E" if name == "header":
                self.has_header = text == "y"
            case "-Y":
                self.filter = value
            case "-o" if not name.startswith("gui."):  # the column with the information is always there
                self.preferences[name] = text
            case "-c":
                self.most = int(value)
            case "-o":
                pass
            case "-z":
                raise TsharkError(f"tshark: Invalid -z argument {value}")
            case _ if (option, value) not in _USUAL:
                raise TsharkError(f"Wireshark in a browser cannot do {option} {value}")


class Tshark:
    """The same as the class of tshark.py, as far as a browser can."""

    def __init__(self, program: str = "tshark", *, plugins: Path | None = None, drop_rights: bool = True) -> None:
        """Nothing has to be prepared."""

    def __enter__(self) -> Tshark:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def lines(self, arguments: Sequence[str]) -> Generator[str, None, None]:
        """Yield a line for each packet. TsharkError if the file is no capture, and after its last line if it is cut."""
        asked = Asked.parse(arguments)
        rows = _page().open(Path(asked.file).read_bytes(), json.dumps(asdict(asked)))
        if rows.unknown:
            raise TsharkError(_unknown(rows.unknown))
        if not rows.isCapture:
            raise TsharkError(_NO_CAPTURE.format(asked.file))
        if asked.has_header:
            yield "\t".join(asked.names)
        while piece := rows.next():
            yield from piece.split("\n")
        if rows.isCut:
            raise TsharkError(_CUT.format(asked.file))

    def pieces(self, arguments: Sequence[str]) -> Generator[bytes, None, None]:
        """Fail as tshark does without the plugin: sis.lua has no tap for rows."""
        yield from (line.encode() for line in self.lines(arguments))

    def run(
        self,
        arguments: Sequence[str],
        *,
        capture: bool = True,  # noqa: ARG002
        extra_environment: dict[str, str] | None = None,  # noqa: ARG002
        stdin: IO[bytes] | None = None,  # noqa: ARG002
    ) -> subprocess.CompletedProcess[str]:
        """Check fields, which is what sistap runs tshark for on empty input."""
        unknown = _page().unknown(json.dumps(Asked.parse(arguments).names))
        return subprocess.CompletedProcess(["tshark"], 1 if unknown else 0, "", _unknown(unknown) if unknown else "")


def _page() -> Any:
    import wireshark_of_page  # type: ignore[import-not-found]

    return wireshark_of_page


def _unknown(names: Sequence[str]) -> str:
    return "\n\t".join(["tshark: Some fields aren't valid:", *names])
