# SPDX-License-Identifier: GPL-2.0-or-later
"""An access to the operating data of a parameter, from the dissector's field `sis.access`."""

from __future__ import annotations

import json
import sys
from functools import lru_cache
from typing import Any, NamedTuple

from sistap.dissected.wireshark.rows import JOINT
from sistap.tap.terminal.console import visible

FIELD = "sis.access"
_LARGEST = sys.float_info.max  # the ASCII protocol has numbers of any length
_LONG = 1000  # characters of a text from which on it is not remembered
_decode = json.JSONDecoder().raw_decode  # looks for no spaces around it, as json.loads does


class Parameter(NamedTuple):
    """A parameter of a device behind a station."""

    port: str  # the capture's interface
    station: str  # "3", behind routers "3/2/8"
    device: int
    ident: str  # "S-0-0047"


class Access(NamedTuple):
    """A read or write that was answered. Unknown values are None, missing texts are empty."""

    parameter: Parameter
    is_write: bool
    master: int | None  # the station that asked; the ASCII protocol does not say which
    error: str  # why it was refused; empty if it was not
    value: str  # as the dissector shows it
    number: float | None  # of the value
    data: str | None  # all bytes, in hexadecimal
    name: str
    unit: str
    minimum: str
    maximum: str
    is_raw: bool = False  # the value is bytes, because its attribute is not known
    text: str | None = None  # of the ASCII protocol, instead of data: elements of a list with ", " between

    @property
    def plain(self) -> float | str | None:
        """Return the value as a number without its unit, if it is one. None: it was refused, or is not known."""
        if self.error or not self.value:
            return None
        return self.value if self.number is None else self.number

    @property
    def whole(self) -> str | None:
        """Return all of the value, not to show but to compare: `value` may be cut off. None: it is not known."""
        return self.text if self.data is None else self.data

    @property
    def by(self) -> str:
        """Return who asked, in a word."""
        return "ASCII" if self.master is None else str(self.master)


def accesses(port: str, text: str) -> list[Access]:
    """Return the accesses that a packet tells. A list of services, or TCP, may have several."""
    if not text:
        return []
    if JOINT not in text:
        access = _known(port, text) if len(text) < _LONG else _access(port, text)
        return [] if access is None else [access]
    found = (_known(port, one) if len(one) < _LONG else _access(port, one) for one in text.split(JOINT))
    return [access for access in found if access is not None]


def _access(port: str, text: str) -> Access | None:
    """Return the access of a JSON text; None for one that another version of the dissector has written, or damaged."""
    try:
        return _made(port, _said(text))
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


def _said(text: str) -> dict[str, Any]:
    """Decode a text. It has no two backslashes in a row (plugin/sis/access.c), unless tshark has doubled each."""
    said, _ = _decode(text.replace("\\\\", "\\"))
    if "\\" not in text:  # then there is nothing that is not visible
        return dict(said)
    return {name: visible(value) if isinstance(value, str) else value for name, value in said.items()}


def _made(port: str, said: dict[str, Any]) -> Access:
    number = said.get("number")
    return Access(
        parameter=Parameter(port, said["station"], said["device"], said["parameter"]),
        is_write=said["access"] == "write",
        master=said.get("master"),
        error=said.get("error", ""),
        value=said.get("value", ""),
        number=None if number is None or abs(number) > _LARGEST else number,
        data=said.get("data"),
        name=said.get("name", ""),
        unit=said.get("unit", ""),
        minimum=said.get("minimum", ""),
        maximum=said.get("maximum", ""),
        is_raw=said.get("raw", False),
        text=said.get("text"),
    )


_known = lru_cache(1024)(_access)  # many are read again and again, and have not changed
