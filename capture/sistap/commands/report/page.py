# SPDX-License-Identifier: GPL-2.0-or-later
"""The report as one HTML page that needs nothing else: no script, no network, light and dark."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

import sistap
from sistap.commands.report import curved, plots, tables
from sistap.commands.report.gather import Report
from sistap.commands.report.tables import ReportTable
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.draw import html
from sistap.dissected.draw.panel import COLOURS, Drawing
from sistap.dissected.draw.svg import svg

_DARK = {
    "paper": "#14181d",
    "ink": "#e4e8ed",
    "line": "#6f7a87",
    "faint": "#9aa5b1",
    "shade": "#20262d",
    "command": "#4aa8e0",
    "reaction": "#2fbf95",
    "other": "#858c95",
    "bad": "#ff7350",
}
_LIGHT = {"paper": "#ffffff", "shade": "#eef1f4", "faint": "#5b6672", **COLOURS}

_STYLE = """\
body { margin: 0 auto; padding: 1rem; max-width: 84rem; background: var(--paper); color: var(--ink);
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.5rem; margin: .5rem 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid var(--line); }
figure { margin: 1.25rem 0; }
figcaption { font-size: .9rem; max-width: 46rem; }
figcaption b { font-size: 1rem; }
.scroll { overflow-x: auto; }
svg { display: block; width: 100%; height: auto; }
.wide svg { min-width: 40rem; }
.pair { display: grid; gap: 0 2rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 27rem), 1fr)); }
.pair figure { max-width: 36rem; }
.pair figure:target { grid-column: 1 / -1; max-width: none; outline: .15rem solid var(--command); }
figure[id] figcaption a { float: right; display: none; }
figure:target figcaption a { display: inline; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; border-top: 1px solid var(--shade); }
th[scope=row], td { white-space: nowrap; }
thead th { vertical-align: bottom; border: 0; }
td.folded { white-space: normal; min-width: 10rem; }
code { background: var(--shade); padding: .1rem .3rem; border-radius: .2rem; user-select: all; }
.headline, .answer { font-size: 1.1rem; }
.answer li { margin: .35rem 0; }
.answer span { white-space: nowrap; }
a { color: inherit; text-decoration-color: var(--line); }
.severity { display: inline-block; margin: 0 1rem .5rem 0; }
#only-error:checked ~ .scroll tr:is(.warning, .note), #only-look:checked ~ .scroll tr.note { display: none; }
tr:target { background: var(--shade); outline: .15rem solid var(--command); }
.remarks { padding: .6rem 1rem .6rem 2rem; background: var(--shade); border-left: .3rem solid var(--line); }
footer { margin-top: 3rem; font-size: .85rem; border-top: 1px solid var(--line); }
@media screen and (max-width: 42rem) {  /* a telephone: each row a card */
  thead { display: none; }
  table, tbody, tr, th[scope=row], td { display: block; white-space: normal; }
  tr { padding: .4rem 0; border-top: 1px solid var(--line); }
  th[scope=row], td { padding: .1rem 0; border: 0; overflow-wrap: anywhere; }
  td:empty { display: none; }
  [data-head]::before { font-weight: normal; content: attr(data-head) ": "; color: var(--faint); }
}
@media print {
  body { max-width: none; font-size: 10pt; padding: 0; }
  h2 { break-after: avoid; }
  figure, tr { break-inside: avoid; }
  .scroll { overflow: visible; }
  .wide svg { min-width: 0; }
  .pair { grid-template-columns: 1fr 1fr; }
  table { font-size: 7.5pt; }
  th, td { padding-right: .4rem; }
  th[scope=row], td, td.folded { white-space: normal; min-width: 0; }
  code { padding: 0; }
}
"""

# What a reader may want to see: name, words, severities.
_CHOICES = (
    ("all", "All", {"error", "warning", "note"}),
    ("only-look", "Errors, and what is to be looked at", {"error", "warning"}),
    ("only-error", "Errors", {"error"}),
)
_LONG = 40  # characters in a cell that may be folded
_KEY = (
    "A bar is a telegram. Each stroke in it is a character, at the time at which it was read. Red is a limit that was "
    "exceeded, or a fault."
)
_INTERVALS = "As recorded, from character to character; both scales are logarithmic."
_SAME_READ = (
    " Characters of one read have intervals of 0, which are not drawn ({count} here), and the interval before them "
    "looks longer than it was."
)
_PARAMETERS = (
    "A read counts with its reaction, a write when its reaction accepts it. A refused one is an error. "
    "`sistap parameters --changes` lists every write that changed something."
)
_VALUES = (
    "Where nothing was read for a long time, the curve has a gap. A dot is a value that was written. Red lines are the "
    "limits, if minimum and maximum were read and are not far away. What happened to the value is shaded: a click "
    "leads to its row. A click on a parameter in a table shows its curve as wide as the page. For the same curve in "
    "Wireshark, open Statistics > I/O Graphs and add a graph: the filter below the curve, Y Axis AVG(Y Field), Y Field "
    "sis.value.number."
)
_TIMELINE = (
    "A bar is an episode: high and red for an error, low and red for what is to be looked at, grey for a note. A wide, "
    "pale bar lasts that long; a thin line is a drift. Where the ground is grey, the machine stood or was off. A click "
    "leads to its row, which has its display filter."
)
_PAUSES = (
    "The smallest safe TzA is the whole number of ms that every telegram of the capture surely kept. A longer capture "
    "makes it more certain. No document says whether the character that ends an interval counts. If only the pause "
    "counts, a smaller TzA is safe. More exact times decide most of what is unresolved: `sistap doctor -i PORT` says "
    "how exact those of a port are, and what makes them more exact."
)
_REACTIONS = "From the last character of a command to the first of its reaction; both scales are logarithmic."
_SCALED = "Both scales are logarithmic: a single long interval is seen, too."
_OVERVIEW = (
    "The load is that of the last second. The steps of a station count its telegrams; the highest step of each station "
    "is equally high. A red stroke means at least one in that step."
)


def page(report: Report, title: str = "", note: str = "") -> str:
    """Make the page. `title` stands above it in place of the name of the capture, `note` below that."""
    title = title or report.name
    parts = [
        f"<h1>{escape(title)}</h1>",
        "".join(f"<p>{escape(text)}</p>" for text in note.splitlines() if text.strip()),
        _answer(report),
        _figure(plots.timeline(report), "timeline", _TIMELINE),
        _remarks(tables.remarks(report)),
        _table(tables.episodes(report), "Each filter finds its packets: paste it into Wireshark's filter line."),
        _table(tables.summary(report)),
        _figure(plots.overview(report), "overview", _OVERVIEW),
        _table(tables.faults(report)),
        _table(tables.verdicts(report)),
        _table(tables.pauses(report), _PAUSES),
        _table(tables.places(report)),
        _windows(report),
        _times(report),
        _table(tables.services(report)),
        _parameters(report),
        _table(tables.stations(report), "Damaged telegrams are left out: nobody knows whose they are."),
        _table(tables.events(report)),
        f"<h2>Words</h2>{_remarks(list(tables.GLOSSARY))}",
        f"<footer>sistap {sistap.__version__}. All figures are those of Wireshark's dissector.</footer>",
    ]
    return "\n".join([html.begin(f"{title}: report", style()).rstrip(), *filter(None, parts), html.END])


def style() -> str:
    """Return the style of every page, which the page of a browser has to allow."""
    dark = f"@media screen and (prefers-color-scheme: dark) {{ {_variables(_DARK)} }}"
    return f"\n{_variables(_LIGHT)}\n{dark}\n{_STYLE}"


def _variables(colours: dict[str, str]) -> str:
    return f":root {{ {' '.join(f'--{role}: {colour};' for role, colour in colours.items())} }}"


def _answer(report: Report) -> str:
    """Write the five lines; each phrase is a link to its episode, where the display filter is."""
    if not report.episodes:
        notes = [line.text for line in report.answer if line.note]
        return "".join(f'<p class="headline">{escape(line)}</p>' for line in [*tables.answer(report)[:1], *notes])
    places = {id(episode): number for number, episode in enumerate(report.episodes[: tables.EPISODES_SHOWN])}
    items = []
    for line in report.answer:
        head = f"<b>{escape(line.verdict or line.subject)}</b>{'.' if line.verdict else ':'} "
        phrases = [_phrase(phrase.text, places.get(id(phrase.episode))) for phrase in line.phrases]
        said = "; ".join([*phrases, *map(escape, line.rest)])
        items.append(f"<li>{head}{said or ('' if line.verdict else 'nothing')}</li>")
    return f'<ol class="answer">{"".join(items)}</ol><p>{escape(tables.legend(report))}</p>'


def _phrase(text: str, row: int | None) -> str:
    """Write a phrase, as a link to its row if the table has it. No line ends at a hyphen of an ident."""
    words = re.sub(tables.IDENT, r"<span>\g<0></span>", escape(text))
    return words if row is None else f'<a href="#{tables.ANCHOR}{row}">{words}</a>'


def _remarks(remarks: list[str]) -> str:
    items = "".join(f"<li>{escape(remark)}</li>" for remark in remarks)
    return f'<ul class="remarks">{items}</ul>' if items else ""


def _table(table: ReportTable, note: str = "") -> str:
    if not table.rows:
        return ""
    heads = "".join(f'<th scope="col">{escape(head)}</th>' for head in table.heads)
    head = f"<thead><tr>{heads}</tr></thead>" if heads else ""
    rows = "\n".join(
        f"<tr{_names(table, number)}>{''.join(_cells(table, number))}</tr>" for number in range(len(table.rows))
    )
    text = "".join(f"<p>{escape(one)}</p>" for one in (note, table.note) if one)
    body = f'<div class="scroll"><table>{head}<tbody>\n{rows}\n</tbody></table></div>'
    choice = _choice(table.kinds) if len(set(table.kinds)) > 1 else ""
    return f"<h2>{escape(table.title)}</h2>{text}<div>{choice}{body}</div>"


def _names(table: ReportTable, row: int) -> str:
    """Write by what a row is found, and by what it is hidden."""
    name = f" id={table.anchor}{row}" if table.anchor else ""
    return f'{name} class="{table.kinds[row]}"' if table.kinds else name


def _choice(kinds: Sequence[str]) -> str:
    """Write what chooses the rows that are shown; the style does it, without a script."""
    return "".join(
        f'<input type="radio" name="severity" id="{name}"{" checked" if name == "all" else ""}/> '
        f'<label class="severity" for="{name}">{escape(words)} ({sum(kind in shown for kind in kinds)})</label>'
        for name, words, shown in _CHOICES
    )


def _cells(table: ReportTable, row: int) -> list[str]:
    cells = []
    for column, text in enumerate(table.rows[row]):
        words = f"<code>{escape(text)}</code>" if column == table.code else escape(text)
        link = table.links.get((row, column))
        words = f'<a href="#{link}">{words}</a>' if link else words
        head = f' data-head="{escape(table.heads[column])}"' if table.heads else ""
        kind = "" if len(text) <= _LONG else ' class="folded"'
        cells.append(f"<td{kind}{head}>{words}</td>" if column else f'<th scope="row"{head}>{words}</th>')
    return cells


def _figure(drawing: Drawing | None, name: str, text: str) -> str:
    if drawing is None:
        return ""
    kind = ' class="wide"' if drawing.is_wide else ""
    caption = f"<figcaption><b>{escape(drawing.title)}</b><br>{escape(text)}</figcaption>"
    return f'<figure{kind}>{caption}<div class="scroll">{_svg(drawing, name)}</div></figure>'


def _svg(drawing: Drawing, name: str) -> str:
    return svg(drawing, name).replace("<svg ", f'<svg aria-label="{escape(drawing.title)}" ', 1)


def _windows(report: Report) -> str:
    figures = []
    for number, window in enumerate(report.windows):
        left_out = f"{window.left_out} packets more do not fit into the picture." if window.left_out else ""
        drawing = plots.window(window)
        if drawing:
            figures.append(_figure(drawing, f"window{number}", left_out))
        else:
            figures.append(f"<p><b>{escape(window.title)}</b><br>Nothing was on the bus.</p>")
    return f"<h2>In full detail</h2><p>{_KEY}</p>{''.join(figures)}" if figures else ""


def _parameters(report: Report) -> str:
    table, found = _table(tables.parameters(report), _PARAMETERS), curved.parameters(report)
    if not found:
        return table
    rest = len(report.figures.curves.moved()) - len(found)
    title = "Values that moved" + (f" (and {rest} more)" if rest else "")
    figures = "".join(map(_curve, plots.values(report), found, curved.places(report).values()))
    return f'{table}<h2 id="curves">{title}</h2><p>{_VALUES}</p><div class="pair">{figures}</div>'


def _curve(drawing: Drawing, listed: Listed, name: str) -> str:
    """Write the curve of a parameter: it is as wide as the page if a link leads to it."""
    find = f"<code>{escape(curved.wireshark_filter(listed))}</code>"
    words = f'<a href="#curves">All curves</a> In Wireshark: {find}'
    return f'<figure id="{name}">{_svg(drawing, f"{name}-picture")}<figcaption>{words}</figcaption></figure>'


def _times(report: Report) -> str:
    count = report.figures.pauses.same_read
    text = _INTERVALS + (_SAME_READ.format(count=count) if count else "")
    figures = _figure(plots.intervals(report), "intervals", text)
    figures += _figure(plots.reactions(report), "reactions", _REACTIONS)
    figures += _figure(plots.pauses_by_talker(report), "talkers", _SCALED)
    figures += _figure(plots.pauses_by_place(report), "places", _SCALED)
    return f'<h2>Times</h2><div class="pair">{figures}</div>' if figures else ""
