# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of a report in words: the same tables for the page and for plain text."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from sistap.commands.report import curved
from sistap.commands.report.figures import SILENCE_S, Figures, Limit
from sistap.commands.report.gather import Report
from sistap.commands.report.pauses import MOST_PLACES, Pause
from sistap.commands.report.unjudged import is_unknown
from sistap.dissected.accesses.access import Parameter
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.episodes.lines import clock_of
from sistap.dissected.episodes.silence import seconds
from sistap.dissected.packets.dissection import EXCEEDED, OK, UNRESOLVED
from sistap.dissected.packets.distribution import Distribution
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER
from sistap.tap.common.calendar import local
from sistap.tap.line import drivers
from sistap.tap.records.record import Event, Framing, ms
from sistap.tap.sis import faults as faults_of_sis
from sistap.tap.sis.faults import FAULTS
from sistap.tap.sis.limits import NAMES, limit_text, told
from sistap.tap.sis.telegram import service_name

_FRAMINGS = {
    int(Framing.PROCEDURE_3964R): "handshakes and blocks of 3964R",
    int(Framing.ASCII): "lines of text",
    int(Framing.SILENCE): "frames cut by silence",
}
_TYPES = {FRAME: "telegrams", OTHER: "other characters", EVENT: "events", None: "no records of the tap"}
DAY_S = 86_400
_EXACT_S = 1e-6  # no adapter is more exact
# For a reader who does not know the bus.
GLOSSARY = (
    "TzA is the longest interval allowed from one character of a telegram to the next. After a longer one, "
    "the receiver may take a character 02 for the start of another telegram.",
    "TrS is the longest time a station may take to answer a command. TwM is how long the master waits before it sends "
    "a command again.",
    "A verdict is unresolved if the times are not exact enough: the true time may be below or above the limit. It is "
    "also unresolved if it depends on whether the character that ends an interval counts: no document says that.",
)
_LATENCY_TIMER = re.compile(r"latency timer (\d+) ms")  # in the event that begins a capture
_SHORT = {
    "TzA": "longest interval allowed between two characters",
    "TrS": "longest reaction time allowed",
    "Tmas": "longest time allowed between two master control words",
}
IDENT = r"[SP]-\d-\d{4}"  # of a parameter
_NAMED = re.compile(rf"\b(?:{IDENT}|{'|'.join(_SHORT)})\b")
ANCHOR = "episode"
EPISODES_SHOWN = curved.EPISODES
_FEW_UNMEASURED = 0.01  # of the reactions of a station: fewer do not matter
_MINUTES_S, _HOURS_S = 300.0, 7200.0  # from which on a duration is in these
_PARAMETER_OF_EPISODE = 5  # the column
PARAMETERS_SHOWN = 500  # more would be a page that nobody reads
_LIMITS = {
    "tza": ("TzA, from character to character in a telegram", "sis.tza.verdict"),
    "trs": ("TrS, from a command to its reaction", "sis.trs.verdict"),
    "tmas": ("Tmas, from master control word to master control word", "sis.tmas.verdict"),
}


