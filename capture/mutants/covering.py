# SPDX-License-Identifier: GPL-2.0-or-later
"""The mutated modules, and the tests that must catch their mutants. Edit this table when a module moves."""

from __future__ import annotations

from typing import NamedTuple


class Part(NamedTuple):
    """A module of the engine, and the tests that cover it. Choose fast ones: they run for every mutant."""

    module: str  # in capture/
    tests: tuple[str, ...]  # in capture/tests/
    functions: tuple[str, ...] = ()  # mutate only these, if only a part of the module belongs to the engine


# The part of a capture through which reads go.
PASSING = ("_loop", "_take_waiting", "_take", "_idle")

EPISODES = ("test_kinds.py", "test_small_cases.py")

PARTS = (
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
    Part("sistap/dissected/episodes/readings.py", ("test_readings.py",)),
    Part("sistap/dissected/episodes/folding.py", ("test_folding.py",)),
)
# Their tests take several seconds: only by name.
SLOW = (
    Part("sistap/dissected/episodes/lines.py", ("test_episode_lines.py", "test_small_cases.py")),
    Part("sistap/dissected/episodes/live.py", ("test_live_episodes.py",)),
    *(
        Part(f"sistap/dissected/episodes/{name}.py", EPISODES)
        for name in ("boots", "devices", "diagnoses", "faults", "machine", "masters", "paces", "silence", "states")
    ),
    *(Part(f"sistap/dissected/episodes/{name}.py", EPISODES) for name in ("engine", "values", "writes")),
)
