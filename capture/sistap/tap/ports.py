# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap ports`: the serial ports and the logic analysers of this computer."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from sistap.tap.analyser import probe
from sistap.tap.common.table import aligned
from sistap.tap.line import ports
from sistap.tap.line.drivers import ErrorPlace
from sistap.tap.line.ports import Adapter
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import DONE
from sistap.tap.terminal.rights import as_typed

DESCRIPTION = """\
List the serial ports with adapter, driver, latency, and where line errors are marked. List logic analysers as well.
"""

_EXACT = ErrorPlace.CHARACTER.value


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `sistap ports`."""
    parser.add_argument("--json", action="store_true", help="print the list as JSON, for programs")


def _as_json(there: list[tuple[str, Adapter]], analysers: Sequence[probe.Analyser]) -> str:
    """Return the ports as a JSON array; what the system does not say is null."""
    rows = [
        {
            "port": port,
            "adapter": behind.name or None,
            "driver": behind.driver or None,
            "latency_timer_ms": behind.latency_ms,
            "fifo_trigger": behind.fifo_trigger,
            "serial": behind.serial or None,
            "line_errors": behind.tells.place.value if behind.tells.clause else None,
        }
        for port, behind in there
    ]
    rows += [{"port": one.port, "adapter": one.name, "driver": probe.DRIVER} for one in analysers]
    return json.dumps(rows, indent=2)


def run(args: argparse.Namespace) -> int:
    """Print the table of ports; return the exit code."""
    there, analysers = ports.found(), probe.plugged_in()
    if args.json:
        print(_as_json(there, analysers))
        return DONE
    if not there and not analysers:
        print(as_typed(f"no serial port found: plug the adapter in; {advice().no_port}"))
        return DONE
    rows = [("port", "adapter", "driver", "latency", "line errors")]
    rows += [
        (
            *(port, visible(behind.name) or "-", behind.driver or "-", behind.latency or "-"),
            behind.tells.place.value if behind.tells.clause else "-",
        )
        for port, behind in there
    ]
    rows += [(one.port, visible(one.name), probe.DRIVER, "samples the bus", _EXACT) for one in analysers]
    for line in aligned(rows):
        print(line)
    return DONE
