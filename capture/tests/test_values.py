# SPDX-License-Identifier: GPL-2.0-or-later
"""Live values of `sistap record`: what is sent, and that a server that is away disturbs nothing."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import types
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest
from commands import refused, run
from portable import posix

from sistap import cli
from sistap.commands.recorder import outlets
from sistap.commands.recorder import values as values_module
from sistap.commands.recorder.keeper import Around
from sistap.commands.recorder.outlets import SECRET, Refused, Undelivered, Value, line, message, outlet_of, topic
from sistap.commands.recorder.recorder import Recorder, Wanted
from sistap.commands.recorder.values import Values
from sistap.commands.recorder.watching import judges
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.captures import reading
from sistap.dissected.episodes.live import LIVE
from sistap.dissected.explain.relay import Seams
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.packages import NotInstalled
from sistap.tap.files.pcapng import Interface
from sistap.tap.terminal.exits import UsageError

PATIENCE_S = 60
thorough = pytest.mark.thorough


def access(value: str = "1000.5 rpm", number: float | None = 1000.5, **more: Any) -> Access:
    parameter = Parameter("/dev/ttyUSB0", "3", 7, "S-0-0040")
    said = {"name": "Velocity feedback value", "unit": "rpm", "error": ""} | more
    return Access(
        said.pop("parameter", parameter),
        False,
        16,
        value=value,
        number=number,
        data=None,
        minimum="",
        maximum="",
        **said,
    )


def value(*arguments: Any, **more: Any) -> Value:
    return Value(1_773_522_060_025_791_346, access(*arguments, **more))


@pytest.fixture(autouse=True)
def _this_computer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outlets, "_HOST", "pi")
    monkeypatch.setattr(values_module, "_TURN_S", 0.01)
    monkeypatch.setattr(values_module, "_PAUSES_S", (0.01, 0.02))


# -- What is sent


def test_a_line() -> None:
    tags = "sis,device=7,host=pi,parameter=S-0-0040,port=/dev/ttyUSB0,station=3"
    names = 'name="Velocity feedback value",unit="rpm"'
    assert line(value()) == f"{tags} value=1000.5,{names} 1773522060025791346"
    assert line(value("00 01", None, name="", unit="")) == f'{tags} text="00 01" 1773522060025791346'


def test_a_number_without_decimals_is_a_number() -> None:
    assert " value=7," in line(value("7 rpm", 7))
    assert json.loads(message(value("7 rpm", 7)))["value"] == 7


@pytest.mark.parametrize("number", [float("inf"), float("nan")])
def test_what_no_number_can_say_is_text(number: float) -> None:
    """Neither the line protocol nor JSON has these."""
    assert 'text="too much",' in line(value("too much", number))
    assert json.loads(message(value("too much", number)))["value"] == "too much"


@pytest.mark.attack("a drive names a parameter like a line, a tag or a topic of live values", "escaped; it adds none")
def test_a_name_adds_nothing() -> None:
    """The reference of the line protocol: a \\ before a comma, = or blank of a tag, and before a " or \\ of a text."""
    parameter = Parameter("a b,c=d\\", "3/2", 7, "#/+\n=")
    hostile = value(name='x"\nsis value=1 1\\', unit="\u202e", parameter=parameter)
    assert line(hostile) == (
        "sis,device=7,host=pi,parameter=#/+/n\\=,port=a\\ b\\,c\\=d/,station=3/2 "
        'value=1000.5,name="x\\"\\\\nsis value=1 1\\\\",unit="\\\\u202e" 1773522060025791346'
    )
    assert topic(hostile) == "3-2/7/---\\n="
    assert json.loads(message(hostile))["name"] == 'x"\nsis value=1 1\\'


