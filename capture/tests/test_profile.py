# SPDX-License-Identifier: GPL-2.0-or-later
"""The profile SIS: Wireshark accepts every line of it, each colour has a meaning, and everybody can distinguish
them.
"""

import csv
import itertools
import math
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

import sistap
from sistap.dissected.wireshark.tshark import Tshark

PROFILE = Path(sistap.__file__).parent / "profile" / "SIS"
CAPTURES = Path(__file__).resolve().parents[2] / "test-captures"

Run = Callable[..., str]
Colour = tuple[float, float, float]


def lines(name: str) -> list[str]:
    return [line for line in (PROFILE / name).read_text().splitlines() if line and not line.startswith("#")]


def rows(name: str) -> list[list[str]]:
    return [[cell.replace(r"\x22", '"') for cell in row] for row in csv.reader(lines(name))]


RULES = [line.split("@")[1:] for line in lines("colorfilters")]
MACROS = dict(rows("dfilter_macros"))
(SWITCH,) = (line.removeprefix("auto_switch_filter: ") for line in lines("profile_settings"))
FILTERS = sorted(
    {rule[1] for rule in RULES}
    | {button[2] for button in rows("dfilter_buttons")}
    | {row[2] for row in rows("io_graphs")}
    | {row[3] for row in rows("plots")}
    | {SWITCH}
)


@pytest.fixture(scope="module")
def tshark() -> Iterator[Run]:
    """Runs tshark with the profile, on a capture; what it says on stderr is a failure."""
    with tempfile.TemporaryDirectory() as folder, Tshark() as program:
        Path(folder).chmod(0o755)  # as root, tshark runs as nobody
        shutil.copytree(PROFILE, Path(folder, "wireshark", "profiles", "SIS"))

        @cache
        def run(capture: str, *arguments: str) -> str:
            command = ["-C", "SIS", "-r", str(CAPTURES / f"{capture}.pcapng"), *arguments]
            done = program.run(command, extra_environment={"XDG_CONFIG_HOME": folder})
            assert (done.returncode, done.stderr) == (0, "")
            return done.stdout

        yield run


def test_wireshark_takes_the_filters(tshark: Run) -> None:
    """Joined by "or", one after the other: tshark names those that it refuses."""
    tshark("specification", "-c", "1", "-Y", " || ".join(f"({text})" for text in FILTERS))


@pytest.mark.thorough
@pytest.mark.parametrize("text", FILTERS)
def test_wireshark_takes_each_filter(tshark: Run, text: str) -> None:
    tshark("specification", "-c", "1", "-Y", text)


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("${sis_between:16;3}", "1 2 3 4 5 6 10 11 12"),
        ("${sis_between:4;16}", "7 8 9"),
        ('${sis_access:3;"S-0-0044"}', ""),
        ("${sis_slower:0.149}", "6"),
        ("${sis_pause:0.0119}", "5"),
    ],
)
def test_macros(tshark: Run, text: str, frames: str) -> None:
    assert (
        tshark("statistics", "-Y", f"{text} && frame.number <= 12", "-T", "fields", "-e", "frame.number").split()
        == frames.split()
    )


@pytest.mark.parametrize(("capture", "switches"), [("damaged", True), ("records", True), ("tcp-foreign", False)])
def test_wireshark_switches_to_the_profile_for_captures_with_sis(tshark: Run, capture: str, switches: bool) -> None:
    assert bool(tshark(capture, "-Y", SWITCH)) == switches


def test_macros_are_the_same_for_later_wiresharks() -> None:
    assert [f'"{name}" {text}' for name, text in MACROS.items()] == lines("dmacros")


def test_graphs_are_of_fields_that_can_be_drawn(tshark: Run) -> None:
    fields = {
        (row[5].replace("COUNT FRAMES", "COUNT").partition("(")[0], row[6]) for row in rows("io_graphs") if row[6]
    }
    assert fields
    wanted = (f"io,stat,0,{function}({field}){field}" for function, field in fields)
    drawn = tshark("statistics", "-q", *(word for graph in wanted for word in ("-z", graph)))
    assert [field for function, field in fields if f"{function}({field})" not in drawn] == []


