# SPDX-License-Identifier: GPL-2.0-or-later
"""The rows of a packet: of its telegrams, of the values that were read and written, or of an event; and of episodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from sistap.episodes.episode import Episode
from sistap.episodes.masters import station_of
from sistap.line.settings import Flag
from sistap.packets.dissection import EXCEEDED, OK, UNRESOLVED, Judged, Packet, Telegram
from sistap.records.record import Event
from sistap.sis.telegram import service_name
from sistap.wireshark.rows import EVENT, JOINT

# Fields besides those of a Packet.
FIELDS = ("sis.value", "sis.value.number", "sis.error", "sertap.character")
_VERDICTS = {OK: "ok", EXCEEDED: "exceeded", UNRESOLVED: "unresolved"}
_LARGEST = 1 << 63
# Numbers: the operators of an enum take as long as a whole row.
_CHARACTER_ERRORS = int(Flag.CHARACTER_ERROR | Flag.UNLOCATED_ERROR)
_BREAK, _LOST = int(Flag.BREAK), int(Flag.LOST_BEFORE)


class NoSuchTime(Exception):
    """A packet has a time that no table can hold; the text is the line to show."""


class Row(NamedTuple):
    """A row, and the table that it belongs to."""

    table: str
    values: dict[str, Any]


def rows(packet: Packet, file: str) -> Iterator[Row]:
    """Yield the rows of a packet. Raise NoSuchTime."""
    place = {
        "epoch_ns": _epoch_ns(packet),
        "port": packet.interface,
        "line": packet.line,
        "file": file,
        "packet": packet.number,
    }
    for number, telegram in enumerate(packet.telegrams):
        yield Row("telegrams", {**place, "place": number, **_telegram(packet, telegram)})
    for number, access in enumerate(packet.accesses):
        _, route, device, ident = access.parameter
        values = {name: None if value == "" else value for name, value in access._asdict().items()}
        number_of = None if access.number is None else float(access.number)
        values |= {"station": station_of(access.parameter), "route": route}
        values |= {"device": device, "parameter": ident, "number": number_of}
        yield Row("values", place | {"place": number} | values)
    if packet.type == EVENT and not packet.is_again:
        yield Row("events", place | {"place": 0, "code": packet.event, "text": packet.text} | _event(packet.event))


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
        "file": file,
        "packet": packet,
        "until": round(episode.to_s * 1e6),
        "severity": episode.severity.name.lower(),
        "station": episode.station,
        "parameter": hit.parameter or None,
    }
    return Row("episodes", said)


def _epoch_ns(packet: Packet) -> int:
    """Return the time exactly: a float has no room for nanoseconds."""
    seconds, _, decimals = packet.columns["frame.time_epoch"].partition(".")
    time_ns = int(seconds or 0) * 10**9 + int(f"{decimals:0<9.9}") * (-1 if seconds.startswith("-") else 1)
    if not -_LARGEST <= time_ns < _LARGEST:
        raise NoSuchTime(f"packet {packet.number} has a time that no table holds: correct it with editcap -t")
    return time_ns


def _event(code: int | None) -> dict[str, str | None]:
    known = {int(event): event.name.lower() for event in Event}
    return {"event": known.get(code or 0)}


def _telegram(packet: Packet, telegram: Telegram) -> dict[str, Any]:
    said = telegram.columns
    numbers = said.get("sis.value.number", "").split(JOINT)
    return {
        "sender": telegram.talker,
        "receiver": telegram.listener,
        "is_reaction": telegram.is_reaction,
        "service": telegram.service,
        "service_name": None if telegram.service is None else service_name(telegram.service),
        "parameter": _one(said.get("sis.parameter")),
        "value": _one(said.get("sis.value")),
        "number": float(numbers[0]) if len(numbers) == 1 and numbers[0] else None,
        "status": telegram.status if telegram.is_reaction else None,
        "error": _integer(_one(said.get("sis.error"))),
        "is_good": telegram.good,
        "is_repeat": telegram.is_repeat,
        "is_unanswered": telegram.unanswered,
        "command_packet": telegram.command_in,
        **_judged("trs", "reaction_s", telegram.reaction),
        **_judged("tza", "longest_interval_s", telegram.pause),
        **_judged("tmas", "cycle_s", telegram.cycle),
        "uncertainty_s": packet.uncertainty_s,
        "has_character_error": bool(packet.errors & _CHARACTER_ERRORS),
        "has_break": bool(packet.errors & _BREAK),
        "has_loss": bool(packet.errors & _LOST),
        "baud": packet.baud,
        "phase": _integer(telegram.phase),
        "raw": _characters(packet) if len(packet.telegrams) == 1 else None,
    }


def _characters(packet: Packet) -> bytes | None:
    """Return the characters of a record."""
    text = packet.columns.get("sertap.character")
    return bytes.fromhex(text.replace(JOINT, "").replace("0x", "")) if text else None


def _judged(limit: str, time: str, judged: Judged | None) -> dict[str, Any]:
    if not judged:
        return {}
    verdict = _VERDICTS.get(judged.verdict) if judged.verdict is not None else None
    return {time: judged.time_s or None, f"{limit}_limit_s": judged.limit_s, f"{limit}_verdict": verdict}


def _one(text: str | None) -> str | None:
    """Return the first of several values: in a list of services, that of the first service."""
    return text.partition(JOINT)[0] if text else None


def _integer(text: str | None) -> int | None:
    return int(text.partition(JOINT)[0], 0) if text else None
