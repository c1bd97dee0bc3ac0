# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a lesson in its parts: what is said, and its questions with hints, what is typed as an answer, and answers.

A question is a line in bold with its number. What may follow it, in forms that read well where nothing checks them:

    <details><summary>Hint</summary>Where to look.</details>

and, as the first thing in its folded answer, a list of what is to be typed, a line each, with its kind:

    - Bytes of packet 4 (number): `27`
    - Commands without a reaction (packets): `7, 8, 11`
    - Its checksum (hex): `C3`
    - What leaves only these (filter): `sis.service == 3`
    - The parameter (text): `S-0-0095`
    - Who is late (the drive / the master): `the drive`

Several answers are right where they stand as `S-0-0036` or `36`. A question without such a list asks for the first
thing that its answer claims.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

from lesson import Bytes, Claim, Filter, Value, claims

KINDS = ("number", "packets", "hex", "filter", "text")

_QUESTION = re.compile(r"^\*\*(\d+)\. (.+?)\*\*$\n", re.MULTILINE | re.DOTALL)
_HINT = re.compile(r"<details>\s*<summary>Hint</summary>(.*?)</details>\n*", re.DOTALL)
_ANSWER = re.compile(r"<details>\n<summary>Answer</summary>\n\n(.*?)\n\n</details>\n*", re.DOTALL)
_ASKS = re.compile(r"(?:- .+\n(?:  .+\n)*)+(?=\n)")
_ASK = re.compile(r"- (?P<prompt>.+) \((?P<kind>[^()]+)\): (?P<accepted>`.+`)")


class Ask(NamedTuple):
    """One thing to be typed or chosen."""

    prompt: str  # Markdown
    kind: str  # one of KINDS, or "choice"
    accepted: list[str]
    choices: list[str]


class Question(NamedTuple):
    """A question of a lesson; texts are Markdown."""

    number: int
    text: str
    lead: str  # what stands between the question and its hint or answer
    hint: str
    asks: list[Ask]
    answer: str
    marked: bool  # its hint and its asks are the lesson's, not taken from its claims


class Lesson(NamedTuple):
    """A lesson; texts are Markdown."""

    path: Path
    title: str
    text: str  # up to the questions, without the title
    questions: list[Question]
    end: str  # what follows the last answer
    claims: list[Claim]

    @property
    def aim(self) -> str:
        """What the reader can do after it."""
        return self.text.strip().split("\n\n")[0].replace("\n", " ")


def read(path: Path) -> Lesson:
    """Read a lesson. ValueError if a question has no answer, or nothing in it that can be checked."""
    whole = path.read_text()
    heading, _, text = whole.partition("\n")
    text, _, questions = text.partition("\n## Questions\n")
    found = list(_QUESTION.finditer(questions))
    ends = [match.start() for match in found[1:]] + [len(questions)]
    said = claims(path)
    first_line = whole.count("\n", 0, len(whole) - len(questions)) + 1
    asked, rest = [], ""
    for match, end in zip(found, ends, strict=True):
        lines = range(first_line + questions.count("\n", 0, match.start()), first_line + questions.count("\n", 0, end))
        question, rest = _question(
            path.name, match, questions[match.end() : end], [claim for claim in said if claim.line in lines]
        )
        asked.append(question)
    return Lesson(path, heading.removeprefix("# "), text, asked, rest, said)


def _question(name: str, match: re.Match[str], body: str, said: list[Claim]) -> tuple[Question, str]:
    """Return a question, and what follows its answer."""
    hint, answer = _HINT.search(body), _ANSWER.search(body)
    if answer is None:
        raise ValueError(f"{name}: question {match[1]} has no answer")
    words = answer[1] + "\n\n"
    listed = _ASKS.match(words)
    asks = list(_asks(listed[0])) if listed else []
    if asks and listed:
        words = words[listed.end() :]
    marked = bool(hint and asks)
    asks = asks or _claimed(said)
    if not asks:
        raise ValueError(f"{name}: question {match[1]} has nothing to check")
    lead = _HINT.sub("", body[: answer.start()]).strip()
    shown = hint[1].strip() if hint else _look(said)
    question = Question(int(match[1]), match[2].replace("\n", " "), lead, shown, asks, words.strip("\n"), marked)
    return question, body[answer.end() :].strip()


def _asks(block: str) -> Iterator[Ask]:
    for item in re.sub(r"\n +", " ", block).strip().split("\n"):
        found = _ASK.fullmatch(item)
        if found is None:
            return  # a list like others
        kind, accepted = found["kind"], re.findall(r"`([^`]+)`", found["accepted"])
        choices = [choice.strip() for choice in kind.split("/")] if "/" in kind else []
        if not choices and kind not in KINDS:
            raise ValueError(f"{item}: {kind} is none of {', '.join(KINDS)}, nor a choice with /")
        if choices and not set(accepted) <= set(choices):
            raise ValueError(f"{item}: the answer is none of the choices")
        yield Ask(found["prompt"], "choice" if choices else kind, accepted, choices)


def _claimed(said: list[Claim]) -> list[Ask]:
    """Make something to be typed from the first claim that has it."""
    for claim in said:
        match claim:
            case Filter(_, expression, packets):
                numbers = ", ".join(map(str, packets)) or "none"
                return [Ask(f"Packets that `{expression}` leaves", "packets", [numbers], [])]
            case Value(_, packet, field, value) if value != "there":
                return [Ask(f"`{field}` of packet {packet}", _kind(value), [value], [])]
            case Bytes(_, data):
                return [Ask("The bytes", "hex", [data.hex(" ").upper()], [])]
    return []


def _kind(value: str) -> str:
    try:
        Decimal(int(value, 16) if value.startswith("0x") else value)
    except (InvalidOperation, ValueError):
        return "text"
    return "number"


def _look(said: list[Claim]) -> str:
    packets = sorted({claim.packet for claim in said if isinstance(claim, Value)})
    return f"Look at packet {packets[0]}." if packets else "Try the filters above."
