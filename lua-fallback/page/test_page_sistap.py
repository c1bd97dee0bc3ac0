# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap in the page, which is Python and Wireshark as WebAssembly, does what its commands do."""

from __future__ import annotations

import json
import subprocess
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import pytest
from logs import LOGS
from recordings import METADATA, RECORDINGS

from make import HERE as CAPTURES
from parity import SCRIPT
from sisbus.scenarios import scenario

Job = dict[str, Any]
CAPTURE = SCRIPT.parents[1] / "capture"
# They need a library that the page has not.
COMPARED = {"good.pcapng": "course/06-timing", "bad.pcapng": "course/07-silence"}
NEED_MORE = {f"sistap.commands.tables.{name}" for name in ("convert", "judging", "schema", "store")}

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(900)]


@pytest.fixture(scope="module")
def jobs(node: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Callable[[list[Job]], list[Any]]:
    """Run jobs of test/sistap.mjs."""

    def run(jobs: list[Job]) -> list[Any]:
        path = tmp_path_factory.mktemp("jobs") / "jobs.json"
        path.write_text(json.dumps(jobs))
        done: list[Any] = node("sistap.mjs", path)
        return done

    return run


def job(words: list[str], wanted: str, **files: bytes) -> Job:
    named = {name.replace("_", "."): b64encode(data).decode() for name, data in files.items()}
    return {"words": words, "files": named, "wanted": [wanted]}


def command(folder: Path, *words: str) -> str:
    """Run a command with sis.lua; return what it says."""
    environment = {"PYTHONPATH": str(CAPTURE), "WIRESHARK_PLUGIN_DIR": str(folder), "PATH": "/usr/bin:/bin"}
    done = subprocess.run(
        [sys.executable, "-m", "sistap", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stderr


def packets(capture: bytes) -> bytes:
    """Return a capture without its first block, which names the computer."""
    return capture[int.from_bytes(capture[4:8], "little") :]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Make a folder with the script."""
    (tmp_path / SCRIPT.name).write_bytes(SCRIPT.read_bytes())
    return tmp_path


def test_every_portable_module_can_be_imported(jobs: Callable[[list[Job]], list[Any]]) -> None:
    """Modules for a certain system refuse by themselves."""
    names = [
        ".".join(path.relative_to(CAPTURE).with_suffix("").parts).removesuffix(".__init__")
        for package in ("sistap", "sisbus")
        for path in sorted((CAPTURE / package).rglob("*.py"))
        if path.stem != "__main__"
    ]
    wanted = [name for name in names if name not in NEED_MORE]
    assert len(wanted) > 100
    assert jobs([{"modules": wanted}]) == [{}]


def test_logs_are_explained_as_the_command_does(jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    logs = {name: text if isinstance(text, bytes) else text.encode() for name, (text, _) in LOGS.items()}
    words = ["annotate", "log.txt", "-o", "out.txt", "--force"]
    for (name, log), done in zip(
        logs.items(), jobs([job(words, "out.txt", log_txt=log) for log in logs.values()]), strict=True
    ):
        (folder / "log.txt").write_bytes(log)
        said = command(folder, *words)
        assert (done["said"], done["code"]) == (said, 0), name
        assert b64decode(done["written"]["out.txt"]) == (folder / "out.txt").read_bytes(), name


def test_recordings_are_imported_as_the_command_does(jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    """A session is a zip; Wireshark's own dissectors of adapters do not take what is on the line."""
    wanted = []
    for name, recording in RECORDINGS.items():
        recording.write(folder / name)
        wanted.append(["import", name, "-w", f"{name}.pcapng", *recording.options])
    done = jobs(
        [job(words, words[3], **{words[1].replace(".", "_"): (folder / words[1]).read_bytes()}) for words in wanted]
    )
    for words, one in zip(wanted, done, strict=True):
        said = command(folder, *words)
        assert (one["said"], one["code"]) == (said, 0)
        assert RECORDINGS[words[1]].said in said
        assert packets(b64decode(one["written"][words[3]])) == packets((folder / words[3]).read_bytes())


@pytest.mark.attack(
    "page: a .sr file that unpacks to 300 MB",
    "read in pieces: Python needs less than 100 MB; a file with more than 16 million edges is refused",
)
def test_a_session_that_is_packed_well(jobs: Callable[[list[Job]], list[Any]], tmp_path: Path) -> None:
    """Nothing changes in one; in the others every sample, and every second one: faster than any line."""
    whys = {b"\0\0\0\0": "has no channel that changes", b"\0\1\0\1": "usual rate", b"\0\0\1\1": "usual rate"}
    for levels, why in whys.items():
        with ZipFile(tmp_path / "x.sr", "w", ZIP_DEFLATED) as archive:
            archive.writestr("version", "2")
            archive.writestr("metadata", METADATA)
            with archive.open("logic-1-1", "w") as file:
                for _ in range(300):
                    file.write(levels * 250_000)
        (done,) = jobs([job(["import", "x.sr", "-w", "out"], "out", x_sr=(tmp_path / "x.sr").read_bytes())])
        assert done["code"] == 2
        assert why in done["said"]
        assert done["memory"] < 100_000_000


@pytest.mark.parametrize("name", ["07-silence", "09-long-data"])
def test_a_capture_becomes_the_same_log(name: str, jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    capture = (CAPTURES / "course" / f"{name}.pcapng").read_bytes()
    words = ["log", "a.pcapng", "-o", "out.txt"]
    (folder / "a.pcapng").write_bytes(capture)
    command(folder, *words)
    (done,) = jobs([job(words, "out.txt", a_pcapng=capture)])
    assert b64decode(done["written"]["out.txt"]).decode() == (folder / "out.txt").read_text()


def test_a_comparison_is_the_same_page(jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    files = {name: (CAPTURES / f"{path}.pcapng").read_bytes() for name, path in COMPARED.items()}
    words = ["compare", *files, "--format", "html", "-o", "out.html"]
    for name, data in files.items():
        (folder / name).write_bytes(data)
    assert command(folder, *words) == ""
    (done,) = jobs([job(words, "out.html", **{name.replace(".", "_"): data for name, data in files.items()})])
    assert b64decode(done["written"]["out.html"]).decode() == (folder / "out.html").read_text()


@pytest.mark.parametrize("name", ["accesses", "course/07-silence", "specification"])
def test_changes_are_the_same_table(name: str, jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    capture = (CAPTURES / f"{name}.pcapng").read_bytes()
    words = ["parameters", "--changes", "--csv", "a.pcapng", "-o", "out.csv"]
    (folder / "a.pcapng").write_bytes(capture)
    said = command(folder, *words)
    (done,) = jobs([job(words, "out.csv", a_pcapng=capture)])
    assert (done["said"], done["code"]) == (said, 0)
    assert b64decode(done["written"]["out.csv"]).decode() == (folder / "out.csv").read_text()


@pytest.mark.parametrize("name", ["course/06-timing", "accesses", "duplex", "statistics"])
def test_the_report_is_the_same_page(name: str, jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    capture = (CAPTURES / f"{name}.pcapng").read_bytes()
    words = ["report", "a.pcapng", "-o", "out.html"]
    (folder / "a.pcapng").write_bytes(capture)
    assert command(folder, *words) == "sistap: out.html written\n"
    (done,) = jobs([job(words, "out.html", a_pcapng=capture)])
    assert b64decode(done["written"]["out.html"]).decode() == (folder / "out.html").read_text()


def test_bus_plays_the_same_bytes(jobs: Callable[[list[Job]], list[Any]], folder: Path) -> None:
    """Every scenario with masters and stations."""
    complete = [name for name in scenario.names() if scenario.load(name).is_complete]
    words = {name: ["bus", name, "-w", f"{name}.pcapng", "--seed", "7", "--duration", "2"] for name in complete}
    for name, done in zip(complete, jobs([job(words[name], f"{name}.pcapng") for name in complete]), strict=True):
        command(folder, *words[name])
        assert b64decode(done["written"][f"{name}.pcapng"]) == (folder / f"{name}.pcapng").read_bytes(), name
