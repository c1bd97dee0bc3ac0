# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a lesson, and the file of its solutions: sections, tasks, what is to be typed, and what is right.

A task is a line in bold with its number. What is to be typed follows as a list, a line each, with its kind:

    - Bytes of the telegram (number, bytes)
    - Commands without a reaction (packets)
    - Its checksum (hex)
    - What leaves only these (filter)
    - The parameter (text)
    - Who is late (the drive / the master / nobody can know)
    - The command (telegram)
    - Two sentences to the maker (finding)

The solutions have a section for each task, and in it an item for each line above. See README.md for their form.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from lesson import Claim, claims

KINDS = ("number", "packets", "hex", "filter", "text", "telegram", "finding")
KNOW = "What to know"
PROVE = "Prove"

_SECTION = re.compile(r"^## (.+)\n", re.MULTILINE)
_TASK = re.compile(r"^\*\*(\d+)\. (.+?)\*\*$\n", re.MULTILINE | re.DOTALL)
_HINT = re.compile(r"<details>\s*<summary>Hint</summary>(.*?)</details>\n*", re.DOTALL)
_LIST = re.compile(r"(?:- .+\n(?:  .+\n)*)+(?=\n|\Z)")
_BLANK = re.compile(r"(?P<prompt>.+) \((?P<kind>[^()]+)\)")
_CODE = re.compile(r"`([^`]+)`")


class Remark(NamedTuple):
    """A known mistake, or a condition of a telegram that is not met, and what to say then; or a point of a finding."""

    code: str  # what was typed, or a display filter; empty for a point
    say: str


class Blank(NamedTuple):
    """One thing to be typed, chosen, built or written."""

    prompt: str  # Markdown
    kind: str  # one of KINDS, or "choice"
    unit: str  # of a number; of a telegram `answered`, if the reaction of a virtual drive counts, too
    choices: list[str]
    accepted: list[str]
    remarks: list[Remark]


class Task(NamedTuple):
    """A task of a lesson; texts are Markdown."""

    number: int
    text: str
    lead: str
    hint: str
    blanks: list[Blank]
    solution: str
    claims: list[Claim]


class Section(NamedTuple):
    """A part of a lesson with a heading; its text is Markdown."""

    title: str
    text: str
    tasks: list[Task]


class Lesson(NamedTuple):
    """A lesson; texts are Markdown."""

    path: Path
    title: str
    head: str  # up to the first section, without the title
    sections: list[Section]
    end: str
    claims: list[Claim]  # of what the lesson itself tells

    @property
    def aim(self) -> str:
        """What the reader can do after it."""
        return self.head.strip().split("\n\n")[0].replace("\n", " ")

    @property
    def tasks(self) -> list[Task]:
        """All tasks, in their order."""
        return [task for section in self.sections for task in section.tasks]

    @property
    def proof(self) -> Path:
        """The capture of the section Prove: one of its own, if the lesson has one."""
        own = self.path.with_name(f"{self.path.stem}-proof.pcapng")
        return own if own.with_suffix(".txt").exists() else self.path.with_suffix(".pcapng")


class Solution(NamedTuple):
    """What is right in a task, why, and what holds it against Wireshark."""

    items: list[tuple[str, list[str]]]  # an item, and what stands under it
    text: str
    claims: list[Claim]


def solutions_of(path: Path) -> Path:
    """Return the file with the solutions of a lesson."""
    return path.parent / "solutions" / path.name


def read(path: Path) -> Lesson:
    """Read a lesson. ValueError names the task whose solution is missing, or does not fit."""
    heading, _, text = path.read_text().partition("\n")
    text, _, end = text.rstrip("\n").rpartition("\n\n")
    head, *parts = _SECTION.split(text + "\n")
    solutions = _solutions(solutions_of(path))
    sections = [
        _section(path.name, title, part, solutions) for title, part in zip(parts[::2], parts[1::2], strict=True)
    ]
    if solutions:
        raise ValueError(f"solutions/{path.name}: no task has the number {', '.join(map(str, solutions))}")
    known = [claim for section in sections if section.title == KNOW for claim in claims(section.text, path.name)]
    return Lesson(path, heading.removeprefix("# "), head, sections, end, known)


