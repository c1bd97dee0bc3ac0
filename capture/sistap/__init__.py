# SPDX-License-Identifier: GPL-2.0-or-later
# ruff: noqa: F403, F405 - for type checkers, the names are those of library
"""sistap: a passive tap for the SIS serial protocol that records the time of every character.

It has three storeys: the tap; what tshark dissects; the commands. A room may use those named beside it, and what these
may use, never a room of a storey above; tests/test_rooms.py watches:

    room                  may use                     what is in it
    tap/terminal          nothing                     what a command has to do with whoever started it
    tap/sis               nothing                     telegrams, rates, what the bus is told of them
    tap/line              terminal, sis               ports, settings, clocks, and readers: characters with times
    tap/records           line, sis                   characters are cut into records, put in order, counted, shown
    tap/files             records                     pcapng files and rings of them, written
    tap/capture           files                       `sistap capture`
    tap/common            terminal                    output files, temporary files, programs that are started
    tap/wire              line                        the line over a socket: a virtual bus
    tap/analyser          line, common                the line by a logic analyser
    tap/windows           line                        the line by a COM port of Windows
    tap/ports             analyser                    `sistap ports`
    dissected/telegrams   records                     what telegrams say, as far as it is known without Wireshark
    dissected/draw        nothing                     pages, and pictures as SVG
    dissected/captures    files, common               captures that are there: read, several as one, in memory
    dissected/wireshark   common                      tshark: run, its rows, its folders
    dissected/accesses    wireshark                   what was read and written of parameters, and the list of them
    dissected/packets     accesses, captures          packets and telegrams as the dissector says them, and their times
    dissected/episodes    packets                     what happened: faults, silences, changes, with their times
    dissected/explain     files, wireshark            what tshark says of records, also while they come
    commands/recorder     capture, episodes, explain  `sistap record`: what matters, in files of its own
    commands/selftest     analyser, common            `sistap selftest`
    commands/doctor       analyser, capture, explain  `sistap doctor`
    commands/extcap       all above                   Wireshark's interfaces
    commands/install      all above                   `sistap install` and `uninstall`
    commands/imports      all above                   `sistap import`
    commands/report       all above                   `sistap report`
    commands/annotate     all above                   `sistap annotate` and `log`
    commands/parameters   all above                   `sistap parameters`
    commands/compare      all above                   `sistap compare`
    commands/tables       all above                   `sistap tables`
    commands/web          everything                  sistap in the page of a browser
    library               everything                  sistap for other programs: `import sistap`
    cli, __main__         everything                  the command `sistap`

A capture needs the first six rooms alone: other readers, and the text of a live capture, are imported where they are
asked for. The rooms with "all above" are products: no product uses another. A character flows
from a reader through framer and assembler to a writer, and never back. On that way, nothing behind the reader knows
what a serial port is. The virtual bus is a package of its own, sisbus: extcap, install, web and library use
`sisbus.library`, and nothing else of it.
"""

import os
import sys


def _leave_current_folder() -> None:
    """Import nothing from the current folder after `python3 -m sistap`, as with -P: its files may be anybody's.

    Where sistap itself is, it may stay. Python has these two modules, and no other, whatever is in that folder.
    """
    # While Python looks for the module that it has to run, -m stands in place of the name of the program.
    if sys.argv[:1] != ["-m"] or sys.flags.safe_path:
        return
    word = sys.orig_argv[-len(sys.argv)]  # the name of the module, or options with it: -Bmsistap
    module = word.partition("m")[2] if word.startswith("-") else word
    if module.partition(".")[0] == __name__:
        own = os.path.realpath(os.path.join(__file__, "../.."))  # noqa: PTH118 - pathlib could be of that folder
        if os.path.realpath(sys.path[0]) != own:
            del sys.path[0]


_leave_current_folder()

TYPE_CHECKING = False  # as type checkers know it, without the module typing
if TYPE_CHECKING:
    from sistap.library import *

__version__ = "0.1.0"
__all__ = [
    "Character",
    "Error",
    "Event",
    "Flag",
    "Framing",
    "LineSettings",
    "NotCaptured",
    "OutputError",
    "OutputRefused",
    "Packet",
    "PortError",
    "PortLost",
    "Record",
    "SourceError",
    "Tap",
    "Telegram",
    "TsharkError",
    "Type",
    "Writer",
    "dissect",
    "play",
    "read",
]


def __getattr__(name: str) -> object:
    """Load the library when something of it is used: the command starts without it."""
    if name in __all__:
        from sistap import library

        return getattr(library, name)
    raise AttributeError(f"module 'sistap' has no attribute '{name}'; it has {', '.join(__all__)}")
