# SPDX-License-Identifier: GPL-2.0-or-later
"""Stretches of a capture that are shown in full detail: those asked for, and those around the worst moments."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from sistap.packets.dissection import Dissection, Packet
from sistap.packets.kept import Span
from sistap.packets.moments import Moment
from sistap.wireshark.rows import FRAME, OTHER

WORST_SHOWN = 3  # windows around the worst moments
PACKETS_KEPT = 1000  # in a window: more would be a grey bar and a page of many megabytes
_LEAST_MARGIN_S = 0.03  # so that what came before and after is seen, also at 9600 Bd
_LONGEST_PACKET_S = 5.0  # a packet that reaches into a window can begin this much earlier


@dataclass
class Window:
    """From `start_s` to `end_s`, in s since the first packet."""

    title: str
    start_s: float
    end_s: float
    packets: list[Packet] = field(default_factory=list)
    left_out: int = 0  # packets above PACKETS_KEPT

    def add(self, packet: Packet) -> None:
        """Take a packet of characters, if any of it is inside."""
        if packet.type not in (FRAME, OTHER) or packet.time_s > self.end_s or packet.end_s < self.start_s:
            return
        if len(self.packets) < PACKETS_KEPT:
            self.packets.append(packet)
        else:
            self.left_out += 1

    def shows(self, moment: Moment) -> bool:
        """Tell whether it shows a moment from its beginning to its end."""
        return self.start_s <= moment.start_s and moment.end_s <= self.end_s


def parse(text: str) -> Window:
    """Read START+SECONDS. ValueError says what is wrong."""
    start, _, length = text.partition("+")
    try:
        start_s, length_s = float(start), float(length)
    except ValueError:
        start_s = length_s = math.nan
    if not (0 <= start_s < math.inf and 0 < length_s < math.inf):
        raise ValueError(f"'{text}' is not START+SECONDS, for example 12.5+0.2")
    return Window(f"Asked for: {length_s:g} s from {start_s:g} s", start_s, start_s + length_s)


def around(moments: Iterable[Moment], shown: Sequence[Window]) -> list[Window]:
    """Make windows around the first moments that no window shows yet. Packets without times cannot be shown."""
    made: list[Window] = []
    for moment in moments:
        if not moment.has_times or any(window.shows(moment) for window in [*shown, *made]):
            continue
        margin_s = max((moment.end_s - moment.start_s) / 2, _LEAST_MARGIN_S)
        title = f"Packet {moment.number}: {moment.kind.title}"
        made.append(Window(title, max(moment.start_s - margin_s, 0.0), moment.end_s + margin_s))
        if len(made) == WORST_SHOWN:
            break
    return made


def fill(dissection: Dissection, windows: Sequence[Window], moments: Iterable[Moment]) -> dict[int, str]:
    """Read the packets of all windows; give the line that Wireshark's packet list has for each moment, by number."""
    numbers = {moment.number for moment in moments}
    spans = [Span(max(window.start_s - _LONGEST_PACKET_S, 0), window.end_s) for window in windows]
    info: dict[int, str] = {}
    for packet in dissection.again(numbers, spans):
        if packet.number in numbers:
            info[packet.number] = packet.info
        for window in windows:
            window.add(packet)
    return info
