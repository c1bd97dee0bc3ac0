# SPDX-License-Identifier: GPL-2.0-or-later
"""Time stamps in the text of a log: ISO, German, American and 12-hour forms, with or without a date; plain seconds.

Without a zone a stamp is local time, as programs write it. Times are ns since 1970.
"""

from __future__ import annotations

import re
import time
from datetime import UTC, datetime, timedelta, timezone
from typing import NamedTuple

_SECOND_NS = 1_000_000_000
_HALF_DAY_NS = 43_200 * _SECOND_NS
# The date of stamps without one, until a date comes. It is the second day: in the east the first began before 1970.
_NO_DATE = (1970, 1, 2)
_CENTURY = 2000

_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec".split()
_DATE = (
    r"(?:(?P<year>\d{4})[-/.](?P<month>\d\d?)[-/.](?P<day>\d\d?)"
    r"|(?P<day_german>\d\d?)\.(?P<month_german>\d\d?)\.(?P<year_german>\d{4}|\d\d)"
    r"|(?P<one>\d\d?)/(?P<other>\d\d?)/(?P<year_slash>\d{4}|\d\d)"
    rf"|(?P<day_name>\d\d?)[ -](?P<month_name>(?i:{'|'.join(_MONTHS)}))[a-z]*\.?[ -](?P<year_name>\d{{4}}))"
)
# A fraction after a comma or colon has three digits or more, or no byte can follow: "10:20:30,02 6C" may be bytes.
_CLOCK = (
    r"(?P<hour>\d\d?):(?P<minute>\d\d)(?::|\s(?=\d\d\.\d{6}\]))(?P<second>\d\d)"
    r"(?:\.(?P<fraction>\d{3},\d{3}(?=\])|\d{1,9})|[,:](?P<thousandths>\d{3,9}|\d\d?(?=[;\])]|\s+[^\w\s]|\s+[G-Zg-z])))?"
    r"(?:\s?(?P<half>[AaPp])\.?[Mm]\b\.?(?:\.(?P<behind>\d{1,9}))?)?(?:\s?(?P<zone>Z|[+-]\d\d:?\d\d)(?!\w))?"
)
# Not inside other numbers, nor part of bytes that are joined with colons.
_BEFORE, _AFTER = r"(?<![\d:.,/-])(?<!:[0-9A-Fa-f])", r"(?!\d|[:.][0-9A-Fa-f])"
_STAMP = re.compile(rf"{_BEFORE}(?:{_DATE}[T_,;:]?\s*(?:-\s*)?)?{_CLOCK}{_AFTER}")
_DATE_ALONE = re.compile(rf"{_BEFORE}{_DATE}(?![\d:./-])")
_SECONDS = re.compile(
    r"^\s*(?:[\[(]\s*)?(?P<seconds>\d{1,10})(?:\.|,(?=\d{3,9};))(?P<fraction>\d{3,9})\d*\s*[\])]?(?=[\s:;,]|$)"
)
# Since 1970 in ms or ns. Bytes that are joined have an even number of digits, and those of us are left out for that.
_EPOCH = re.compile(r"(?<![\w.])(?P<seconds>[12]\d{9})(?P<fraction>\d{3}(?:\d{6})?)(?![\w.])")

_LATEST_S = 9_150_000_000  # in the year 2259: the dissectors have no later time
_YEARS = range(1970, 2259)  # a date of another year is ignored; its time of day is used

_Date = tuple[int, int, int]
_Minute = tuple[_Date, int, int, str | None]  # hour, minute, zone


class Stamp(NamedTuple):
    """When something was logged, and the step between such stamps; both in ns."""

    time_ns: int
    resolution_ns: int


class Stamped(NamedTuple):
    """A stamp and where it stands in its text."""

    start: int
    end: int
    stamp: Stamp