def test_a_message_of_mqtt() -> None:
    assert json.loads(message(value())) == {
        **{"time": "2026-03-14T21:01:00.025Z", "value": 1000.5, "unit": "rpm", "name": "Velocity feedback value"},
        **{"device": "7", "host": "pi", "parameter": "S-0-0040", "port": "/dev/ttyUSB0", "station": "3"},
    }
    assert topic(value()) == "3/7/S-0-0040"


@pytest.mark.parametrize(
    "url", ["x", "file:///x", "http://", "http://[", "http://h:x/", "mqtt:///topic", "mqtt://h:0/x", ""]
)
def test_what_is_no_address(url: str) -> None:
    with pytest.raises(UsageError, match="it is - for standard output, http://"):
        outlet_of(url, {})


@pytest.mark.parametrize("url", ["http://me:word@h/write", "http://h/write?u=me&p=word", "mqtt://me:@h/x"])
def test_a_password_in_a_command_is_refused(url: str) -> None:
    with pytest.raises(UsageError, match=SECRET) as refused:
        outlet_of(url, {})
    assert "word@" not in str(refused.value)


# -- Over HTTP


class Server(HTTPServer):
    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Answering)
        self.answers = [204]  # the last one stays
        self.elsewhere = ""
        self.heard: list[tuple[str, str | None, str]] = []

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.server_port}"


class Answering(BaseHTTPRequestHandler):
    server: Server

    def do_POST(self) -> None:  # noqa: N802 - so it is called
        said = self.rfile.read(int(self.headers["Content-Length"])).decode()
        self.server.heard.append((self.path, self.headers["Authorization"], said))
        answers = self.server.answers
        self.send_response(answers.pop(0) if len(answers) > 1 else answers[0])
        if self.server.elsewhere:
            self.send_header("Location", self.server.elsewhere)
        self.end_headers()
        self.wfile.write(b"so it is")

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        yield server
        server.shutdown()


def test_lines_over_http(server: Server) -> None:
    outlet = outlet_of(f"http://{server.address}/write?db=sis", {})
    outlet.deliver([value(), value("2 rpm", 2.0)])
    assert server.heard == [("/write?db=sis", None, f"{line(value())}\n{line(value('2 rpm', 2.0))}\n")]
    assert outlet.name == f"http://{server.address}/write"


@pytest.mark.parametrize(("user", "head"), [("", "Token word"), ("m%40e@", "Basic bUBlOndvcmQ=")])  # m@e:word
def test_a_secret_comes_from_the_environment(server: Server, user: str, head: str) -> None:
    outlet = outlet_of(f"http://{user}{server.address}/write", {SECRET: "word"})
    outlet.deliver([value()])
    assert server.heard[0][1] == head
    assert "word" not in outlet.name and "@" not in outlet.name


@pytest.mark.parametrize(("code", "kind"), [(400, Refused), (422, Refused), (401, Undelivered), (503, Undelivered)])
def test_what_a_server_refuses(server: Server, code: int, kind: type[Exception]) -> None:
    server.answers = [code]
    with pytest.raises(kind, match=f"{code} .* so it is"):
        outlet_of(f"http://{server.address}/write", {}).deliver([value()])


