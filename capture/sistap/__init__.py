# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap: a passive tap for the SIS serial protocol that records the time of every character.

It has a room for each job. A room may use those named beside it, and what these may use; tests/test_rooms.py watches:

    room                    may use                    what is in it
    terminal                nothing                    what a command has to do with whoever started it
    sis                     nothing                    telegrams, rates, what the bus is told of them
    line                    terminal, sis              ports, settings, clocks, and readers: characters with times
    records                 line, sis                  characters are cut into records, put in order, counted, shown
    files                   records                    pcapng files and rings of them, written
    capture                 files                      `sistap capture`
    telegrams               records                    what telegrams say, as far as it is known without Wireshark
    draw                    nothing                    pages, and pictures as SVG
    common                  terminal                   output files, temporary files, programs that are started
    captures                files, common              captures that are there: read, several as one, in memory
    wire                    line                       the line over a socket: a virtual bus, a tap on another computer
    analyser                line, common               the line by a logic analyser
    windows                 line                       the line by a COM port of Windows
    ports                   analyser                   `sistap ports`
    wireshark               common                     tshark: run, its rows, its folders
    accesses                wireshark                  what was read and written of parameters, and the list of them
    packets                 accesses, captures         packets and telegrams as the dissector says them, and their times
    episodes                packets                    what happened: faults, silences, changes, with their times
    explain                 files, wireshark           what tshark says of records, also while they come
    recorder                capture, episodes, explain  `sistap record`: what matters, in files of its own
    serve                   capture, wire              `sistap serve`: a line of this computer, heard at others
    bus                     captures, wire             `sistap bus` and `replay`: a bus in software
    beside                  captures, wireshark, draw  two captures of the same traffic compared
    selftest                analyser, beside           `sistap selftest`
    doctor                  analyser, capture, explain  `sistap doctor`
    extcap                  all above                  Wireshark's interfaces
    install                 all above                  `sistap install` and `uninstall`
    imports                 all above                  `sistap import`
    report                  all above                  `sistap report`
    annotate                all above                  `sistap annotate` and `log`
    parameters              all above                  `sistap parameters`
    compare                 all above                  `sistap compare`
    tables                  all above                  `sistap tables`
    web                     everything                 sistap in the page of a browser
    library                 everything                 sistap for other programs: `import sistap`
    cli, __main__           everything                 the command `sistap`

The first six are the tap. It uses nothing else of sistap: other readers, and the text of a live capture, are
imported where they are asked for. The rooms with "all above" are products: no product uses another. A character flows
from a reader through framer and assembler to a writer, and never back. On that way, nothing behind the reader knows
what a serial port is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sistap.library import (
        Character,
        Error,
        Event,
        Flag,
        Framing,
        LineSettings,
        NotCaptured,
        OutputError,
        OutputRefused,
        Packet,
        PortError,
        PortLost,
        Record,
        SourceError,
        Tap,
        Telegram,
        TsharkError,
        Type,
        Writer,
        dissect,
        play,
        read,
    )

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
