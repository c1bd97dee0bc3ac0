# SPDX-License-Identifier: GPL-2.0-or-later
"""A comparison as one self-contained HTML page: no script, no network, light and dark."""

from __future__ import annotations

from html import escape

import sistap
from sistap.commands.compare import findings
from sistap.commands.compare.differences import Comparison
from sistap.commands.compare.findings import CompareTable
from sistap.dissected.draw import html

# Of every page, which the page for a browser has to allow.
STYLE = """
body { margin: 0 auto; padding: 1rem; max-width: 74rem; font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; border-top: 1px solid #8884; }
.lines { font-size: 1.05rem; }
.lines th { padding-left: .6rem; white-space: nowrap; border-left: .3rem solid #c2410c; }
.lines tr.same th { border-left-color: #8884; }
"""


def page(comparison: Comparison) -> str:
    """Return the page."""
    lines = "\n".join(
        f'<tr{"" if line.found else " class=same"}><th scope="row">{escape(line.subject)}</th>'
        f"<td>{'<br>'.join(map(escape, line.found)) or findings.NONE}</td></tr>"
        for line in findings.lines(comparison)
    )
    tables = "\n".join(map(_table, findings.tables(comparison)))
    return f"""\
{html.begin("What has changed", STYLE)}\
<h1>What has changed</h1>
<p>Good: {escape(findings.side(comparison.good))}<br>Bad: {escape(findings.side(comparison.bad))}</p>
<table class="lines"><tbody>
{lines}
</tbody></table>
{tables}
<footer>sistap {sistap.__version__}. All figures are those of Wireshark's dissector.</footer>
{html.END}"""


def _table(table: CompareTable) -> str:
    heads = "".join(f'<th scope="col">{escape(head)}</th>' for head in table.heads)
    rows = "\n".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in table.rows)
    note = f"<p>{escape(table.note)}</p>" if table.note else ""
    return (
        f"<h2>{escape(table.title)}</h2>{note}"
        f'<div class="scroll"><table><thead><tr>{heads}</tr></thead><tbody>\n{rows}\n</tbody></table></div>'
    )
