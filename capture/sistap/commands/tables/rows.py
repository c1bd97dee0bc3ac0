# SPDX-License-Identifier: GPL-2.0-or-later
"""The rows of a packet: of its telegrams, of the values that were read and written, or of an event; and of episodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.masters import station_of
from sistap.dissected.packets.dissection import CHARACTERS, EXCEEDED, OK, UNRESOLVED, Judged, Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT, JOINT, OTHER
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Event
from sistap.tap.sis.telegram import service_name
from sistap.tap.terminal.exits import FAILED, Refusal

# Fields besides those of a Packet.
FIELDS = ("sis.value", "sis.value.number", "sis.error", CHARACTERS)
_VERDICTS = {OK: "ok", EXCEEDED: "exceeded", UNRESOLVED: "unresolved", None: None}
_NO_TIME = Judged(0.0, None, None)
_LARGEST = 1 << 63
_REMEMBERED = 2048  # packets that are not alike
# Numbers: the operators of an enum take as long as a whole row.
_CHARACTER_ERRORS = int(Flag.CHARACTER_ERROR | Flag.UNLOCATED_ERROR)
_BREAK, _LOST = int(Flag.BREAK), int(Flag.LOST_BEFORE)


# What stands in the place of a telegram of which only characters are left: nobody knows whose it was.
_UNKNOWN: tuple[Any, ...] = (None, None, None, None, None, None, None)
_DESTROYED = (Telegram(False, None, None, None, False, None, False, False, False, False, "", False, *_UNKNOWN),)


class Row(NamedTuple):
    """A row, and the table that it belongs to."""

    table: str
    values: dict[str, Any]  # of all columns: those of all rows of a table are in the same order


class Rows:
    """Makes rows of the packets of a file. What alike packets say in the same way is worked out once."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._known: dict[tuple[object, int], dict[str, Any]] = {}  # by packets that are alike, and place

    def of(self, packet: Packet) -> Iterator[Row]:
        """Yield the rows of a packet. Raise Refusal."""
        epoch_ns = _epoch_ns(packet, self._file)
        for number, telegram in enumerate(packet.telegrams or (_DESTROYED if packet.type == OTHER else ())):
            known = self._known.get((packet.alike, number))
            if known is None:
                known = self._work_out(packet, telegram, number)
            yield Row("telegrams", known | _own(packet, telegram, epoch_ns))
        for number, access in enumerate(packet.accesses):
            yield Row("values", self._place(packet, number) | _value(access, epoch_ns, packet.number))
        if packet.type == EVENT and not packet.is_again:
            said = {"epoch_ns": epoch_ns, "packet": packet.number, "code": packet.event, "text": packet.text}
            yield Row("events", self._place(packet, 0) | said | _event(packet.event))

    def _work_out(self, packet: Packet, telegram: Telegram, number: int) -> dict[str, Any]:
        if len(self._known) == _REMEMBERED:
            self._known.clear()
        known = self._known[packet.alike, number] = self._place(packet, number) | _telegram(packet, telegram)
        return known

    def _place(self, packet: Packet, number: int) -> dict[str, Any]:
        return {"port": packet.interface, "line": packet.line, "file": self._file, "place": number}


def of_episode(episode: Episode, file: str, packet: int | None) -> Row:
    """Return the row of an episode that begins with a packet of a file."""
    hit = episode.hit
    said = {
        "port": hit.port,
        "kind": hit.kind,
        "count": episode.count,
        "worst": hit.worst,
        "text": episode.text,
        "epoch_ns": round(episode.from_s * 1e9),
        "line": None,
        "file": file,
        "packet": packet,
        "place": None,
        "until": round(episode.to_s * 1e6),
        "severity": episode.severity.name.lower(),
        "station": episode.station,
        "parameter": hit.parameter or None,
    }
    return Row("episodes", said)


def _epoch_ns(packet: Packet, file: str) -> int:
    if not -_LARGEST <= packet.epoch_ns < _LARGEST:
        raise Refusal(
            f"{file}: packet {packet.number} has a time that no table holds: correct it with editcap -t", FAILED
        )
    return packet.epoch_ns


def _event(code: int | None) -> dict[str, str | None]:
    known = {int(event): event.name.lower() for event in Event}
    return {"event": known.get(code or 0)}


def _telegram(packet: Packet, telegram: Telegram) -> dict[str, Any]:
    """Return what alike packets say in the same way."""
    return {
        "sender": telegram.talker,
        "receiver": telegram.listener,
        "is_reaction": telegram.is_reaction,
        "service": telegram.service,
        "service_name": None if telegram.service is None else service_name(telegram.service),
        "parameter": _one(telegram.columns.get("sis.parameter")),
        "status": telegram.status if telegram.is_reaction else None,
        "is_good": telegram.good,
        "is_repeat": telegram.is_repeat,
        "is_unanswered": telegram.unanswered,
        "has_character_error": bool(packet.errors & _CHARACTER_ERRORS),
        "has_break": bool(packet.errors & _BREAK),
        "has_loss": bool(packet.errors & _LOST),
        "baud": packet.baud,
        "phase": _integer(telegram.phase),
    }


def _own(packet: Packet, telegram: Telegram, epoch_ns: int) -> dict[str, Any]:
    """Return what each telegram says for itself."""
    said = telegram.columns.get
    numbers = said("sis.value.number", "").split(JOINT)
    reaction, pause, cycle = telegram.reaction or _NO_TIME, telegram.pause or _NO_TIME, telegram.cycle or _NO_TIME
    return {
        "epoch_ns": epoch_ns,
        "packet": packet.number,
        "value": _one(said("sis.value")),
        "number": float(numbers[0]) if len(numbers) == 1 and numbers[0] else None,
        "error": _integer(said("sis.error")),
        "command_packet": telegram.command_in,
        "reaction_s": reaction.time_s or None,
        "trs_limit_s": reaction.limit_s,
        "trs_verdict": _VERDICTS.get(reaction.verdict),
        "longest_interval_s": None if packet.is_of_one_read else pause.time_s or None,
        "tza_limit_s": pause.limit_s,
        "tza_verdict": _VERDICTS.get(pause.verdict),
        "cycle_s": cycle.time_s or None,
        "tmas_limit_s": cycle.limit_s,
        "tmas_verdict": _VERDICTS.get(cycle.verdict),
        "uncertainty_s": packet.uncertainty_s,
        "raw": packet.characters or None if len(packet.telegrams) < 2 else None,  # noqa: PLR2004 - telegrams
    }


def _value(access: Access, epoch_ns: int, packet: int) -> dict[str, Any]:
    _, route, device, ident = access.parameter
    return {
        "epoch_ns": epoch_ns,
        "packet": packet,
        "station": station_of(access.parameter),
        "route": route,
        "device": device,
        "parameter": ident,
        "name": access.name or None,
        "unit": access.unit or None,
        "is_write": access.is_write,
        "master": access.master,
        "value": access.value or None,
        "number": None if access.number is None else float(access.number),
        "error": access.error or None,
    }


def _one(text: str | None) -> str | None:
    """Return the first of several values: in a list of services, that of the first service."""
    return text.partition(JOINT)[0] if text else None


def _integer(text: str | None) -> int | None:
    return int(text.partition(JOINT)[0], 0) if text else None
