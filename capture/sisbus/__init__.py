# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus: masters and stations that speak SIS, without hardware, or with one half of it.

Each room says in its own first lines what is in it. A room knows only those above it:

    service, table     what a service is; how a table of a TOML file is read
    devices/           a drive or a control: parameters, phases, long data
    stations/          what is spoken to: addresses, services, routing
    playing/           who has the word, when each character arrives
    procedure3964/     an S5 and a PPC, which talk over 3964R and not over SIS
    scenarios/         TOML: who is there, what the masters say, what goes wrong
    wires/             where it is heard: pseudo terminal, socket, port, capture file; one half of the bus real
    replay, command    `sistap replay` and `sistap bus`, which put them together
    library            the door for other programs

A telegram flows forward: a step of a scenario makes a command, conducting brings it onto a line, the stations there
react, each character gets its time, and a wire brings it to whoever listens.

Of sistap it uses the tap and what attributes of parameters say; replay also uses how captures are read.
"""
