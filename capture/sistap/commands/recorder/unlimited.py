# SPDX-License-Identifier: GPL-2.0-or-later
"""Says that a bus talks, but no limit is known: then nothing is late, and no file of it is kept."""

from __future__ import annotations

from collections.abc import Callable

from sistap.tap.records.before import Heard
from sistap.tap.sis import telegram
from sistap.tap.sis.initialization import INITIALIZATION, SET_LIMITS, certain
from sistap.tap.sis.limits import NAMES

ENOUGH = 100  # telegrams; a master that starts the bus sets its limits earlier
ADVICE = (
    "No limit is known: late reactions and slow characters are not kept. The master set the limits before. "
    "If you know them, give --tza MS --trs MS"
)


class Unlimited:
    """Looks for a limit in the first telegrams of a capture, and says once that there is none."""

    def __init__(self, say: Callable[[str], None]) -> None:
        """`say` gets the advice."""
        self._say = say
        self._left = ENOUGH  # telegrams to look at; 0: nothing more to say

    def take(self, heard: Heard) -> None:
        """Take what a record says of its bus."""
        if not self._left:
            return
        if heard.limits or (heard.telegram and _sets_limit(heard.telegram)):
            self._left = 0
        elif heard.telegram:
            self._left -= 1
            if not self._left:
                self._say(ADVICE)


def _sets_limit(data: bytes) -> bool:
    header = telegram.parse(data)
    return (
        header.service == INITIALIZATION
        and not header.reaction
        and any(SET_LIMITS.get(setting.subservice) in NAMES.values() for setting in certain(header.body))
    )