class ReportTable(NamedTuple):
    """A heading, the heads of its columns (none: the first column is the head of its row), and rows of text."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    code: int | None = None  # the column with display filters
    anchor: str = ""  # the beginning of the names by which its rows are found
    links: Mapping[tuple[int, int], str] = MappingProxyType({})  # by row and column, the name of what they lead to
    kinds: Sequence[str] = ()  # of its rows, by which the page can hide them
    note: str = ""  # stands between the heading and the rows


def _measured(time_s: float | None, times: Distribution) -> str:
    """Write a figure of some times. There is none if all came in one read, or the clock was set back."""
    return "not measured" if time_s is None or not times.count else ms(time_s)


def answer(report: Report) -> list[str]:
    """Say in five lines what happened."""
    if not report.episodes and not report.figures.telegrams:
        return ["There is nothing to judge."]
    return [line.text for line in report.answer]


def legend(report: Report) -> str:
    """Say what the short names in the answer mean, and in which time zone its times are."""
    said = " ".join(answer(report))
    names = {listed.parameter.ident: listed.name for listed in report.figures.parameters if listed.name} | _SHORT
    words = [f"{short}: {names[short]}" for short in dict.fromkeys(_NAMED.findall(said)) if short in names]
    begun = local(report.figures.first_epoch_s or 0.0)
    zone = [f"Times: {begun:UTC%z}".removesuffix("+0000")] if begun and report.episodes else []
    return "; ".join([*zone, *words]) + "." if zone or words else ""


def episodes(report: Report) -> ReportTable:
    """All episodes, the worst first."""
    begin_s = report.figures.first_epoch_s or 0.0
    time_of_day = clock_of(begin_s, begin_s + report.figures.duration_s, most_s=DAY_S)
    rows = [
        (
            time_of_day(one.from_s),
            _duration(one.to_s - one.from_s) if one.lasts else "",
            one.severity.name.lower(),
            ", ".join(map(str, sorted(one.stations))),
            one.rule.title,
            one.hit.parameter,
            one.detail,
            one.rule.do,
            str(one.count),
            one.filter if report.files == 1 else one.filter_by_time,
        )
        for one in report.episodes[:EPISODES_SHOWN]
    ]
    left_out = max(len(report.episodes) - EPISODES_SHOWN, 0)
    title = "What happened" + (f" (and {left_out} more)" if left_out else "")
    named = ("Station", "What", "Parameter", "Details", "What to do", "Count", "Display filter")
    heads = ("From", "Duration", "Severity", *named)
    kinds = [one.severity.name.lower() for one in report.episodes[:EPISODES_SHOWN]]
    links = {
        (row, _PARAMETER_OF_EPISODE): place
        for parameter, place in curved.places(report).items()
        for row in curved.happened(report, parameter)
    }
    return ReportTable(title, heads, rows, code=9, anchor=ANCHOR, links=links, kinds=kinds)


def _duration(time_s: float) -> str:
    """Write a duration; nobody counts in thousands of seconds."""
    if time_s < _MINUTES_S:
        return seconds(time_s)
    minutes = round(time_s / 60)
    return f"{minutes} min" if time_s < _HOURS_S else f"{minutes // 60} h {minutes % 60} min"


def summary(report: Report) -> ReportTable:
    """What was captured, and how exact the clock was."""
    figures = report.figures
    damaged = figures.telegrams - figures.good
    rows = [
        ("Capture", report.name),
        ("Began", _date(figures.first_epoch_s)),
        ("Duration", f"{figures.duration_s:.3f} s"),
        ("Ports", ", ".join(filter(None, figures.interfaces)) or "not named"),
        ("Line", ", ".join(f"{rate} Bd {kind}" for rate, kind in figures.settings) or "not known"),
        ("Packets", f"{figures.packets}{_records(figures)}"),
        ("Telegrams", f"{figures.telegrams}, {damaged} of them with a wrong checksum or none"),
        ("Uncertainty of the times", _uncertainty(figures)),
        ("In the same read", _same_read(figures)),
        (f"Silences above {limit_text(SILENCE_S)}", str(figures.silences.long)),
    ]
    if (times := figures.frame_intervals).count:  # that are no SIS telegrams
        half, most = ms(times.within_s(0.5)), ms(times.longest_s)
        text = f"{times.count}, from character to character: half within {half}, the longest {most}"
        rows.append(("Intervals in other frames", text))
    return ReportTable("What was captured", (), rows)


def _date(epoch_s: float | None) -> str:
    if epoch_s is None:
        return "there is no packet"
    then = local(epoch_s)
    return then.strftime("%Y-%m-%d %H:%M:%S %z") if then else "a time in no calendar"


def clock(figures: Figures, time_s: float) -> str:
    """Write the time of day of a second of the capture; with the date where the capture lasts longer than a day."""
    if figures.first_epoch_s is None:
        return ""
    then = local(figures.first_epoch_s + time_s)
    if not then:
        return ""
    day = "%Y-%m-%d " if figures.duration_s > DAY_S else ""
    return then.strftime(f"{day}%H:%M:%S.") + f"{then.microsecond // 1000:03}"


def _records(figures: Figures) -> str:
    counts = Counter(figures.records)
    counts[FRAME] -= figures.framings.total()
    names = [f"{counts[kind]} {text}" for kind, text in _TYPES.items() if counts[kind]]
    names += [f"{count} {_framing(number)}" for number, count in sorted(figures.framings.items())]
    return f": {', '.join(names)}" if names else ""


def _framing(number: int) -> str:
    return _FRAMINGS.get(number, f"frames of framing {number}")


def _uncertainty(figures: Figures) -> str:
    clock = figures.exactness
    if not figures.records[FRAME] + figures.records[OTHER]:
        return "there are no times of characters"
    if not clock.is_known:
        return "unknown"
    span = ms(clock.most_s) if clock.least_s == clock.most_s else f"{ms(clock.least_s)} to {ms(clock.most_s)}"
    return f"{span}{f'; unknown in {clock.unknown} records' if clock.unknown else ''}"


def _same_read(figures: Figures) -> str:
    same_read = figures.pauses.same_read
    return f"{same_read} of {figures.pauses.count} intervals in telegrams: their length is not known"


def events(report: Report) -> ReportTable:
    """What the tap itself had to say."""
    left_out = report.figures.records[EVENT] - len(report.figures.events)
    title = "Events of the tap" + (f" (and {left_out} times more)" if left_out else "")
    rows = [
        (
            str(packet.number),
            f"{packet.time_s:.6f}",
            clock(report.figures, packet.time_s),
            _event(packet.event),
            packet.text,
        )
        for packet in report.figures.events
    ]
    return ReportTable(title, ("Packet", "Second", "Clock", "Event", "Text"), rows)


def _event(code: int | None) -> str:
    known: dict[int | None, str] = {int(event): event.name.replace("_", " ").capitalize() for event in Event}
    return known.get(code, f"Event {code}")


def verdicts(report: Report) -> ReportTable:
    """How the times that the bus limits were judged."""
    rows = []
    for name, (title, field) in _LIMITS.items():
        limit = report.figures.limits[name]
        counts = [_count(limit, verdict) for verdict in (OK, EXCEEDED, UNRESOLVED)]
        rows.append((title, limits(limit), *counts, str(limit.verdicts[None]), f"{field} == {EXCEEDED}"))
    heads = ("Limit", "Value", "Kept", "Exceeded", "Unresolved", "No limit known", "Filter for the exceeded")
    return ReportTable("Verdicts", heads, rows, code=6, note=_unresolved(report.figures))


def _unresolved(figures: Figures) -> str:
    """Say why verdicts are unresolved, and what to do about it with this adapter."""
    count = sum(limit.verdicts[UNRESOLVED] for limit in figures.limits.values())
    if not count:
        return ""
    started = " ".join(packet.text for packet in figures.events if packet.event == Event.CAPTURE_STARTED)
    timers_ms = {int(found) for found in _LATENCY_TIMER.findall(started)}
    timer = f" The latency timer of the adapter was {max(timers_ms)} ms." if timers_ms else ""
    is_known = figures.exactness.is_known
    why = f"the times are uncertain by {_uncertainty(figures)}" if is_known else "nobody knows how exact the times are"
    return f"{count} unresolved: {why}.{timer} {faults_of_sis.UNRESOLVED}"


def _count(limit: Limit, verdict: int) -> str:
    """Write how often it was judged so: 0 would look good where no limit is known."""
    return "not judged" if is_unknown(limit) else str(limit.verdicts[verdict])


def limits(limit: Limit) -> str:
    """Write the limits that held."""
    return ", ".join(map(limit_text, sorted(limit.limits_s))) or "not known"


def pauses(report: Report) -> ReportTable:
    """Which TzA each talker would keep."""
    rows = []
    for (station, baud), one in sorted(report.figures.pauses.talkers.items()):
        known = one.safe_ms is not None
        rows.append(
            (
                str(station),
                f"{baud} Bd" if baud else "",
                str(one.telegrams),
                _measured(one.longest_s, one.times),
                str(one.position or ""),
                ms(one.most_s) if known else "",
                f"{one.ratio:.0%}" if one.ratio and known else "",
                f"{one.safe_ms} ms" if known else "not known",
                f"{one.safe_alone_ms} ms" if known else "not known",
                f"fewer than 1 in {one.one_in}" if known and one.one_in > 1 else "",
                _decided(one) if one.unresolved else "",
            )
        )
    heads = ("Talker", "Rate", "Telegrams", "Longest interval", "Before character", "With its uncertainty")
    safe = ("Smallest safe TzA", "If only the pause counts")
    more = ("Share of TzA", *safe, "Longer ones (95 % sure)", "Unresolved")
    return ReportTable("TzA: intervals by talker", (*heads, *more), rows)


def _decided(one: Pause) -> str:
    """Say how exact the times would have to be to decide what is unresolved."""
    others, parts = one.unresolved - one.ambiguous, []
    if one.exact_s < _EXACT_S:
        parts.append("exactly the limit")
    elif others:
        parts.append(f"an uncertainty below {ms(one.exact_s)} decides {others if one.ambiguous else 'them'}")
    if one.ambiguous:
        verb = "depends" if one.ambiguous == 1 else "depend"
        parts.append(f"{one.ambiguous} {verb} on where TzA begins to count")
    return f"{one.unresolved}; {', '.join(parts)}"


def places(report: Report) -> ReportTable:
    """Where in a telegram the intervals are long."""
    rows = [
        (
            before(place),
            str(one.count),
            ms(one.average_s),
            ms(one.within_s(0.99)),
            ms(one.longest_s),
        )
        for place, one in sorted(report.figures.pauses.places.items())
    ]
    return ReportTable(
        "TzA: intervals by place", ("Before character", "Intervals", "Average", "99 % within", "Longest"), rows
    )


def before(place: int) -> str:
    """Write before which character of a telegram an interval is."""
    return f"{place}{' and later' * (place == MOST_PLACES)}"


def faults(report: Report) -> ReportTable:
    """What was found, and the display filter that finds all of it."""
    counts = report.figures.faults
    rows = [
        (fault.title, str(counts[fault.name]), fault.filter, fault.do if counts[fault.name] else "") for fault in FAULTS
    ]
    note = (
        "Every packet counts here, and each telegram in it. Above, packets that belong together are one: a silence has "
        "many commands."
    )
    heads = ("What", "How often", "Display filter for all of them", "What to do")
    return ReportTable("Faults", heads, rows, code=2, note=note)


def services(report: Report) -> ReportTable:
    """Reaction times by service."""
    rows = []
    for number, service in sorted(report.figures.services.items()):
        times = service.times
        shown = [times.shortest_s, times.average_s, times.within_s(0.5), times.within_s(0.99), times.longest_s]
        cells = [_measured(time_s, times) for time_s in shown]
        name = f"0x{number:02x} {service_name(number)}"
        judged = [_count(service.trs, verdict) for verdict in (EXCEEDED, UNRESOLVED)]
        rows.append((name, str(times.count), *cells, limits(service.trs), *judged))
    heads = ("Service", "Reactions", "Shortest", "Average", "Half within", "99 % within", "Longest")
    return ReportTable("Reaction times by service", (*heads, "TrS", "Exceeded", "Unresolved"), rows)


def stations(report: Report) -> ReportTable:
    """A row for each station that spoke or was asked."""
    rows = []
    for address, station in sorted(report.figures.stations.items()):
        times = station.times
        counts = [station.commands, station.reactions, station.errors, station.repeats, station.unanswered]
        reactions = [_measured(time_s, times) for time_s in (times.within_s(0.5), times.longest_s)]
        shown = reactions if station.reactions else ["", ""]
        longest_s = report.figures.pauses.longest_s(address)
        pause = ms(longest_s) if longest_s else ""
        exceeded = [_count(limit, EXCEEDED) for limit in (station.trs, station.tza)]
        rows.append((str(address), *map(str, counts), *shown, pause, *exceeded))
    heads = ("Station", "Commands", "Reactions", "With an error", "Sent again", "Not answered")
    times_heads = ("Half of its reactions within", "Slowest reaction", "Longest interval in a telegram")
    return ReportTable("Stations", (*heads, *times_heads, "TrS exceeded", "TzA exceeded"), rows)


def parameters(report: Report) -> ReportTable:
    """A row for each parameter that was read or written."""
    listing = report.figures.parameters
    left_out = max(len(listing) - PARAMETERS_SHOWN, 0)
    title = "Parameters" + (f" (and {left_out} more: `sistap parameters` lists all)" if left_out else "")
    ports = {listed.parameter.port for listed in listing}
    rows = [_parameter(listed, has_port=len(ports) > 1) for listed in itertools.islice(listing, PARAMETERS_SHOWN)]
    heads = ("Parameter", "Device", "Name", "Unit", "Reads", "Writes", "Errors", "First", "Last", "Least", "Greatest")
    places = curved.places(report)
    links = {(row, 0): places[listed.parameter] for row, listed in enumerate(listing) if listed.parameter in places}
    return ReportTable(title, (*heads, "Written by", "In packet"), rows, links=links)


def _parameter(listed: Listed, *, has_port: bool) -> tuple[str, ...]:
    counts = [str(count) if count else "" for count in (listed.reads, listed.writes, listed.errors)]
    extremes = [access.value if access else "" for access in (listed.least, listed.greatest)]
    written = ["", ""]
    if listed.written_in:
        written = ["" if listed.written_by is None else str(listed.written_by), str(listed.written_in.packet)]
    device = of_device(listed.parameter, has_port=has_port)
    return (
        *(listed.parameter.ident, device, listed.name, listed.unit, *counts),
        *(listed.first, listed.last, *extremes, *written),
    )


def of_device(parameter: Parameter, *, has_port: bool = False) -> str:
    """Write whose parameter it is."""
    port = f"{parameter.port}, " if has_port else ""
    return f"{port}station {parameter.station}, device {parameter.device}"


def remarks(report: Report) -> list[str]:
    """What a reader has to know before believing the figures, a sentence or two each."""
    return [text for text, applies in _remarks(report) if applies]


def _unmeasured(figures: Figures) -> Iterator[str]:
    """Yield how many reactions of a station have no time, if they matter."""
    for address, station in sorted(figures.stations.items()):
        missing = station.reactions - station.times.count
        if missing > _FEW_UNMEASURED * station.reactions:
            yield f"station {address} ({missing} of {station.reactions})"


def _remarks(report: Report) -> Iterable[tuple[str, object]]:
    figures = report.figures
    records = figures.records[FRAME] + figures.records[OTHER] + figures.records[EVENT]
    yield f"tshark could not read the capture to its end: {report.warning}", report.warning
    yield from ((text, True) for text in report.left_out)
    yield "The capture has no packets.", not figures.packets
    yield "The capture has no SIS telegrams.", figures.packets and not figures.telegrams
    others = " and ".join(f"{count} {_framing(number)}" for number, count in sorted(figures.framings.items()))
    yield f"It has {others}: their limits are not judged here.", figures.framings
    yield (
        "The packets are no records of the tap: there are no times of characters, no verdicts on TzA, and a reaction "
        "time is that from packet to packet.",
        figures.packets and not records,
    )
    yield (
        f"The installed dissector does not know {', '.join(report.missing)}; what they would tell is left out.",
        report.missing,
    )
    said = [packet.text for packet in figures.events if packet.event == Event.CAPTURE_STARTED]
    silent = any(drivers.reports(text) is False for text in said)
    yield "The adapter reports no line errors: damaged characters look like good ones.", silent
    yield (
        "Telegrams are damaged, but there is not one line error: they were sent so, or the adapter reports none.",
        not silent
        and any(map(drivers.reports, said))
        and figures.telegrams > figures.good
        and not figures.faults["line_error"],
    )
    yield (
        f"The packet numbers count through all {report.files} files in the order of their time. "
        "`mergecap -a -w all.pcapng FILES` makes the capture that has them.",
        report.files > 1,
    )
    yield (
        "A recorder kept these files one by one: between two of them nothing was kept, and no silence is told.",
        report.files > 1 and any(packet.is_kept_apart for packet in figures.events),
    )
    unmeasured = ", ".join(_unmeasured(figures))
    yield (
        f"Reactions that came in one read with their command, or without one, are in no median: {unmeasured}. "
        f"Uncertainty of the times: {_uncertainty(figures)}.",
        unmeasured,
    )
    yield from ((text, True) for text in _told(report))
    for name, text in NAMES.items():
        judged = figures.limits[name]
        yield (
            f"{text} was not set (service 0x03) while this was captured, so nothing is judged by it. If you know it, "
            f"add --{name} MS.",
            judged.verdicts and not judged.limits_s and f"sis.{name}.limit" not in report.missing,
        )


def _told(report: Report) -> Iterable[str]:
    """Say which limits a person told, and when."""
    for text in sorted({packet.text for packet in report.figures.events if packet.event == Event.LIMITS_TOLD}):
        yield f"The limits {text} were given for this capture (--tza, --trs). They apply until the bus sets others."
    if here := told(report.limits_ms):
        yield f"Judged by {here}, as given for this report (--tza, --trs), in place of the limits set on the bus."