def test_a_graph_of_a_value_is_the_average_of_one_parameter_of_one_station(tshark: Run) -> None:
    graphs = [row for row in rows("io_graphs") if row[6] == "sis.value.number"]
    assert graphs and all(row[5] == "AVG(Y Field)" for row in graphs)
    for row in graphs:
        assert re.fullmatch(r'sis\.talker == \d+ && sis\.parameter == "[SP]-\d-\d{4}"', row[2])
    said = tshark(
        "course/04-bad-line-proof",
        "-T",
        "fields",
        *(f"-e{name}" for name in ("sis.talker", "sis.parameter")),
        "-esis.value.number",
    )
    found = [
        float(number)
        for line in said.splitlines()
        if line.startswith("3\tS-0-0040\t") and (number := line.split("\t")[2])
    ]
    average = tshark(
        "course/04-bad-line-proof", "-q", "-z", f"io,stat,0,AVG(sis.value.number)sis.value.number && {graphs[0][2]}"
    )
    assert len(set(found)) > 1 and f"{sum(found) / len(found):.2f}" in average


def test_graphs_have_different_units_so_that_wireshark_shows_a_legend() -> None:
    assert len({row[5] for row in rows("io_graphs") if row[0] == "Enabled"}) > 1


def test_plots_are_of_fields_that_can_be_drawn(tshark: Run) -> None:
    for _, _, _, _, _, _, field, _ in rows("plots"):
        assert f"MAX({field})" in tshark("statistics", "-q", "-z", f"io,stat,0,MAX({field}){field}")


COLUMNS = re.findall(r'^\t"([^"]+)", "([^"]+)"', (PROFILE / "preferences").read_text(), re.MULTILINE)
WIDTHS = {
    form: int(width)
    for form, width in re.findall(r'^\t"([^"]+)", (-?\d+)', (PROFILE / "recent").read_text(), re.MULTILINE)
}


def test_columns(tshark: Run) -> None:
    titles = [title for title, _ in COLUMNS]
    packet = tshark("parameters", "-T", "tabs", "-Y", "frame.number == 6").rstrip("\n").split("\t")
    assert dict(zip(titles, [value.strip() for value in packet], strict=True)) == {
        "No.": "6",
        "Time": "0.198333312",
        "Telegram": "3 -> 16  Reaction  Read parameter S-0-0047 (Position command value) = -12.3450",
        "From": "3",
        "To": "16",
        "Silence (ms)": "25.000",
        "Interval (ms)": "1.146",
        "Reaction (ms)": "25.000",
        "Parameter": "S-0-0047",
        "Value": "-12.3450",
    }


def test_a_small_window_shows_what_was_said_and_a_large_one_whole_values() -> None:
    """Wireshark begins with a packet list of 700 pixels, and gives the last column what a larger one has left: of 1280
    pixels, 110 for a value such as 1066.4488 rpm, beside the 36 of the minimap.
    """
    assert [title for title, _ in COLUMNS][:3] == ["No.", "Time", "Telegram"]
    assert WIDTHS["%i"] == 500
    assert COLUMNS[-1][0] == "Value"


def test_the_widths_are_of_all_columns_in_their_order() -> None:
    """Otherwise Wireshark 4.4 ignores them; they are keyed by format, without the occurrence and the display of a
    value.
    """
    assert list(WIDTHS) == [":".join(form.split(":")[:2]) for _, form in COLUMNS]


def test_milliseconds_are_at_the_right() -> None:
    """So that their points stand below each other; Wireshark itself puts only fields without a format there."""
    to_the_right = re.findall(r'^\t"%Cus:([^"]+)", -1:R', (PROFILE / "recent").read_text(), re.MULTILINE)
    assert to_the_right == [form.split(":")[1] for title, form in COLUMNS if title.endswith("(ms)")]


def test_follow_shows_bytes() -> None:
    """Telegrams are not text; Wireshark would show dots. The word is that of Wireshark 4.4; 4.0 ignores the line."""
    assert "gui.follow_show: HEX_DUMP" in lines("recent")


