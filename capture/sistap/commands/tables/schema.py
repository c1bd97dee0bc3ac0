# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables: their columns, in the order in which they are written, and what makes two rows equal.

Integers are signed and times are whole microseconds: Spark reads neither unsigned integers nor nanoseconds.
"""

from __future__ import annotations

from typing import NamedTuple

import pyarrow as pa


class StoredTable(NamedTuple):
    """A table."""

    schema: pa.Schema
    same: tuple[str, ...]  # columns: rows that are equal in these are one telegram, seen in two captures


_TIME = pa.timestamp("us", tz="UTC")
_TEXT = pa.dictionary(pa.int32(), pa.string())  # few values, often repeated
_PLACE = [
    ("time", _TIME),
    ("epoch_ns", pa.int64()),
    ("port", _TEXT),
    ("line", pa.int16()),
    ("file", _TEXT),
    ("packet", pa.int64()),
    ("place", pa.int16()),
]

TABLES = {
    "telegrams": StoredTable(
        pa.schema(
            [
                *_PLACE,
                ("sender", pa.int16()),
                ("receiver", pa.int16()),
                ("is_reaction", pa.bool_()),
                ("service", pa.int16()),
                ("service_name", _TEXT),
                ("parameter", _TEXT),
                ("value", pa.string()),
                ("number", pa.float64()),
                ("status", pa.int16()),
                ("error", pa.int64()),
                ("is_good", pa.bool_()),
                ("is_repeat", pa.bool_()),
                ("is_unanswered", pa.bool_()),
                ("command_packet", pa.int64()),
                ("reaction_s", pa.float64()),
                ("trs_limit_s", pa.float64()),
                ("trs_verdict", _TEXT),
                ("longest_interval_s", pa.float64()),
                ("tza_limit_s", pa.float64()),
                ("tza_verdict", _TEXT),
                ("cycle_s", pa.float64()),
                ("tmas_limit_s", pa.float64()),
                ("tmas_verdict", _TEXT),
                ("uncertainty_s", pa.float64()),
                ("has_character_error", pa.bool_()),
                ("has_break", pa.bool_()),
                ("has_loss", pa.bool_()),
                ("baud", pa.int64()),
                ("phase", pa.int16()),
                ("raw", pa.binary()),
            ]
        ),
        ("epoch_ns", "line", "place", "sender", "receiver", "service", "is_reaction"),
    ),
    "values": StoredTable(
        pa.schema(
            [
                *_PLACE,
                ("station", pa.int16()),
                ("route", _TEXT),
                ("device", pa.int16()),
                ("parameter", _TEXT),
                ("name", _TEXT),
                ("unit", _TEXT),
                ("is_write", pa.bool_()),
                ("master", pa.int16()),
                ("value", pa.string()),
                ("number", pa.float64()),
                ("error", _TEXT),
            ]
        ),
        ("epoch_ns", "line", "place", "station", "route", "device", "parameter", "is_write"),
    ),
    "events": StoredTable(
        pa.schema([*_PLACE, ("code", pa.int32()), ("event", _TEXT), ("text", pa.string())]),
        ("epoch_ns", "line", "place", "code", "text"),
    ),
    "episodes": StoredTable(
        pa.schema(
            [
                *_PLACE,
                ("until", _TIME),
                ("kind", _TEXT),
                ("severity", _TEXT),
                ("station", pa.int16()),
                ("parameter", _TEXT),
                ("count", pa.int64()),
                ("worst", pa.float64()),
                ("text", pa.string()),
            ]
        ),
        ("epoch_ns", "kind", "station", "parameter"),
    ),
}