@pytest.mark.parametrize("code", [301, 302, 303, 307, 308])
@pytest.mark.parametrize("elsewhere", ["http://{}/write", "ftp://{}/x", "file:///etc/passwd"])
@pytest.mark.attack("a server of live values names another address", "nobody but it gets a value or the secret")
def test_a_server_that_sends_elsewhere(server: Server, code: int, elsewhere: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        other.settimeout(0)
        server.answers, server.elsewhere = [code], elsewhere.format(f"127.0.0.1:{other.getsockname()[1]}")
        with pytest.raises(Undelivered, match=str(code)):
            outlet_of(f"http://{server.address}/write", {SECRET: "word"}).deliver([value()])
        with pytest.raises(BlockingIOError):
            other.accept()


@pytest.mark.parametrize(
    "answer",
    [
        b"",
        b"no HTTP at all\r\n" * 9999,
        b"HTTP/1.1 500 " + b"x" * 60_000 + b"\r\n\r\n",
        b"HTTP/1.1 500 \x1b]0;x\x07\r\nContent-Length: 5\r\n\r\n",
        b"HTTP/1.1 200 OK\r\n" + b"X: " + b"y" * 70_000 + b"\r\n\r\n",
        b"HTTP/1.1 200 OK\r\n" + b"X: y\r\n" * 9999 + b"\r\n",
        b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
        b"HTTP/1.1 500 E\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
        b"HTTP/1.1 99999 E\r\n\r\n",
    ],
    ids=range(9),
)
@pytest.mark.attack("a server of live values answers with what is no answer of HTTP", "one short line; they wait")
def test_a_server_that_talks_nonsense(answer: bytes) -> None:
    def serve(listening: socket.socket) -> None:
        connection, _ = listening.accept()
        with connection, suppress(OSError):
            connection.recv(1 << 16)
            connection.sendall(answer)

    said: SimpleQueue[str] = SimpleQueue()
    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=serve, args=(listening,), daemon=True).start()
        values = Values(outlet_of(f"http://127.0.0.1:{listening.getsockname()[1]}/write", {}))
        values.start(said.put)
        values.put(1, [value().access])
        words = said.get(timeout=PATIENCE_S)
    assert "cannot be delivered" in words and len(words) < 500


def test_a_server_that_is_away() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        with pytest.raises(Undelivered, match="refused"):
            outlet_of(f"http://127.0.0.1:{taken.getsockname()[1]}/write", {}).deliver([value()])


def test_a_server_that_hangs_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=lambda: listening.accept()[0].close(), daemon=True).start()
        with pytest.raises(Undelivered):
            outlet_of(f"http://127.0.0.1:{listening.getsockname()[1]}/write", {}).deliver([value()])


# -- To a broker


class Code:
    """What paho-mqtt 2 has in place of a number. It is never false."""

    def __init__(self, number: int) -> None:
        self.number = number

    def __eq__(self, other: object) -> bool:
        return self.number == other

    def __str__(self) -> str:
        return "not authorised" if self.number else "Success"


class Broker:
    """In place of the library paho-mqtt and the broker behind it."""

    def __init__(self, answer: int = 0, *, acknowledges: bool = True, is_new: bool = True) -> None:
        self.heard: list[tuple[str, str]] = []
        self.asked: list[object] = []
        self._answer, self.acknowledges, self._is_new = answer, acknowledges, is_new
        self.waiting: list[int] = []
        self.is_away = False
        if is_new:
            self.CallbackAPIVersion = types.SimpleNamespace(VERSION2="2")

    def Client(self, *version: str) -> Broker:  # noqa: N802 - so it is called
        assert version == (("2",) if self._is_new else ())
        return self

    def connack_string(self, answer: int) -> str:
        return "not authorised" if answer else ""

    def connect(self, *host: object) -> None:
        self.asked.append(host)

    def loop_start(self) -> None:
        said = [Code(self._answer), "properties"] if self._is_new else [self._answer]
        self.on_connect(self, None, {}, *said)  # type: ignore[attr-defined]

    def is_connected(self) -> bool:
        return len(self.asked) > 0 and not self._answer and not self.is_away

    def publish(self, name: str, payload: str, qos: int) -> types.SimpleNamespace:
        assert qos == 1
        self.heard.append((name, payload))
        self.waiting.append(len(self.heard))
        if self.acknowledges:
            self.acknowledge()
        return types.SimpleNamespace(mid=len(self.heard))

    def acknowledge(self) -> None:
        more = ["reason", "properties"] if self._is_new else []
        while self.waiting:
            self.on_publish(self, None, self.waiting.pop(), *more)  # type: ignore[attr-defined]

    def username_pw_set(self, *who: object) -> None:
        self.asked.append(who)

    def tls_set(self) -> None:
        self.asked.append("tls")

    def reconnect_delay_set(self, *_: int) -> None: ...
    def disconnect(self) -> None: ...
    def loop_stop(self) -> None: ...


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Callable[[Broker], Broker]:
    def library(broker: Broker) -> Broker:
        monkeypatch.setitem(sys.modules, "paho.mqtt.client", broker)
        monkeypatch.setattr(outlets, "PATIENCE_S", 0.05)
        return broker

    return library


