#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes what the documents say of the code: the pages of commands, and the marked blocks of other pages.

generate.py writes them; --check names those that are stale."""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(HOUSE / "capture"), str(HOUSE / "test-captures")]

import poster  # noqa: E402 - of the checkout
import wiring  # noqa: E402
from sisbus.scenarios import scenario  # noqa: E402
from sistap import cli  # noqa: E402
from sistap.commands.extcap import dialog  # noqa: E402
from sistap.dissected.episodes.rules import RULES, SUBJECTS, Severity  # noqa: E402
from sistap.tap.line.drivers import DRIVERS  # noqa: E402

DOCS = HOUSE / "capture" / "docs"
MADE = "<!-- Made by capture/docs/generate.py from the code. -->\n"
BLOCK = re.compile(r"(<!-- generated: ([a-z ]+) -->\n).*?(<!-- end -->)", re.DOTALL)
FOLDERS = ("capture", "plugin", "test-captures", "lua-fallback")
SOURCES = {".py", ".c", ".h", ".lua", ".js", ".mjs", ""}
TITLES = {"capture": "sistap", "plugin": "the plugin", "test-captures": "the captures", "lua-fallback": "the script"}
HEAD = re.compile(
    r'\A(?:#![^\n]*\n|(?:#|//|--|/\*)[^\n]*SPDX[^\n]*\n|\n)*(?:r?"""(?P<doc>.*?)"""|/\*+(?P<c>.*?)\*/|(?P<lines>(?:(?:#|//|--)[^\n]*\n)+))',
    re.DOTALL,
)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    lines += [
        f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |".replace("|  |", "| |") for row in rows
    ]
    return "\n".join(lines) + "\n"


def subject(text: str) -> str:
    """Return the first sentence of what a source says of itself."""
    found = HEAD.match(text)
    if not found:
        return ""
    said = found["doc"] or found["c"] or re.sub(r"^(?:#|//|--) ?", "", found["lines"] or "", flags=re.MULTILINE)
    first = re.sub(r"^ \* ?", "", said.strip(), flags=re.MULTILINE).split("\n\n")[0]
    return re.split(r"(?<=[a-z)`\"A-Z0-9])[.:]?$|(?<=[a-z)`\"A-Z0-9])(?<!fig)\. ", " ".join(first.split()))[0]


def sources(folder: str) -> Iterator[Path]:
    """Return the sources of a folder that git knows, and those that it will."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", folder]
    names = subprocess.run(listed, cwd=HOUSE, check=True, capture_output=True, text=True).stdout.splitlines()
    for name in sorted(set(names)):
        path = HOUSE / name
        if path.suffix in SOURCES and path.is_file() and (path.suffix or path.read_bytes()[:2] == b"#!"):
            yield path


def files(folder: str) -> str:
    """Return the page of a folder's files: a heading for each of its folders, a row for each file.

    The search leaves it out: who looks for a word wants what stands in the documents.
    """
    page = f"---\nnosearch: true\n---\n\n# Files of {TITLES[folder]}\n\n{MADE}\n"
    page += "Each row is the first sentence of the file.\n"
    for place, group in groupby(sorted(sources(folder)), lambda path: path.parent):
        rows = [(f"`{path.name}`", subject(path.read_text("utf-8", "replace"))) for path in group]
        page += f"\n## {place.relative_to(HOUSE).as_posix()}\n\n{table(('file', 'subject'), rows)}"
    return page


def option(action: argparse.Action, parser: argparse.ArgumentParser) -> tuple[str, str]:
    """Return the row of an argument."""
    formatter = parser._get_formatter()
    default = formatter._get_default_metavar_for_optional(action)
    values = "" if action.nargs == 0 else formatter._format_args(action, default)
    names = [f"`{f'{name} {values}'.strip()}`" for name in action.option_strings]
    meaning = plain(" ".join(formatter._expand_help(action).split()))
    return ", ".join(names or [f"`{action.metavar or action.dest}`"]), meaning


def plain(text: str) -> str:
    """Return a text of --help whose angle brackets are no tags."""
    return text.replace("<", r"\<")


def indented(part: str) -> str:
    """Return a paragraph of --help; what is indented there is code here."""
    return "\n".join(f"  {line}" for line in part.split("\n")) if part.startswith("  ") else plain(part)


def texts(text: str) -> str:
    """Return a text of --help."""
    parts = re.sub(r":\n(?=  \S)", ":\n\n", text.strip("\n")).split("\n\n")
    return "\n\n".join(map(indented, parts))


def command(name: str, parser: argparse.ArgumentParser) -> str:
    """Return the page of a command."""
    page = f"# sistap {name}\n\n{MADE}\n{texts(parser.description or cli.COMMANDS[name][1])}\n"
    for group in parser._action_groups:
        shown = [action for action in group._group_actions if action.help != argparse.SUPPRESS]
        if shown and (group.title != "options" or len(shown) > 1):
            title = (group.title or "").capitalize()
            page += f"\n## {title}\n\n{table(('argument', 'meaning'), [option(action, parser) for action in shown])}"
    return page + (f"\n{texts(parser.epilog)}\n" if parser.epilog else "")


