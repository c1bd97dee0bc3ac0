# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap: a passive tap for the SIS serial protocol that records the time of every character.

It has a room for each job. A room may use those named beside it, and what these may use; tests/test_rooms.py watches:

    room                    may use                    what is in it
    terminal                nothing                    what a command has to do with whoever started it
    sis                     nothing                    telegrams, names, rates, what the bus is told of them
    line                    terminal, sis              ports, settings, clocks, and readers: characters with times
    records                 line, sis                  characters are cut into records, put in order, counted, shown
    files                   records                    pcapng files and rings of them, written and read
    wireshark               terminal                   tshark: run, its rows, its folders
    accesses                wireshark                  what was read and written of parameters, and the list of them
    packets                 accesses, records          packets and telegrams as the dissector says them, and their times
    explain                 files, wireshark           what tshark says of records, also while they come
    recorder                explain                    `sistap capture --keep`: what matters, in files of its own
    capture                 recorder                   `sistap capture`
    serve                   capture                    `sistap serve`: a line of this computer, heard at others
    bus                     files, records, line, sis  `sistap bus` and `replay`: a bus in software
    beside                  files, wireshark           two captures of the same traffic compared
    selftest                line, beside               `sistap selftest`
    doctor                  capture, wireshark         `sistap doctor`
    extcap                  all above                  Wireshark's interfaces
    install                 all above                  `sistap install` and `uninstall`
    imports                 all above                  `sistap import`
    report                  all above                  `sistap report`
    annotate                all above                  `sistap annotate` and `log`
    parameters              all above                  `sistap parameters`
    compare                 all above                  `sistap compare`
    tables                  all above                  `sistap tables`
    cli, __main__           everything                 the command `sistap`

The rooms with "all above" are products: no product uses another. A character flows from a reader through framer and
assembler to a writer, and never back. On that way, nothing behind the reader knows what a serial port is.
"""

__version__ = "0.1.0"