Library = Callable[[Broker], Broker]


@pytest.mark.parametrize("is_new", [True, False])
def test_messages_to_a_broker(library: Library, is_new: bool) -> None:
    """With paho-mqtt 2 and 1."""
    broker = library(Broker(is_new=is_new))
    outlet = outlet_of("mqtts://me@h/press%204/values/", {SECRET: "word"})
    outlet.deliver([value()])
    outlet.deliver([value("2 rpm", 2.0)])
    assert broker.asked == [("me", "word"), "tls", ("h", 8883)]
    assert broker.heard == [("press 4/values/3/7/S-0-0040", message(one)) for one in (value(), value("2 rpm", 2.0))]
    assert outlet.name == "mqtts://h:8883/press 4/values"


@pytest.mark.parametrize("is_new", [True, False])
def test_a_broker_that_refuses(library: Library, is_new: bool) -> None:
    broker = library(Broker(answer=5, is_new=is_new))
    with pytest.raises(Undelivered, match="the broker answers: not authorised"):
        outlet_of("mqtt://h/x", {}).deliver([value()])
    assert broker.asked == [("h", 1883)] and not broker.heard


def test_what_is_not_acknowledged_is_not_sent_twice(library: Library) -> None:
    """The library sends it again by itself, when the broker is back."""
    broker = library(Broker(acknowledges=False))
    outlet = outlet_of("mqtt://h/x", {})
    for _ in range(2):
        with pytest.raises(Undelivered, match="does not acknowledge"):
            outlet.deliver([value()])
    broker.acknowledge()
    outlet.deliver([value()])
    assert len(broker.heard) == 1
    broker.is_away = True
    with pytest.raises(Undelivered, match="no connection"):
        outlet.deliver([value()])


@pytest.mark.parametrize("url", ["mqtt://h", "mqtt://h/", "mqtt://h/a/%23", "mqtt://h/+/x"])
def test_a_topic_is_needed(library: Library, url: str) -> None:
    library(Broker())
    with pytest.raises(UsageError, match="needs a topic"):
        outlet_of(url, {})


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    with pytest.raises(NotInstalled, match="paho-mqtt is missing"):
        outlet_of("mqtt://h/x", {})


