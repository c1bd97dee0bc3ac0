# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts the HTML pages together: one a lesson, and the index. Each holds its style, its script and its data."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from html import escape
from pathlib import Path
from typing import Any

from pages import HERE, markdown
from pages.dissection import rules
from pages.questions import Ask, Lesson, Question
from pages.workbench import tables
from sistap.annotate.page import KINDS

POSTER = "poster-a4.pdf"
PAPERS = ((POSTER, "Poster, A4"), ("poster-a3.pdf", "Poster, A3"), ("sheet.pdf", "The telegram on one page, A4"))

_TINT = "40"  # of 255, over the paper
_FORMS = {
    "number": "a number",
    "packets": "packet numbers, or none",
    "hex": "bytes in hexadecimal",
    "filter": "a display filter",
    "text": "a word",
}


def lesson_page(lesson: Lesson, lessons: Sequence[Lesson], data: dict[str, Any]) -> str:
    """Make the page of a lesson; `data` is what the script shows of its capture."""
    name = lesson.path.stem
    asks = {question.number: [ask._asdict() for ask in question.asks] for question in lesson.questions}
    body = f"""\
<a class="skip" href="#questions">To the questions</a>
<main>
<header>
{_navigation(lesson, lessons)}
<h1>{markdown.inline(lesson.title)}</h1>
<p id="progress" role="status"></p>
</header>
<article id="text">
{markdown.html(lesson.text)}
</article>
<aside aria-label="The packets of {escape(name)}.pcapng">
{_part("packets.html")}
</aside>
<article id="questions">
<h2>Questions</h2>
{"".join(map(_question, lesson.questions))}
{markdown.html(lesson.end)}
</article>
<section id="bench">
{_part("workbench.html")}
</section>
</main>
"""
    scripts = ("answers", "filters", "packets", "workbench", "progress", "lesson")
    return _page(lesson.title, body, {**data, "lesson": name, "asks": asks, "workbench": tables()}, scripts)


def index_page(lessons: Sequence[Lesson]) -> str:
    """Make the page that leads to the others: lessons with progress, glossary, workbench."""
    rows = "".join(
        f'<li><a href="{escape(lesson.path.stem)}.html">{markdown.inline(lesson.title)}</a>'
        f'<progress max="{len(lesson.questions)}" value="0" data-lesson="{escape(lesson.path.stem)}" '
        f'aria-label="Questions answered"></progress> <span class="count">0 of {len(lesson.questions)}</span>'
        f"<p>{markdown.inline(lesson.aim)}</p></li>\n"
        for lesson in lessons
    )
    papers = " ".join(f'<a href="{name}">{words}</a>' for name, words in PAPERS)
    body = f"""\
<main class="single">
<header>
<h1>SIS, a course to do</h1>
<p>Each lesson is a problem at a machine, and takes 10 to 15 minutes. Read, look at the packets, and type your answers:
the page checks them at once. Nothing leaves this computer. Every question can be answered here. Double clicks, menus
and statistics are only in Wireshark: with it you can do every step.</p>
<p>Sheets to print (PDF): {papers}</p>
<p id="progress" role="status"></p>
</header>
<ol class="lessons">
{rows}</ol>
<p><button type="button" id="forget">Forget my progress</button></p>
<section id="bench">
{_part("workbench.html")}
</section>
<section id="glossary">
<h2>Glossary</h2>
{_words()}
</section>
</main>
"""
    return _page("SIS, a course to do", body, {"workbench": tables()}, ("workbench", "progress", "index"))


def _words() -> str:
    """Return the HTML of the glossary without its title: the page has a heading for it."""
    _, _, words = (HERE / "glossary.md").read_text().partition("\n")
    return markdown.html(words)


def _navigation(lesson: Lesson, lessons: Sequence[Lesson]) -> str:
    at = [one.path for one in lessons].index(lesson.path)
    links = [("index.html", "Course"), ("index.html#glossary", "Glossary"), (POSTER, "Poster")]
    for number, words in ((at - 1, "Previous"), (at + 1, "Next")):
        if 0 <= number < len(lessons):
            links.append((f"{lessons[number].path.stem}.html", words))
    shown = " ".join(f'<a href="{escape(target)}">{words}</a>' for target, words in links)
    return f"<nav>{shown}</nav>"


