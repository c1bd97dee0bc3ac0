# SPDX-License-Identifier: GPL-2.0-or-later
"""Where live values go: standard output and HTTP take lines of InfluxDB's line protocol, a broker of MQTT takes JSON.

Each value has a topic of its own. Text of a drive is escaped: no name of a parameter adds a line, a tag or a topic.
"""

from __future__ import annotations

import http.client
import json
import math
import os
import re
import socket
import threading
import time
import urllib.error
import urllib.request
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol
from urllib.parse import SplitResult, parse_qs, unquote, urlsplit

import sistap
from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.episode import utc
from sistap.tap.common.packages import needed
from sistap.tap.terminal.console import STANDARD_OUTPUT, visible
from sistap.tap.terminal.exits import UsageError

SECRET = "SISTAP_VALUES_SECRET"
PATIENCE_S = 10.0  # for an answer

_HOST = socket.gethostname()
_TAG = str.maketrans(
    {",": "\\,", "=": "\\=", " ": "\\ ", "\\": "/"}
)  # a \ at the end of a tag would escape what follows
_TEXT = str.maketrans({'"': '\\"', "\\": "\\\\"})
_NO_LEVEL = re.compile(r"[/+#]")  # what separates the levels of a topic, or stands for several
_REFUSED = {400, 413, 422}  # HTTP: the same lines are refused again
_AWAY = "no connection"
_SHOWN = 200  # characters of an answer
_SECRETS = {"p", "password", "token"}  # in a query
_FORMS = "- for standard output, http://HOST:8086/write?db=NAME, or mqtt://HOST/TOPIC"


class Undelivered(Exception):
    """The values cannot be delivered now; the text is the reason."""


class Refused(Exception):
    """The values will never be taken; the text is the reason."""


class Value(NamedTuple):
    """A value of a parameter."""

    time_ns: int
    access: Access

    @property
    def plain(self) -> float | str:
        """Return it as a number, if it is one."""
        plain = self.access.plain
        return plain if isinstance(plain, int | float) and math.isfinite(plain) else self.access.value


class Outlet(Protocol):
    """Takes values. It may wait: it has a thread of its own."""

    name: str  # for messages

    def deliver(self, values: Sequence[Value]) -> None:
        """Deliver all of them. Undelivered: it gets the same ones again. Refused: it does not."""

    def close(self) -> None:
        """Hang up."""


def outlet_of(text: str, environment: Mapping[str, str] = os.environ) -> Outlet:
    """Return the outlet that --values names. UsageError; NotInstalled without a library that it needs."""
    if text == STANDARD_OUTPUT:
        return _StandardOutput()
    try:
        url = urlsplit(text)
        is_known = url.scheme in _SCHEMES and bool(url.hostname) and url.port != 0
    except ValueError:
        is_known = False
    if not is_known:
        raise UsageError(f"--values {text}: it is {_FORMS}")
    if url.password is not None or _SECRETS & parse_qs(url.query).keys():
        raise UsageError(f"--values: other users can read a password in a command: put it into the variable {SECRET}")
    return _SCHEMES[url.scheme](url, environment.get(SECRET, ""))


def line(value: Value) -> str:
    """Return a line of InfluxDB's line protocol."""
    plain = value.plain
    fields = {"text": plain} if isinstance(plain, str) else {}
    fields |= {"name": value.access.name, "unit": value.access.unit}
    said = [f'{name}="{visible(text).translate(_TEXT)}"' for name, text in fields.items() if text]
    if not isinstance(plain, str):
        said.insert(0, f"value={plain!r}")
    told = [f"{name}={visible(text).translate(_TAG)}" for name, text in _tags(value).items() if text]
    return f"{','.join(['sis', *told])} {','.join(said)} {value.time_ns}"


def _tags(value: Value) -> dict[str, str]:
    """Return what says which parameter it is, in order."""
    port, station, device, ident = value.access.parameter
    return {"device": str(device), "host": _HOST, "parameter": ident, "port": port, "station": station}


def message(value: Value) -> str:
    """Return JSON for subscribers; what is not known is left out."""
    access = value.access
    said: dict[str, Any] = {"time": utc(value.time_ns / 1e9), "value": value.plain, "unit": access.unit}
    said |= {"name": access.name, **_tags(value)}
    return json.dumps({name: one for name, one in said.items() if one not in ("", None)})


def topic(value: Value) -> str:
    """Return the levels below the topic of the user."""
    _, *levels = value.access.parameter
    return "/".join(_NO_LEVEL.sub("-", visible(str(level))) for level in levels)


def _lines(values: Sequence[Value]) -> bytes:
    return "".join(f"{line(value)}\n" for value in values).encode()


