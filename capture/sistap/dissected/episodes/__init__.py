# SPDX-License-Identifier: GPL-2.0-or-later
"""What happened, and when: episodes, made of packets and values as they come, in bounded memory.

It judges a machine, not numbers. A drive says whether it has a fault (F) or a warning (E); a machine runs, stands, is
switched off, or boots. What such a state explains is told once, with the state. Three answers: OK; OK, n things to look
at; NOT OK.

A packet goes through all lookers of its bus (engine):

    states, silence, boots, devices    the tap, the line, and who is there
    faults, paces, masters, writes     telegrams: times, damage, refusals; who asks, and what is written
    readings -> machine, diagnoses,    what a value says, also if nobody describes it: whether the machine runs, what
                values                 a drive says of itself, and (levels, trend) what is not as usual

Each yields hits. Hits of one kind, station and topic that follow one another are an episode (episode, book). At the end
`folding` tells together what belongs together, and weighs what is bad only in numbers. `lines` makes the five lines,
`live` tells it while it happens, `values` beside a good capture. The table of kinds (rules) is the only place that
says how bad each is, and what to do; the tables of `folding` say what explains what. It may use packets.

A new kind, step by step:
    its threshold and its row in RULES (rules); fields that it reads in `_SHOWN`, and its telegrams in `_sort`, else no
    looker sees them (packets/dissection); a looker that `engine` asks, for those that have to do with it; its words in
    `lines`; what explains it, in `folding`; a case in tests/test_kinds.py; then docs/generate.py, for docs/kinds.md
"""