def commands() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of each command."""
    (chosen,) = (action for action in cli.parser()._actions if isinstance(action, argparse._SubParsersAction))
    return dict(chosen.choices)


def list_of_commands() -> str:
    """Return the page that names all commands, with the exit codes."""
    rows = [(f"[`{name}`](commands/{name}.md)", text) for name, (_, text) in cli.COMMANDS.items()]
    codes = re.findall(r"^  (\d)  (.+)$", cli.EPILOG, re.MULTILINE)
    return (
        f"# Commands\n\n{MADE}\n`sistap COMMAND --help` prints the same in a terminal.\n\n"
        + table(("command", "what it does"), rows)
        + "\n## Exit codes\n\n"
        + table(("code", "meaning"), codes)
    )


def drivers() -> str:
    """Return what each driver says about line errors."""
    rows = [
        (
            *(driver.adapters, ", ".join(f"`{name}`" for name in driver.names[:2]) or "`serial8250` ..."),
            *(driver.place.value, "yes" if driver.breaks else "no", "yes" if driver.counts else "no", driver.caveat),
        )
        for driver in DRIVERS
    ]
    return table(("adapter", "driver of Linux", "damaged character", "break", "lost characters", ""), rows)


def fields() -> str:
    """Return the fields of the dialog of an interface."""
    kinds = {
        dialog.Of.PORT: "port",
        dialog.Of.ANALYSER: "analyser",
        dialog.Of.DEMO: "demo bus",
    }
    rows = [
        (
            f"*{field.display}*",
            field.tooltip,
            f"`{field.key.replace('_', '')}`",
            ", ".join(word for kind, word in kinds.items() if kind in field.of),
        )
        for field in dialog.OPTIONS
    ]
    return table(("field", "meaning", "name in tshark", "interfaces"), rows)


def scenarios() -> str:
    """Return the scenarios that come with sistap."""
    return table(("scenario", "what it plays"), [(f"`{name}`", scenario.load(name).title) for name in scenario.names()])


def _statistics() -> Iterator[tuple[str, str]]:
    """Yield what the plugin registers: a name for tshark -z, and the path in the menu Statistics."""
    protocols = tomllib.loads((HOUSE / "plugin/protocol/protocols.toml").read_text("utf-8"))
    for path in sorted((HOUSE / "plugin").rglob("*.c")):
        text = path.read_text("utf-8")
        for name, title in re.findall(r'"(\w+)", COMPAT_IN_SUBMENU\("([^"]+)"', text):
            yield f"{name},tree", f"SIS > {title}"
        for name in re.findall(r"register_srt_table\(proto_(\w+)", text):
            yield f"{name},srt", f"Service Response Time > {protocols[name]['short']}"
        for name in re.findall(r"register_conversation_table\(proto_(\w+)", text):
            yield f"conv,{name}", f"Conversations > {protocols[name]['short']}"
            yield f"endpoints,{name}", f"Endpoints > {protocols[name]['short']}"


def statistics() -> str:
    """Return the statistics of the plugin."""
    rows = [(f"`{name}`", f"*{title}*") for name, title in sorted(_statistics(), key=lambda row: row[1])]
    return table(("name", "menu *Statistics*"), rows)


def kinds() -> str:
    """Return the kinds of episodes."""
    answers = {Severity.ERROR: "NOT OK", Severity.WARNING: "to be looked at", Severity.NOTE: "note"}
    rows = [(f"`{name}`", SUBJECTS[rule.subject], answers[rule.severity], rule.means) for name, rule in RULES.items()]
    return table(("kind", "line", "answer", "what it means"), rows)


BLOCKS = {
    "kinds": kinds,
    "dead bus": lambda: table(("step", "what to do"), poster.DEAD_BUS),
    "pins": lambda: table(("signal", "9-pin plug", "15-pin plug"), wiring.PINS),
    "drivers": drivers,
    "fields": fields,
    "scenarios": scenarios,
    "statistics": statistics,
}


def filled(text: str) -> str:
    """Return a page with its blocks as the code has them."""
    return BLOCK.sub(lambda found: f"{found[1]}\n{BLOCKS[found[2]]()}\n{found[3]}", text)


def pages() -> Iterator[tuple[Path, str]]:
    """Return every page, as it has to be."""
    yield DOCS / "commands.md", list_of_commands()
    for name, parser in commands().items():
        yield DOCS / "commands" / f"{name}.md", command(name, parser)
    for path in sorted(HOUSE.glob("*/docs/*.md")):
        if BLOCK.search(text := path.read_text("utf-8")):
            yield path, filled(text)
    for name, draw in wiring.DRAWINGS.items():
        yield DOCS / f"wiring-{name}.svg", draw().svg()


def stale() -> list[tuple[Path, str]]:
    """Return the pages that differ from what they have to be."""
    return [(path, text) for path, text in pages() if not path.exists() or path.read_text("utf-8") != text]


def main() -> int:
    """Write the pages, or name the stale ones; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    args = parser.parse_args()
    old = stale()
    for path, text in old:
        if args.check:
            print(f"stale: {path.relative_to(HOUSE)}; run capture/docs/generate.py")
        else:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, "utf-8")
    return 1 if args.check and old else 0


if __name__ == "__main__":
    sys.exit(main())