@thorough
def test_a_true_broker(tmp_path: Path) -> None:
    client = pytest.importorskip("paho.mqtt.client", reason="paho-mqtt talks to it: pip install paho-mqtt")
    mosquitto = shutil.which("mosquitto", path=f"{os.environ['PATH']}{os.pathsep}/usr/sbin")
    if not mosquitto:
        pytest.skip("no broker: apt-get install mosquitto")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    outlet = outlet_of(f"mqtt://127.0.0.1:{port}/press-4", {})
    with pytest.raises(Undelivered, match="refused"):
        outlet.deliver([value()])
    broker = subprocess.Popen([mosquitto, "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    heard: list[tuple[str, bytes]] = []
    versions = getattr(client, "CallbackAPIVersion", None)
    listener = client.Client(versions.VERSION2) if versions else client.Client()
    subscribed, came = threading.Event(), threading.Event()
    listener.on_subscribe = lambda *_: subscribed.set()

    def hear(_client: object, _data: object, told: Any) -> None:
        heard.append((told.topic, told.payload))
        came.set()

    listener.on_message = hear
    try:
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s:
            try:
                listener.connect("127.0.0.1", port)
                break
            except OSError:
                time.sleep(0.05)
        listener.subscribe("press-4/#")
        listener.loop_start()
        assert subscribed.wait(PATIENCE_S)
        outlet.deliver([value()])
        assert came.wait(PATIENCE_S)
        assert heard == [("press-4/3/7/S-0-0040", message(value()).encode())]
    finally:
        outlet.close()
        listener.loop_stop()
        broker.terminate()
        broker.wait()


# -- Beside a recording


class Kept:
    """An outlet that fails as often as it is told, and can hang."""

    name = "a server"

    def __init__(self, *failures: Exception) -> None:
        self.failures = list(failures)
        self.heard: list[Value] = []
        self.may_go = threading.Event()
        self.may_go.set()
        self.is_closed = False

    def deliver(self, values: Sequence[Value]) -> None:
        assert self.may_go.wait(PATIENCE_S)
        if self.failures:
            raise self.failures.pop(0)
        self.heard += values

    def close(self) -> None:
        self.is_closed = True


def wait_until(is_done: Callable[[], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not is_done():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_refused_access_has_no_value() -> None:
    kept = Kept()
    values = Values(kept)
    values.start(lambda said: pytest.fail(said))
    values.put(1, [access(error="0x8002"), access("", None), access("1 rpm", 1.0)])
    values.close()
    assert [one.plain for one in kept.heard] == [1.0] and kept.is_closed


def test_it_tries_again_and_says_so_once() -> None:
    kept = Kept(Undelivered("away"), Undelivered("away"), ValueError("a fault of ours"))
    said: list[str] = []
    values = Values(kept)
    values.start(said.append)
    values.put(1, [access("1 rpm", 1.0)])
    values.put(2, [access("2 rpm", 2.0)])
    wait_until(lambda: len(kept.heard) == 2)
    values.close()
    assert [one.time_ns for one in kept.heard] == [1, 2]
    assert said == [
        "values cannot be delivered to a server: away. Trying again; 50000 can wait",
        "values cannot be delivered to a server: ValueError('a fault of ours'). Trying again; 50000 can wait",
        "values are delivered to a server again",
    ]


def test_what_is_refused_is_left_out() -> None:
    kept = Kept(Refused("no such field"))
    said: list[str] = []
    values = Values(kept)
    values.start(said.append)
    values.put(1, [access("1 rpm", 1.0)])
    wait_until(lambda: bool(said))
    values.put(2, [access("2 rpm", 2.0)])
    values.close()
    assert [one.time_ns for one in kept.heard] == [2]
    assert said == [
        "a server refuses values: no such field. They are left out",
        "1 value could not be delivered to a server",
    ]


def hanging(monkeypatch: pytest.MonkeyPatch, said: list[str]) -> tuple[Kept, Values]:
    """Return a server that hangs with the value of time 0, and the values for it: ten can wait."""
    monkeypatch.setattr(values_module, "MOST", 10)
    kept = Kept(Undelivered("slow"))
    kept.may_go.clear()
    values = Values(kept)
    values.put(0, [access()])
    values.start(said.append)
    wait_until(lambda: bool(values._batch))
    return kept, values


def test_a_server_that_hangs_delays_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oldest values go. At the end, nobody waits long for it."""
    monkeypatch.setattr(values_module, "PATIENCE_S", 0.1)
    said: list[str] = []
    kept, values = hanging(monkeypatch, said)
    for number in range(1, 31):
        values.put(number, [access()])
    values.close()
    assert not kept.may_go.is_set() and not kept.is_closed  # it hangs still
    assert said == ["31 values could not be delivered to a server"]
    kept.may_go.set()
    wait_until(lambda: kept.is_closed)


def test_what_was_too_much_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    kept, values = hanging(monkeypatch, said)
    for number in range(1, 31):
        values.put(number, [access()])
    kept.may_go.set()
    wait_until(lambda: len(kept.heard) == 11)
    values.close()
    assert [one.time_ns for one in kept.heard] == [0, *range(21, 31)]
    assert said[1:] == ["values are delivered to a server again; 20 were too many to wait"]


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("traffic") / "x.pcapng"
    assert cli.main(["bus", "demo", "--cycles", "12", "-w", str(path)]) == 0
    return path


@pytest.mark.parametrize("keep", ["faults", *(pytest.param(one, marks=thorough) for one in ("nothing", "writes"))])
def test_each_value_is_sent_once(tshark: Tshark, traffic: Path, tmp_path: Path, keep: str) -> None:
    """Also while one tshark takes over from another."""
    fields = ["-T", "fields", "-e", "frame.time_epoch", "-e", "sis.access"]
    told = tshark.output("-r", str(traffic), "-Y", "sis.access", *fields)
    answered = [line for line in told.splitlines() if '"value"' in line]
    kept = Kept()
    values = Values(kept)
    deciding = judges(tshark, [keep], LIVE, values)
    wanted = Wanted(tmp_path, deciding, Around(0, 0), 100)
    line_0 = {0: Interface(252, "a line of a test")}
    recorder = Recorder(wanted, tshark, line_0, lambda said: pytest.fail(said), seams=Seams(packets=60))
    values.start(lambda said: pytest.fail(said))
    first, *rest = reading.records(traffic)
    recorder.begin(first)
    for record in rest:
        recorder.write(record)
    recorder.end(rest[-1].time_ns)
    values.close()
    sent = [(one.time_ns, one.access.parameter.ident) for one in kept.heard]
    assert [f"{time_ns // 10**9}.{time_ns % 10**9:09}" for time_ns, _ in sent] == [
        line.partition("\t")[0] for line in answered
    ]
    assert len(sent) > 20 and all(f'"{ident}"' in line for (_, ident), line in zip(sent, answered, strict=True))
    assert any(isinstance(one.plain, float) and one.access.unit for one in kept.heard)


@posix("Windows has no descriptor to hand on")
@pytest.mark.parametrize("is_reader_gone", [False, pytest.param(True, marks=thorough)])
def test_lines_on_standard_output(tmp_path: Path, is_reader_gone: bool) -> None:
    """From end to end. A reader that is gone does not end the recording."""
    command = [sys.executable, "-m", "sistap"]
    bus = subprocess.Popen(
        [*command, "bus", "demo", "--fast", "--cycles", "60", "--listen", str(tmp_path / "bus")],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert bus.stdout and bus.stdout.readline()
    reader, writer = os.pipe()
    options = ["--keep", "nothing", "--values", "-", "-w", "kept", "-c", "120"]
    recorder = subprocess.Popen(
        [*command, "record", "-i", f"bus://{tmp_path}/bus", *options],
        cwd=tmp_path,
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(writer)
    if is_reader_gone:
        os.close(reader)
        lines = []
    else:
        with open(reader) as file:
            lines = file.read().splitlines()
    _, errors = recorder.communicate(timeout=PATIENCE_S)
    bus.send_signal(signal.SIGTERM)
    bus.communicate()
    assert "telegrams, 0 of them damaged" in errors and "0 files kept" in errors
    assert ("could not be delivered to standard output" in errors) == is_reader_gone
    assert recorder.returncode == 0 and "Traceback" not in errors
    if not is_reader_gone:
        assert lines and all(line.startswith("sis,device=") for line in lines)
        assert any(" value=" in line and 'unit="rpm"' in line for line in lines)


def test_options_that_do_not_fit(tmp_path: Path) -> None:
    for options, words in (
        (["--values", "ftp://h"], "it is - for standard output"),
        (["--values", "mqtt://me:word@h/x"], SECRET),
        (["--keep", "nothing"], "--keep nothing is for"),
    ):
        refused(run(tmp_path, "record", "-i", "bus://none", "-w", "kept", *options), 2, words)
    assert not (tmp_path / "kept").exists()
