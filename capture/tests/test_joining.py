# SPDX-License-Identifier: GPL-2.0-or-later
"""Several captures read as one."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from datetime import datetime
from pathlib import Path

import pytest
from commands import refused, run

from sistap.dissected.captures import joining, reading
from sistap.dissected.captures.joining import in_order
from sistap.dissected.captures.portions import TOGETHER, Portion, in_turn
from sistap.tap.files import pcapng
from sistap.tap.files.pcapng import Interface
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import INTERVAL_MAX, Event, Record, Type, event
from sistap.tap.sis.telegram import build
from sistap.tap.terminal.exits import NotCaptured

SECOND = 1_000_000_000
NAMES = ("left", "right")
COURSE = Path(__file__).parents[2] / "test-captures" / "course"


def written(path: Path, packets: Sequence[tuple[int, int]], names: Sequence[str] = NAMES) -> Path:
    """Write a capture of these interfaces; a packet is the number of its interface, and its second."""
    blocks = [pcapng.section_header("test", "")]
    blocks += [pcapng.interface_description(Interface(147, name)) for name in names]
    blocks += [pcapng.enhanced_packet(number, second * SECOND, bytes([second])) for number, second in packets]
    path.write_bytes(b"".join([*blocks, pcapng.interface_statistics(0, pcapng.Statistics(0, 0, 1, 1, 0))]))
    return path


def content(path: Path) -> list[tuple[str, int]]:
    """Return interface and second of each packet."""
    names: list[str] = []
    found = []
    with path.open("rb") as file:
        for kind, _, body in reading.blocks(file, path):
            if kind == pcapng.INTERFACE_DESCRIPTION:
                names.append(next(name for name in (*NAMES, "other") if name.encode() in body))
            elif kind == pcapng.ENHANCED_PACKET:
                found.append((names[body[0]], body[20]))
    assert len(set(names)) == len(names)
    return found


@contextmanager
def together(captures: Sequence[Path], say: Callable[[str], None], most: int = TOGETHER) -> Iterator[Portion]:
    """Read captures as one portion."""
    with closing(in_turn(captures, most, say)) as portions:
        yield next(portions)


def test_a_file_that_a_recorder_deletes_meanwhile_is_told(tmp_path: Path) -> None:
    files = [written(tmp_path / name, [(0, second)]) for second, name in enumerate("abc", 1)]
    files[1].unlink()
    said: list[str] = []
    with together(files, said.append) as joined:
        assert content(joined.path) == [("left", 1), ("left", 3)]
        assert joined.place(2) == (files[2], 1)
    assert said == [f"{files[1]}: only what comes before the damage: No such file or directory"]


def test_equal_interfaces_are_one(tmp_path: Path) -> None:
    captures = [
        written(tmp_path / "a", [(0, 1), (1, 2)]),
        written(tmp_path / "b", [(1, 3), (0, 4), (2, 5)], ["right", "left", "other"]),
    ]
    with together(captures, pytest.fail) as joined:
        assert content(joined.path) == [("left", 1), ("right", 2), ("left", 3), ("right", 4), ("other", 5)]
        places = [(path.name, number) for path, number in map(joined.place, range(1, 6))]
        assert places == [("a", 1), ("a", 2), ("b", 1), ("b", 2), ("b", 3)]
    assert not joined.path.exists()


@pytest.mark.parametrize("most", [1, 60, 120, 200])
def test_a_packet_is_named_as_in_its_capture_wherever_it_is_cut(tmp_path: Path, most: int) -> None:
    captures = [
        written(tmp_path / name, [(0, first), (1, first + 1), (0, first + 2)]) for name, first in (("a", 1), ("b", 4))
    ]
    found = []
    for portion in in_turn(captures, most, pytest.fail):
        own = [number for number, _ in enumerate(content(portion.path), 1) if portion.owns(number)]
        found += [(path.name, number) for path, number in map(portion.place, own)]
    assert found == [("a", 1), ("a", 2), ("a", 3), ("b", 1), ("b", 2), ("b", 3)]


def test_a_single_one_stays_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "junk"
    path.write_bytes(b"junk")
    with together([path], pytest.fail) as joined:
        assert (joined.path, joined.place(7)) == (path, (path, 7))


def test_the_order_is_that_of_their_time(tmp_path: Path) -> None:
    late, early, foreign = written(tmp_path / "a", [(0, 9)]), written(tmp_path / "b", [(0, 2)]), tmp_path / "c"
    foreign.write_bytes(b"no capture")
    assert in_order([late, early]) == [early, late]
    assert in_order([late, foreign, early]) == [late, foreign, early]


def test_portions_are_bounded(tmp_path: Path) -> None:
    captures = [written(tmp_path / name, [(0, second)]) for second, name in enumerate("abcd", 1)]
    two = 2 * len(next(joining.packets(captures[0], pytest.fail)).body)
    counts = [portion.own for portion in in_turn(captures, two - 1, pytest.fail)]
    assert counts == [2, 2]
    captures[1].write_bytes(b"foreign")
    with pytest.raises(NotCaptured, match="save it as pcapng"):
        next(in_turn(captures, TOGETHER, pytest.fail))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data[:-100], "is cut off"),
        (lambda data: data[:-120] + b"\xff" * 120, "is damaged"),
        (lambda data: data.replace(b"\6\0\0\0\x24\0\0\0\1", b"\6\0\0\0\x24\0\0\0\x63"), "interface 99"),
    ],
)
def test_what_comes_before_a_damage_is_read(tmp_path: Path, change: object, words: str) -> None:
    captures = [written(tmp_path / "a", [(0, 1), (1, 2)]), written(tmp_path / "b", [(0, 3)])]
    captures[0].write_bytes(change(captures[0].read_bytes()))  # type: ignore[operator]
    said: list[str] = []
    with together(captures, said.append) as joined:
        assert content(joined.path) == [("left", 1), ("left", 3)]
    (text,) = said
    assert text.startswith(f"{captures[0]}: only what comes before the damage: ") and words in text


def record(data: bytes, second: int) -> Record:
    return Record(second * SECOND, Type.FRAME, 0, LineSettings(), data, [0] * len(data), bytes(len(data)), 0)


def exchange(control: int, data: bytes, second: int) -> list[Record]:
    """Read an element of S-0-0040 of device 5."""
    asked, said = bytes([control, 5, 0, 40, 0]), bytes([0, control, 5]) + data
    return [record(build(0x10, 16, 3, asked), second), record(build(0x10, 16, 3, said, reaction=True), second)]


def ring(folder: Path) -> list[str]:
    """Write two files: values, and afterwards their attribute, 0x02210001: 2 bytes, signed, 2 decimal places."""
    start = event(SECOND, 0, LineSettings(), Event.CAPTURE_STARTED, "from a test")
    told = [one._replace(type=Type.BEFORE) for one in exchange(0x24, b"Nm", 5)]
    files = {
        "a": [start, *exchange(0x24, b"Nm", 1), *exchange(0x3C, b"\xf4\1", 2), *exchange(0x3C, b"\x18\xfc", 3)],
        "b": [start._replace(time_ns=5 * SECOND), *told, *exchange(0x1C, bytes.fromhex("01002102"), 6)],
    }
    files["b"] += exchange(0x3C, b"\xc4\t", 7)
    for name, records in files.items():
        blocks = [pcapng.section_header("test", ""), pcapng.interface_description(Interface(252, "port"))]
        blocks += [pcapng.enhanced_packet(0, one.time_ns, pcapng.upper_pdu("sertap", one.pack())) for one in records]
        (folder / name).write_bytes(b"".join(blocks))
    return ["b", "a"]  # in the wrong order


def test_values_of_an_earlier_file_are_decoded_afterwards(tmp_path: Path) -> None:
    (head, row) = run(tmp_path, "parameters", *ring(tmp_path)).stdout.splitlines()
    cells = "3 5 S-0-0040 Velocity feedback value 1 Nm 3 0 0 5.00 Nm 25.00 Nm -10.00 Nm 25.00 Nm"
    assert row.split() == cells.split()
    assert "Bytes" not in head


def test_values_that_are_left_out_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The attribute was read in a file that is too large to be read together with them, long after them."""
    from sistap import cli  # noqa: PLC0415
    from sistap.commands.parameters import reading as of_parameters  # noqa: PLC0415
    from sistap.dissected.captures import portions  # noqa: PLC0415

    monkeypatch.setattr(of_parameters, "_TOGETHER", 1)
    monkeypatch.setattr(portions, "_AROUND", 1)
    assert cli.main(["parameters", *(str(tmp_path / name) for name in ring(tmp_path))]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert "Greatest  Bytes" in head
    assert row.split()[-5:] == ["25.00", "Nm", "25.00", "Nm", "2"]


@pytest.mark.parametrize("option", ["--changes", "--csv"])
@pytest.mark.parametrize("most", [1, 700, 1500])
def test_a_large_capture_has_the_parameters_of_the_whole(
    option: str, most: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wherever it is cut: writes, refusals, names and units are there."""
    from sistap import cli  # noqa: PLC0415
    from sistap.commands.parameters import reading as of_parameters  # noqa: PLC0415
    from sistap.dissected.captures import portions  # noqa: PLC0415

    command = ["parameters", option, str(COURSE / "03-parameters.pcapng")]
    assert cli.main(command) == 0
    whole = capsys.readouterr().out
    assert "S-0-0036" in whole and "rpm" in whole
    monkeypatch.setattr(of_parameters, "_TOGETHER", most)
    monkeypatch.setattr(portions, "_AROUND", 12)  # else each portion has all of it
    assert cli.main(command) == 0
    assert capsys.readouterr().out == whole


def kept(folder: Path, before_ns: int) -> list[str]:
    """Write two files of a recorder, half an hour apart: a master asks each second, and drive 3 leaves the last two
    commands of the first file and the first two of the second without a reaction. The character before the second
    file was not kept, but how long it was ago.
    """
    told = [one._replace(type=Type.BEFORE) for one in exchange(0x24, b"Nm", 1800)]
    for name, from_s, silent, more in (("kept_1", 10, (28, 29), []), ("kept_2", 1800, (0, 1), told)):
        text = f"from a test; kept: unanswered at 1970-01-01 00:00:{from_s}.000"
        records = [event(from_s * SECOND, 0, LineSettings(), Event.CAPTURE_STARTED, text), *more]
        for second in range(30):
            command, reaction = exchange(0x3C, b"\xf4\1", from_s + second)
            intervals = [SECOND if second else before_ns, *command.intervals[1:]]
            records += [command._replace(intervals=intervals), reaction][: 1 if second in silent else 2]
        blocks = [pcapng.section_header("test", ""), pcapng.interface_description(Interface(252, "port"))]
        blocks += [pcapng.enhanced_packet(0, one.time_ns, pcapng.upper_pdu("sertap", one.pack())) for one in records]
        (folder / name).write_bytes(b"".join(blocks))
    return ["kept_1", "kept_2"]


@pytest.mark.parametrize("before_ns", [SECOND, INTERVAL_MAX])
def test_between_two_kept_files_nothing_is_told(tmp_path: Path, before_ns: int) -> None:
    """Nothing was kept there: neither bus nor drive was silent, and the clock did not jump. Perhaps the last command of
    the first file was answered.
    """
    names = kept(tmp_path, before_ns)
    both, *each = (
        json.loads(run(tmp_path, "report", "--format", "json", *captures).stdout)
        for captures in (names, names[:1], names[1:])
    )
    episodes = both["episodes"]
    assert both["faults"] == {name: sum(one["faults"][name] for one in each) for name in both["faults"]}
    assert both["faults"]["unanswered"] > 0
    seconds = [tuple(datetime.fromisoformat(one[end]).timestamp() for end in ("from", "to")) for one in episodes]
    assert {one["kind"] for one in episodes} <= {"repeated", "unanswered"}
    assert [(from_s, to_s) for from_s, to_s in seconds if to_s > 40 and from_s < 1800] == []
    text = run(tmp_path, "report", "--format", "text", *names).stdout
    assert "between two of them nothing was kept" in text


def test_a_report_of_several_files(tmp_path: Path) -> None:
    """The capture started once; what was told before is no traffic. The second file alone says that it started, too."""
    both, second = (
        json.loads(run(tmp_path, "report", "--format", "json", *names).stdout) for names in (ring(tmp_path), ["b"])
    )
    assert (both["packets"], both["records"]["events"], both["telegrams"]["all"]) == (11, 1, 10)
    assert [one["text"] for one in both["events"]] == ["from a test"]
    assert (second["packets"], second["records"]["events"]) == (5, 1)
    text = run(tmp_path, "report", "--format", "text", *ring(tmp_path)).stdout
    assert "2 files, a to b" in text and "mergecap -a -w all.pcapng" in text
    (tmp_path / "c").write_bytes(b"\0junk" * 9)
    refused(run(tmp_path, "report", "--format", "text", "a", "c"), 2, "c cannot be read with others")
