# SPDX-License-Identifier: GPL-2.0-or-later
"""The mutated modules, and the tests that must catch their mutants. Edit this table when a module moves."""

from __future__ import annotations

from typing import NamedTuple


class Part(NamedTuple):
    """A module of the engine, and the tests that cover it. Choose fast ones: they run for every mutant."""

    module: str  # from capture/ on
    tests: tuple[str, ...]  # from capture/tests/ on
    functions: tuple[str, ...] = ()  # mutate only these, if only a part of the module belongs to the engine

    @property
    def is_c(self) -> bool:
        """Tell whether it is in C: then the plugin is built."""
        return self.module.endswith(".c")


# The part of a capture through which reads go.
PASSING = ("_loop", "_take_waiting", "_take", "_idle")

# Each room has a file of tests that say what a person would see; they need no tshark.
EPISODES = tuple(f"test_{name}.py" for name in ("not_hidden", "borders", "verdicts", "small_cases", "kinds", "alike"))
PACKETS = ("test_packet_columns.py", "test_figures.py", "test_report_distribution.py")
ACCESSES = ("test_packet_columns.py", "test_parameter_lines.py")
REPORT = ("test_figures.py",)
PARAMETERS = ("test_parameter_lines.py", "test_backup.py")
STATIONS = ("test_stations.py",)
PLAYING = ("test_playing.py", "test_scenario.py")
CAPTURES = "../../test-captures"
TIMES = tuple(f"{CAPTURES}/test_{name}.py" for name in ("timing_limits", "timing", "timing_clock", "captures"))
EXCHANGES = tuple(f"{CAPTURES}/test_{name}.py" for name in ("exchange", "timing", "statistics", "captures"))
SEQUENCES = tuple(f"{CAPTURES}/test_{name}.py" for name in ("sequence", "captures"))


def room(folder: str, names: str, tests: tuple[str, ...], suffix: str = ".py") -> tuple[Part, ...]:
    """Return files of a folder that the same tests cover."""
    return tuple(Part(f"{folder}/{name}{suffix}", tests) for name in names.split())


TAP = (
    Part("sistap/tap/records/framer.py", ("test_framer.py", "test_framer_ascii.py")),
    Part("sistap/tap/records/framer_3964r.py", ("test_framer_3964r.py",)),
    Part("sistap/tap/records/cut.py", ("test_framer_3964r.py",)),
    Part("sistap/tap/records/record.py", ("test_record.py",)),
    Part("sistap/tap/records/assembler.py", ("test_assembler.py", "test_assembling.py", "test_order.py")),
    Part("sistap/tap/capture/tap.py", ("test_tap.py", "test_assembling.py")),
    Part("sistap/tap/capture/session.py", ("test_assembling.py",), PASSING),
    Part("sistap/commands/recorder/keeper.py", ("test_keeper.py",)),
    Part("sistap/tap/files/output.py", ("test_output.py", "test_lasting.py")),
    Part("sistap/tap/files/pcapng.py", ("test_pcapng.py",)),
    Part("sistap/tap/files/writer.py", ("test_writer.py", "test_pcapng.py")),
    Part("sistap/tap/analyser/uart.py", ("test_uart.py",)),
    Part("sistap/tap/line/measurement.py", ("test_measurement.py",)),
    Part("sistap/tap/line/reader/errors.py", ("test_reader_errors.py",)),
    Part("sistap/tap/line/reader/latency.py", ("test_measurement.py",)),
)

PARTS = (
    *TAP,
    Part("sistap/dissected/episodes/readings.py", ("test_readings.py", *EPISODES)),
    Part("sistap/dissected/episodes/folding.py", ("test_folding.py", *EPISODES)),
    Part("sistap/dissected/episodes/lines.py", ("test_episode_lines.py", *EPISODES)),
    *room("sistap/dissected/episodes", "book episode", ("test_book.py", *EPISODES)),
    Part("sistap/dissected/episodes/levels.py", ("test_levels.py", *EPISODES)),
    *room("sistap/dissected/episodes", "diagnoses engine live silence writes", (*EPISODES, "test_live_episodes.py")),
    *room(
        "sistap/dissected/episodes",
        "boots faults machine masters paces states trend values",
        EPISODES,
    ),
    *room("sistap/dissected/packets", "apart distribution kept", PACKETS),
    Part("sistap/dissected/packets/dissection.py", (*PACKETS, "test_rows.py", "test_verdicts.py")),
    *room("sistap/dissected/accesses", "access listing", ACCESSES),
    *room("sistap/commands/report", "figures pauses tables unjudged windows", REPORT),
    *room("sistap/commands/report", "curved curves", ("test_report_parameters.py", *REPORT)),
    Part("sistap/commands/report/gather.py", ("test_report_since.py", *REPORT)),
    *room("sistap/commands/parameters", "against backup wide writing", PARAMETERS),
    *room(
        "sistap/dissected/telegrams",
        "attribute interpreter values",
        ("test_telegrams.py", "test_backup.py", "test_parameter_lines.py"),
    ),
    *room("sisbus/stations", "flash general initialization making sercos station", STATIONS),
    *room("sisbus/playing", "characters conducting player", PLAYING),
    *room("../plugin/sis", "timing times cycle", TIMES, ".c"),
    *room("../plugin/sis", "exchange bus learn routes telegram", EXCHANGES, ".c"),
    *room("../plugin/sis", "sequence record", SEQUENCES, ".c"),
    Part("../plugin/sis/told.c", ("test_rows.py",)),
)