def _section(name: str, title: str, text: str, solutions: dict[int, Solution]) -> Section:
    before, *parts = _TASK.split(text)
    tasks = [
        _task(name, int(number), words, body, solutions)
        for number, words, body in zip(parts[::3], parts[1::3], parts[2::3], strict=True)
    ]
    return Section(title, before.strip("\n"), tasks)


def _task(name: str, number: int, words: str, body: str, solutions: dict[int, Solution]) -> Task:
    hint = _HINT.search(body)
    body = _HINT.sub("", body)
    listed = list(_LIST.finditer(body))
    if not listed:
        raise ValueError(f"{name}: task {number} asks for nothing")
    prompts = [item for item, _ in _items(listed[-1][0])]
    lead = body[: listed[-1].start()] + body[listed[-1].end() :]
    solution = solutions.pop(number, None)
    if solution is None or len(solution.items) != len(prompts):
        raise ValueError(f"{name}: task {number} has {len(prompts)} blanks, and its solution has not")
    try:
        blanks = [_blank(prompt, *item) for prompt, item in zip(prompts, solution.items, strict=True)]
    except ValueError as error:
        raise ValueError(f"{name}: task {number}: {error}") from error
    shown = hint[1].strip() if hint else ""
    return Task(number, words.replace("\n", " "), lead.strip("\n"), shown, blanks, solution.text, solution.claims)


def _blank(prompt: str, item: str, under: list[str]) -> Blank:
    found = _BLANK.fullmatch(prompt)
    if found is None:
        raise ValueError(f"{prompt!r} does not end with its kind in brackets")
    kind, _, unit = (word.strip() for word in found["kind"].partition(","))
    choices = [choice.strip() for choice in found["kind"].split("/")] if "/" in kind else []
    if not choices and kind not in KINDS:
        raise ValueError(f"{kind} is none of {', '.join(KINDS)}, nor a choice with /")
    accepted = [] if kind == "finding" else _CODE.findall(item)
    if choices and not set(accepted) <= set(choices):
        raise ValueError(f"{item}: is none of the choices")
    remarks = [Remark("", words) for words in under] if kind == "finding" else list(_remarks(under))
    return Blank(found["prompt"], "choice" if choices else kind, unit, choices, accepted, remarks)


def _remarks(under: list[str]) -> Iterator[Remark]:
    for words in under:
        found = re.fullmatch(r"((?:`[^`]+`(?: or |, )?)+): (.+)", words)
        if found is None:
            raise ValueError(f"{words!r} is not `what was typed`: what to say")
        yield from (Remark(code, found[2]) for code in _CODE.findall(found[1]))


def _solutions(path: Path) -> dict[int, Solution]:
    """Read the solutions of a lesson by the numbers of the tasks."""
    text = path.read_text()
    parts = re.split(r"^## (\d+)\n", text, flags=re.MULTILINE)[1:]
    found = {}
    for number, body in zip(parts[::2], parts[1::2], strict=True):
        listed = _LIST.match(body.lstrip("\n"))
        if listed is None:
            raise ValueError(f"solutions/{path.name}: task {number} has no list of what is right")
        rest = body.lstrip("\n")[listed.end() :]
        found[int(number)] = Solution(_items(listed[0]), rest.strip("\n"), claims(rest, f"{path.name}, task {number}"))
    return found


def _items(block: str) -> list[tuple[str, list[str]]]:
    """Return the items of a list, each with the items under it; lines that go on are joined."""
    items: list[tuple[str, list[str]]] = []
    for line in block.rstrip("\n").split("\n"):
        if line.startswith("- "):
            items.append((line[2:], []))
        elif line.lstrip().startswith("- "):
            items[-1][1].append(line.lstrip()[2:])
        elif items[-1][1]:
            items[-1][1][-1] += " " + line.strip()
        else:
            items[-1] = (items[-1][0] + " " + line.strip(), [])
    return items
