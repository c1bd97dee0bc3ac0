# SPDX-License-Identifier: GPL-2.0-or-later
"""The report without pictures: as text for people, as JSON for programs."""

from __future__ import annotations

import json
import textwrap
from typing import Any

from sistap.commands.report import tables
from sistap.commands.report.figures import Figures, Limit, StationFigures
from sistap.commands.report.gather import Report
from sistap.commands.report.pauses import Pause, Talker
from sistap.commands.report.unjudged import unjudged
from sistap.commands.report.windows import ReportWindow
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.episodes.lines import things
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import EXCEEDED, OK, UNRESOLVED, Packet
from sistap.dissected.packets.distribution import Distribution
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER
from sistap.tap.common.table import aligned
from sistap.tap.sis.faults import FAULTS
from sistap.tap.sis.telegram import service_name

WIDTH = 72  # characters of the lines that answer: a mail has room for them


def as_text(report: Report, title: str = "", note: str = "") -> str:
    """Write all tables, columns aligned, below a title and a note."""
    shown = [
        tables.episodes,
        tables.summary,
        tables.events,
        tables.verdicts,
        tables.pauses,
        tables.places,
        tables.faults,
        tables.services,
    ]
    parts = [
        title,
        note,
        "\n".join(textwrap.fill(line, WIDTH, subsequent_indent="  ") for line in tables.answer(report)),
        textwrap.fill(tables.legend(report), WIDTH),
        *tables.remarks(report),
        *(_table(make(report)) for make in [*shown, tables.stations, tables.parameters]),
        "\n".join(["Words", "-----", *tables.GLOSSARY]),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _table(table: tables.ReportTable) -> str:
    if not table.rows:
        return ""
    rows = [table.heads, *table.rows] if table.heads else table.rows
    note = [textwrap.fill(table.note, WIDTH)] if table.note else []
    return "\n".join([table.title, "-" * len(table.title), *note, *aligned(rows)])


def as_json(report: Report) -> str:
    """Write all figures; times in s, the names say so."""
    return json.dumps(_report(report), indent=2, allow_nan=False) + "\n"


def _report(report: Report) -> dict[str, Any]:
    figures, answer = report.figures, report.answer
    told = {id(one) for line in answer for phrase in line.phrases for one in (phrase.episode, *phrase.others)}
    severities = [one.severity for one in report.episodes]
    in_time = sorted(report.episodes, key=lambda one: one.from_s)
    return {
        "capture": report.name,
        "warning": report.warning,
        "left_out": report.left_out,
        "missing_fields": report.missing,
        "ok": Severity.ERROR not in severities,
        "look": things(report.episodes),
        "counts": {
            severity.name.lower(): severities.count(severity)
            for severity in (Severity.ERROR, Severity.WARNING, Severity.NOTE)
        },
        "answer": tables.answer(report),
        "not_judged": unjudged(report.figures),
        "episodes": [one.as_json() | {"told": id(one) in told} for one in in_time],
        "began_epoch_s": figures.first_epoch_s,
        "duration_s": figures.duration_s,
        "ports": list(figures.interfaces),
        "lines": [f"{rate} Bd {kind}" for rate, kind in figures.settings],
        "packets": figures.packets,
        "records": {
            "telegrams": figures.records[FRAME] - figures.framings.total(),
            "other_characters": figures.records[OTHER],
            "events": figures.records[EVENT],
        },
        "other_frames": {str(number): count for number, count in sorted(figures.framings.items())},
        "telegrams": {"all": figures.telegrams, "damaged": figures.telegrams - figures.good},
        "clock": _clock(figures),
        "events": [_event(packet) for packet in figures.events],
        "limits": {name: _limit(limit) for name, limit in figures.limits.items()},
        "tza_by_talker": [_pause(*found) for found in sorted(figures.pauses.talkers.items())],
        "tza_by_character": [
            {"before_character": place, "count": one.count, "average_s": one.average_s}
            | {"longest_s": one.longest_s, "histogram": _histogram(one)}
            for place, one in sorted(figures.pauses.places.items())
        ],
        "faults": {fault.name: figures.faults[fault.name] for fault in FAULTS},
        "silences": {
            "above_200_ms": figures.silences.long,
            "longest_s": figures.silences.longest_s or None,
            "longest_before_packet": figures.silences.before,
        },
        "intervals": _distribution(figures.pauses.intervals),
        "other_frame_intervals": _distribution(figures.frame_intervals),
        "services": [
            {"service": number, "name": service_name(number), "times": _distribution(service.times)}
            | {"trs": _limit(service.trs)}
            for number, service in sorted(figures.services.items())
        ],
        "stations": [
            _station(address, station) | {"longest_pause_s": figures.pauses.longest_s(address) or None}
            for address, station in sorted(figures.stations.items())
        ],
        "parameters": [_parameter(listed) for listed in figures.parameters],
        "windows": [_window(window) for window in report.windows],
    }


def _clock(figures: Figures) -> dict[str, Any]:
    clock = figures.exactness
    return {
        "uncertainty_least_s": clock.least_s if clock.is_known else None,
        "uncertainty_most_s": clock.most_s if clock.is_known else None,
        "records_without_uncertainty": clock.unknown,
        "intervals_in_one_read": figures.pauses.same_read,
    }


def _event(packet: Packet) -> dict[str, Any]:
    return {"packet": packet.number, "time_s": packet.time_s, "code": packet.event, "text": packet.text}


def _limit(limit: Limit) -> dict[str, Any]:
    names = {OK: "ok", EXCEEDED: "exceeded", UNRESOLVED: "unresolved", None: "no_limit"}
    counts = {name: limit.verdicts[verdict] for verdict, name in names.items()}
    return {"limits_s": sorted(limit.limits_s)} | counts


def _distribution(times: Distribution) -> dict[str, Any]:
    if not times.count:
        return {"count": 0}
    return {
        "count": times.count,
        "shortest_s": times.shortest_s,
        "average_s": times.average_s,
        "half_within_s": times.within_s(0.5),
        "99_percent_within_s": times.within_s(0.99),
        "longest_s": times.longest_s,
    }


def _histogram(times: Distribution) -> list[dict[str, Any]]:
    counts, edges = times.bars()
    return [
        {"from_s": edges[number], "to_s": edges[number + 1], "count": count}
        for number, count in enumerate(counts)
        if count
    ]


def _pause(talker: Talker, pause: Pause) -> dict[str, Any]:
    return {
        "station": talker.station,
        "baud": talker.baud or None,
        "telegrams": pause.telegrams,
        "longest_s": pause.longest_s or None,
        "before_character": pause.position,
        "longest_with_uncertainty_s": pause.most_s,
        "part_of_limit": pause.ratio or None,
        "histogram": _histogram(pause.times),
        "smallest_safe_ms": pause.safe_ms,
        "smallest_safe_ms_of_pause_alone": pause.safe_alone_ms,
        "longer_at_most_one_in": pause.one_in,
        "unresolved": pause.unresolved,
        "depends_on_what_counts": pause.ambiguous,
        "resolved_if_more_exact_than_s": pause.exact_s if pause.unresolved > pause.ambiguous else None,
    }


def _station(address: int, station: StationFigures) -> dict[str, Any]:
    return {
        "station": address,
        "commands": station.commands,
        "reactions": station.reactions,
        "reactions_with_error": station.errors,
        "sent_again": station.repeats,
        "not_answered": station.unanswered,
        "reaction_times": _distribution(station.times),
        "trs": _limit(station.trs),
        "tza": _limit(station.tza),
    }


def _parameter(listed: Listed) -> dict[str, Any]:
    return {
        **listed.parameter._asdict(),
        **{name: getattr(listed, name) for name in ("name", "unit", "minimum", "maximum")},
        **{name: getattr(listed, name) for name in ("reads", "writes", "errors", "first", "last")},
        "least": listed.least.number if listed.least else None,
        "greatest": listed.greatest.number if listed.greatest else None,
        "written_by": listed.written_by,
        "written_in": listed.written_in.packet if listed.written_in else None,
    }


def _window(window: ReportWindow) -> dict[str, Any]:
    return {
        "title": window.title,
        "start_s": window.start_s,
        "end_s": window.end_s,
        "packets": [packet.number for packet in window.packets],
        "packets_left_out": window.left_out,
    }