class _StandardOutput:
    name = "standard output"

    def deliver(self, values: Sequence[Value]) -> None:
        data = _lines(values)
        try:
            while data:
                data = data[os.write(1, data) :]
        except OSError as error:
            raise Undelivered(error.strerror) from None

    def close(self) -> None:
        pass


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Python would send the secret to the other address, but not the values."""

    def redirect_request(self, *_: object) -> None:
        """Make an error of it."""


class _Http:
    def __init__(self, url: SplitResult, secret: str) -> None:
        self.name = f"{url.scheme}://{url.netloc.rpartition('@')[2]}{url.path}"
        self._address = url._replace(netloc=url.netloc.rpartition("@")[2], fragment="").geturl()
        self._opener = urllib.request.build_opener(_NoRedirect)
        self._head = {"Content-Type": "text/plain; charset=utf-8", "User-Agent": f"sistap/{sistap.__version__}"}
        if url.username is not None:
            user = f"{unquote(url.username)}:{secret}"
            self._head["Authorization"] = f"Basic {b64encode(user.encode()).decode()}"
        elif secret:
            self._head["Authorization"] = f"Token {secret}"

    def deliver(self, values: Sequence[Value]) -> None:
        request = urllib.request.Request(self._address, _lines(values), self._head)
        try:
            with self._opener.open(request, timeout=PATIENCE_S) as answer:
                answer.read(_SHOWN)
        except urllib.error.HTTPError as error:
            said = f"{error.code} {error.reason} {_body(error)}".strip()
            raise (Refused if error.code in _REFUSED else Undelivered)(said) from None
        except urllib.error.URLError as error:
            raise Undelivered(str(getattr(error.reason, "strerror", None) or error.reason)) from None
        except (OSError, http.client.HTTPException) as error:
            raise Undelivered(str(error) or repr(error)) from None

    def close(self) -> None:
        pass


def _body(error: urllib.error.HTTPError) -> str:
    try:
        return error.read(_SHOWN).decode(errors="replace")
    except (OSError, http.client.HTTPException):  # it hangs up, or takes its time
        return ""


class _Mqtt:
    def __init__(self, url: SplitResult, secret: str) -> None:
        self._mqtt = mqtt = needed("paho.mqtt.client", "paho-mqtt")
        self._topic = unquote(url.path).strip("/")
        if not self._topic or set("+#") & set(self._topic):
            raise UsageError("--values mqtt://HOST/TOPIC needs a topic, without + and #")
        is_safe = url.scheme == "mqtts"
        self._host, self._port = url.hostname, url.port or (8883 if is_safe else 1883)
        self.name = f"{url.scheme}://{self._host}:{self._port}/{self._topic}"
        versions = getattr(mqtt, "CallbackAPIVersion", None)  # new in paho-mqtt 2
        self._client = mqtt.Client(versions.VERSION2) if versions else mqtt.Client()
        self._client.reconnect_delay_set(1, 60)
        self._client.on_connect, self._client.on_publish = self._answered, self._acknowledge
        if url.username is not None or secret:
            self._client.username_pw_set(unquote(url.username or ""), secret or None)
        if is_safe:
            self._client.tls_set()
        self._is_started = False
        self._answer = _AWAY
        self._came = threading.Event()  # an answer of the broker
        self._sent: set[int] = set()  # the library keeps these, also while there is no connection
        self._acknowledged: set[int] = set()

    def deliver(self, values: Sequence[Value]) -> None:
        if not self._sent:
            self._connect()
            self._acknowledged.clear()
            self._sent = {
                self._client.publish(f"{self._topic}/{topic(value)}", message(value), qos=1).mid for value in values
            }
        if not self._wait(lambda: self._sent <= self._acknowledged):
            raise Undelivered("the broker does not acknowledge" if self._client.is_connected() else _AWAY)
        self._sent = set()

    def close(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()

    def _connect(self) -> None:
        if not self._is_started:
            try:
                self._client.connect(self._host, self._port)
            except (OSError, ValueError) as error:
                raise Undelivered(getattr(error, "strerror", None) or str(error)) from None
            self._client.loop_start()  # from now on it connects again by itself
            self._is_started = True
            self._wait(self._client.is_connected)
        if not self._client.is_connected():
            raise Undelivered(self._answer)

    def _wait(self, is_done: Callable[[], bool]) -> bool:
        end_s = time.monotonic() + PATIENCE_S
        while not is_done() and (left_s := end_s - time.monotonic()) > 0:
            self._came.wait(left_s)
            self._came.clear()
        return is_done()

    # -- In the thread of the library. Its versions pass more arguments, or fewer.

    def _answered(self, _client: object, _data: object, _flags: object, answer: object, *_: object) -> None:
        text = self._mqtt.connack_string(answer) if isinstance(answer, int) else answer
        self._answer = _AWAY if answer == 0 else f"the broker answers: {text}"
        self._came.set()

    def _acknowledge(self, _client: object, _data: object, number: int, *_: object) -> None:
        self._acknowledged.add(number)
        self._came.set()


_SCHEMES: Mapping[str, Callable[[SplitResult, str], Outlet]] = {
    "http": _Http,
    "https": _Http,
    "mqtt": _Mqtt,
    "mqtts": _Mqtt,
}