def _question(question: Question) -> str:
    asks = "".join(_ask(question.number, place, ask) for place, ask in enumerate(question.asks))
    wanted = "".join(
        f"<li>{markdown.inline(ask.prompt)}: {' or '.join(f'<code>{escape(one)}</code>' for one in ask.accepted)}</li>"
        for ask in question.asks
    )
    return f"""\
<section class="question" id="question-{question.number}">
<h3>{question.number}. {markdown.inline(question.text)}</h3>
{markdown.html(question.lead)}
<form autocomplete="off">
{asks}<p class="buttons"><button>Check</button></p>
<p class="verdict" role="status"></p>
</form>
<details class="hint"><summary>Hint</summary>{markdown.html(question.hint)}</details>
<details class="answer"><summary>Answer</summary>
<ul>{wanted}</ul>
{markdown.html(question.answer)}
</details>
</section>
"""


def _ask(number: int, place: int, ask: Ask) -> str:
    name = f"ask-{number}-{place}"
    prompt = markdown.inline(ask.prompt)
    if ask.kind == "choice":
        buttons = "".join(
            f'<label><input type="radio" name="{name}" value="{escape(choice)}"> {markdown.inline(choice)}</label>'
            for choice in ask.choices
        )
        said = f'<span class="said" id="{name}-said"></span>'
        return f'<fieldset class="ask"><legend>{prompt}</legend>{buttons} {said}</fieldset>\n'
    unit = ask.accepted[0].partition(" ")[2] if ask.kind == "number" else ""
    form = _FORMS[ask.kind] + (f" of {unit}" if unit else "")
    return (
        f'<p class="ask"><label for="{name}">{prompt} <small>({escape(form)})</small></label> '
        f'<input type="text" id="{name}" name="{name}" class="{ask.kind}" spellcheck="false" autocapitalize="off" '
        f'aria-describedby="{name}-said"> <span class="said" id="{name}-said"></span></p>\n'
    )


def _page(title: str, body: str, data: dict[str, Any], scripts: Sequence[str]) -> str:
    style = (HERE / "page.css").read_text() + _colours()
    script = '"use strict";\n' + "\n".join((HERE / f"{name}.js").read_text() for name in scripts)
    # Only this style and this script; nothing from anywhere else.
    policy = (
        f"default-src 'none'; img-src data:; style-src '{_hash(style)}'; script-src '{_hash(script)}'; "
        "base-uri 'none'; form-action 'none'"
    )
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(title)}</title>
<style>{style}</style>
</head>
<body>
{body}<noscript>Answers are checked by a script. Without one, the questions, hints and answers still open.</noscript>
<script type="application/json" id="data">{_json(data)}</script>
<script>{script}</script>
</body>
</html>
"""


def _hash(text: str) -> str:
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


def _json(data: dict[str, Any]) -> str:
    """Write data so that nothing in it ends the script that holds it."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=True)
    return text.replace("<", r"\u003c").replace(">", r"\u003e").replace("&", r"\u0026")


def _colours() -> str:
    """Return styles of bytes, as `sistap annotate` colours them, and of packets, as the profile does."""
    bytes_ = "".join(
        f".{kind} {{ background: {colour}{_TINT}; border-bottom: 3px {stroke} {colour}; }}\n"
        for kind, (_, colour, stroke) in KINDS.items()
    )
    packets = "".join(
        f".rule{number} {{ background: {rule.paper}; color: {rule.ink}; }}\n" for number, rule in enumerate(rules())
    )
    return bytes_ + packets


def _part(name: str) -> str:
    """Read a part of the page; the key of the colours comes from annotate."""
    key = "".join(f'<span class="{kind}">{escape(text)}</span> ' for kind, (text, _, _) in KINDS.items())
    return (HERE / name).read_text().replace("KEY", key)


def write(path: Path, text: str) -> None:
    """Write a page; the same on every system."""
    path.write_text(text, encoding="utf-8", newline="\n")