def test_no_toolbar_is_shown_for_captures_that_it_is_not_for() -> None:
    """Wireshark shows the name and the fields of the first interface, also for a pipe and for a file."""
    assert not [line for line in lines("recent") if "toolbar" in line]


# What statistics.txt, records.txt and timing-reactions.txt say of these frames.
@pytest.mark.parametrize(
    ("capture", "options", "frame", "rule"),
    [
        ("statistics", (), 1, "SIS: command"),
        ("statistics", (), 2, "SIS: reaction"),
        ("statistics", (), 5, "SIS: TzA exceeded"),
        ("statistics", (), 7, "SIS: unanswered or repeated"),
        ("statistics", (), 8, "SIS: unanswered or repeated"),
        ("statistics", (), 9, "SIS: error status"),
        ("statistics", (), 10, "SIS: damaged telegram"),
        ("statistics", (), 11, "SIS: line error"),
        ("statistics", (), 13, "SIS: line error"),
        ("timing-reactions", ("-o", "sis.trs_ms:50"), 6, "SIS: reaction"),
        ("timing-reactions", ("-o", "sis.trs_ms:50"), 8, "SIS: TrS or Tmas exceeded"),
        ("timing-cycle", (), 17, "SIS: TrS or Tmas exceeded"),
        ("records", (), 1, "Serial tap: event"),
        ("records", (), 2, "Serial tap: other characters"),
    ],
)
def test_colours(tshark: Run, capture: str, options: tuple[str, ...], frame: int, rule: str) -> None:
    shown = tshark(capture, *options, "-2", "--color", "-T", "fields", "-e", "frame.coloring_rule.name")
    assert shown.splitlines()[frame - 1] == rule


def linear(text: str) -> Colour:
    """Of a colour as colorfilters has it, 16 bits a channel, the light of each channel (sRGB, IEC 61966-2-1)."""
    red, green, blue = (int(part) / 65535 for part in text.strip("[]").split(","))

    def light(value: float) -> float:
        return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4

    return light(red), light(green), light(blue)


def luminance(colour: Colour) -> float:
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule[0])
def test_text_can_be_read_on_its_background(rule: list[str]) -> None:
    """The contrast that WCAG 2 asks for small text; both colours are fixed, so it is the same in a dark theme."""
    background, text = (luminance(linear(colour)) for colour in rule[2].rstrip("]").split("]["))
    assert (max(background, text) + 0.05) / (min(background, text) + 0.05) >= 4.5


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule[0])
def test_no_background_dazzles_in_a_dark_theme(rule: list[str]) -> None:
    assert 0.1 <= luminance(linear(rule[2].split("][")[0])) <= 0.8


# How somebody sees light who lacks one kind of cone (Machado, Oliveira, Fernandes 2009, severity 1), a row a channel.
SIGHT = {
    "all": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "no red": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "no green": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "no blue": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}


def seen(colour: Colour, cones: tuple[tuple[float, ...], ...]) -> Colour:
    """Return the colour in CIE L*a*b*, where distance is difference as the eye has it."""
    red, green, blue = (
        min(max(sum(part * light for part, light in zip(row, colour, strict=True)), 0), 1) for row in cones
    )
    x = (0.4124 * red + 0.3576 * green + 0.1805 * blue) / 0.9505
    y = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    z = (0.0193 * red + 0.1192 * green + 0.9505 * blue) / 1.089

    def root(value: float) -> float:
        return value ** (1 / 3) if value > 0.008856 else 7.787 * value + 16 / 116

    return 116 * root(y) - 16, 500 * (root(x) - root(y)), 200 * (root(y) - root(z))


@pytest.mark.parametrize("sight", SIGHT)
def test_everybody_tells_the_colours_apart(sight: str) -> None:
    """2.3 is just noticeable side by side; the two rules of exceeded limits share a colour."""
    backgrounds = {rule[2].split("][")[0]: rule[0] for rule in RULES}
    looks = {name: seen(linear(colour), SIGHT[sight]) for colour, name in backgrounds.items()}
    near = {
        (one, other): round(math.dist(looks[one], looks[other]), 1)
        for one, other in itertools.combinations(looks, 2)
        if math.dist(looks[one], looks[other]) < 10
    }
    assert not near
