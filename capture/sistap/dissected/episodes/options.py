# SPDX-License-Identifier: GPL-2.0-or-later
"""The option --rule of all commands that tell what happened."""

from __future__ import annotations

import argparse
from typing import Any

from sistap.dissected.episodes.rules import THRESHOLDS, Thresholds, changed


class _RuleAction(argparse.Action):
    """Changes one of the thresholds."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, value: Any, option: str | None = None
    ) -> None:
        try:
            setattr(namespace, self.dest, changed(getattr(namespace, self.dest), value))
        except ValueError as error:
            raise argparse.ArgumentError(self, str(error)) from None


def add_rule(parser: argparse.ArgumentParser, usual: Thresholds = THRESHOLDS) -> None:
    """Declare it: `args.thresholds` are the usual ones, with what is changed."""
    parser.add_argument(
        "--rule",
        dest="thresholds",
        metavar="NAME=VALUE",
        action=_RuleAction,
        default=usual,
        help="change from where on something is unusual, for example bus_silent_s=10; can be given several times; a "
        "wrong NAME lists all",
    )