class TimestampParser:
    """Reads the stamps of one log, in order: a stamp without a date needs those before it."""

    def __init__(self) -> None:
        self._date = _NO_DATE
        self._last_ns = 0
        self._minute: tuple[_Minute, int | None] | None = None  # the last one: a log has many stamps in a minute

    def find(self, text: str) -> list[Stamped]:
        """Find all stamps of a line. Text in the form of a stamp that is no valid time is ignored."""
        found = []
        end = 0
        # Most of a line are bytes behind its last stamp. Without a colon there is none.
        while text.find(":", end) >= 0 and (match := _STAMP.search(text, end)):
            end = match.end()
            if stamp := self._stamp(match):
                found.append(Stamped(match.start(), end, stamp))
        return found or self._seconds(text)

    def find_date(self, text: str) -> Stamped | None:
        """Find and keep a date without a time, such as in the heading of a log; its stamp is its midnight."""
        match = _DATE_ALONE.search(text)
        date = _date(match) if match else None
        if not match or not date or not (midnight := _seconds_of((date, 0, 0, None))):
            return None
        self._date, self._last_ns = date, 0
        return Stamped(match.start(), match.end(), Stamp(midnight * _SECOND_NS, 0))

    def _stamp(self, match: re.Match[str]) -> Stamp | None:
        date = _date(match)
        hour, second = int(match["hour"]), int(match["second"])
        if half := match["half"]:
            if not 1 <= hour <= 12:
                return None
            hour = hour % 12 + (12 if half in "Pp" else 0)
        fraction = (match["fraction"] or match["thousandths"] or match["behind"] or "").replace(",", "")
        minute = self._seconds_of((date or self._date, hour, int(match["minute"]), match["zone"]))
        if minute is None or second > 60:
            return None
        time_ns = (minute + second) * _SECOND_NS + int(fraction.ljust(9, "0"))
        if date:
            self._date = date
        elif time_ns < self._last_ns - _HALF_DAY_NS:  # it is past midnight
            year, month, day = self._date
            tomorrow = datetime(year, month, day, tzinfo=UTC) + timedelta(days=1)
            self._date = (tomorrow.year, tomorrow.month, tomorrow.day)
            time_ns += 2 * _HALF_DAY_NS
        self._last_ns = time_ns
        return Stamp(time_ns, 10 ** (9 - len(fraction)))

    def _seconds_of(self, minute: _Minute) -> int | None:
        if self._minute is None or self._minute[0] != minute:
            self._minute = minute, _seconds_of(minute)
        return self._minute[1]

    def _seconds(self, text: str) -> list[Stamped]:
        match = _SECONDS.match(text) or _EPOCH.search(text)
        if not match:
            return []
        fraction = match["fraction"]
        if int(match["seconds"]) > _LATEST_S:
            return []
        time_ns = int(match["seconds"]) * _SECOND_NS + int(fraction.ljust(9, "0"))
        return [Stamped(match.start(), match.end(), Stamp(time_ns, 10 ** (9 - len(fraction))))]


def _date(match: re.Match[str]) -> _Date | None:
    """Return year, month and day of whichever form matched."""
    form: tuple[str | None, ...]
    if match["year"]:
        form = match["year"], match["month"], match["day"]
    elif match["year_german"]:
        form = match["year_german"], match["month_german"], match["day_german"]
    elif match["year_slash"]:
        # American order, unless the month would be above 12.
        one, other = match["one"], match["other"]
        form = (match["year_slash"], other, one) if int(one or 0) > 12 else (match["year_slash"], one, other)
    elif match["month_name"]:
        month = _MONTHS.index(match["month_name"].lower()) + 1
        form = match["year_name"], str(month), match["day_name"]
    else:
        return None
    year, month_number, day = (int(text or 0) for text in form)
    year += _CENTURY if year < 100 else 0
    return (year, month_number, day) if year in _YEARS else None


def _seconds_of(of: _Minute) -> int | None:
    """Return seconds since 1970; None if there is no such minute."""
    date, hour, minute, zone = of
    try:
        at = datetime(*date, hour, minute, tzinfo=_zone(zone) if zone else None)
        seconds = int(at.timestamp()) if zone else int(time.mktime((*date, hour, minute, 0, 0, 0, -1)))
    except (ValueError, OverflowError):
        return None
    return seconds if seconds >= 0 else None


def _zone(text: str) -> timezone:
    if text == "Z":
        return UTC
    offset = timedelta(hours=int(text[1:3]), minutes=int(text[-2:]))
    return timezone(-offset if text[0] == "-" else offset)
