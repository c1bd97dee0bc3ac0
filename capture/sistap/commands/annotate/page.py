# SPDX-License-Identifier: GPL-2.0-or-later
"""The log as one self-contained HTML page: bytes are marked by field; point at a byte to see its meaning."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from html import escape
from itertools import groupby

import sistap
from sistap.commands.annotate import meanings
from sistap.commands.annotate.annotator import Annotator, Waiting, indent, place
from sistap.commands.annotate.cutting import PiecePart
from sistap.commands.annotate.meanings import Meaning, Meanings
from sistap.dissected.draw import html
from sistap.dissected.explain.fields import Said
from sistap.tap.terminal.console import visible

# Colours for colour-blind readers (Okabe and Ito). The stroke under the bytes distinguishes them without colour. The
# text has the same ink on all colours.
KINDS = {
    meanings.FRAME: ("start, checksum, lengths", "#7f8a95", "dotted"),
    meanings.CONTROL: ("telegram control, number", "#cc79a7", "dashed"),
    meanings.SERVICE: ("service", "#0072b2", "solid"),
    meanings.ADDRESS: ("addresses", "#e69f00", "double"),
    meanings.STATUS: ("status, error", "#d55e00", "solid"),
    meanings.OBJECT: ("device, parameter", "#009e73", "dashed"),
    meanings.DATA: ("useful data", "#56b4e9", "dotted"),
}
_OTHER = "other"
# Characters that a page cannot show become pictures of control characters.
_CONTROLS = {code: 0x2400 + code for code in range(0x20) if code != ord("\t")} | {0x7F: 0x2421}
_TINT = "33"  # of 255, over the paper

_STYLE = """
:root { --paper: #ffffff; --ink: #1b2026; --faint: #5b6672; --bad: #b3261e; --line: #c3cad2; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #14181d; --ink: #e4e8ed; --faint: #9aa5b1; --bad: #ff8a6b; --line: #3b444e; }
}
body { margin: 0; padding: 1rem; background: var(--paper); color: var(--ink); font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.3rem; margin: 0 0 .5rem; overflow-wrap: anywhere; }
.key { position: sticky; top: 0; padding: .4rem 0; background: var(--paper); border-bottom: 1px solid var(--line); }
.key b { margin-right: 1rem; font-weight: normal; white-space: nowrap; }
pre { margin: 1rem 0; font: 13px/1.7 ui-monospace, monospace; tab-size: 8; }
b { font-weight: normal; padding-bottom: 1px; cursor: help; }
i { font-style: normal; color: var(--faint); }
i.bad { color: var(--bad); font-weight: bold; }
b.other { text-decoration: line-through; }
footer { font-size: .85rem; color: var(--faint); }
@media print { .key { position: static; } pre { white-space: pre-wrap; } }
"""


class PageAnnotator(Annotator):
    """Writes the page."""

    def __init__(self, write: Callable[[bytes], object], name: str, found: Meanings) -> None:
        super().__init__(write)
        self._meanings = found
        self._marked: dict[int, list[tuple[int, int, Meaning]]] = defaultdict(list)  # by line: from, to
        self._write(_head(name).encode())

    def explain(self, parts: list[PiecePart], said: Said) -> None:
        """Mark the bytes in their lines, and put the explanation below the last."""
        found = iter(self._meanings.get(b"".join(part.data for part in parts)))
        for piece, first, end in parts:
            spans = piece.spans[first:end]
            for (start, stop), meaning in zip(spans, found, strict=False):
                shown = meaning or Meaning(_OTHER, "" if said.is_telegram else "no telegram")
                self._marked[piece.line.number].append((start, stop, shown))
        super().explain(parts, said)

    def _explain_late(self, parts: list[PiecePart], text: str) -> None:
        if self._queue:
            self._queue[-1].explanations.append(place(parts, text))

    def _write_answer(self, answer: Sequence[str]) -> None:
        footer = f"sistap {sistap.__version__}. What each byte means is what Wireshark's dissector says."
        items = "".join(f"<li>{escape(text)}</li>" for text in answer)
        told = f"<ol>{items}</ol>\n" if items else ""
        self._write(f"</pre>\n{told}<footer>{footer}</footer>\n{html.END}".encode())

    def _shown(self, waiting: Waiting) -> bytes:
        text = waiting.line.text
        parts = []
        at = 0
        for meaning, spans in groupby(sorted(self._marked.pop(waiting.line.number, [])), key=lambda mark: mark[2]):
            places = list(spans)
            start, stop = places[0][0], places[-1][1]
            parts += [_shown(text[at:start]), _mark(meaning, _shown(text[start:stop]))]
            at = stop
        lines = ["".join(parts) + _shown(text[at:])]
        for column, said in sorted(waiting.explanations):
            before = _plain(text[:column])
            for one in said.split("\n"):
                kind = ' class="bad"' if "[" in one else ""
                lines.append(f"{indent(before, len(before))}<i{kind}>{escape(one)}</i>")
        return ("\n".join(lines) + "\n").encode(errors="backslashreplace")


def _plain(text: str) -> str:
    """Escape text of the log so that it cannot change how the page shows the rest."""
    return visible(text.translate(_CONTROLS), keep="\t")


def _shown(text: str) -> str:
    return escape(_plain(text))


def _mark(meaning: Meaning, shown: str) -> str:
    title = escape(meaning.text).replace("\n", "&#10;")
    return f'<b class={meaning.kind} title="{title}">{shown}</b>'


def _head(name: str) -> str:
    styles = "".join(
        f"b.{kind} {{ background: {colour}{_TINT}; border-bottom: 3px {stroke} {colour}; }}\n"
        for kind, (_, colour, stroke) in KINDS.items()
    )
    key = "".join(f"<b class={kind}>{escape(text)}</b>" for kind, (text, _, _) in KINDS.items())
    return f"""\
{html.begin(f"{_plain(name)}, explained", _STYLE + styles)}\
<h1>{_shown(name)}</h1>
<div class="key">{key}<b class="{_OTHER}">no telegram</b></div>
<pre>
"""
