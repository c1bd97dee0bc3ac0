# SPDX-License-Identifier: GPL-2.0-or-later
"""What somebody types on a fresh Debian, and what has to come of it. Runs as root in the Debian that `check` makes.

commands.py README.md: every command of that README is among these, in its order.
"""

from __future__ import annotations

import lzma
import re
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from screen import Screen

HOUSE, HOME, DESK = Path("/opt/sis"), Path("/home/me"), Path("/home/me/empty")
COURSE = "/usr/share/doc/sistap/course"
PORT = "/tmp/port"  # of a virtual bus; stands for /dev/ttyUSB0
USB = "usbmon-ftdi-19200.pcapng.xz"
TIMEOUT_S = 1500

# What stands for the words of the README: where this checkout is, a port, an end for what goes on forever, an answer.
TYPED = {
    "ADDRESS": "/srv/sis",
    "/dev/ttyUSB0": PORT,
    "-w day.pcapng": "-a duration:8 -w day.pcapng",
    "apt-get install": "apt-get install -y",
    "apt-get remove": "apt-get remove -y",
}


class Command(NamedTuple):
    """A command, the exit code it has to have, and words of its output."""

    line: str
    words: str = ""
    code: int = 0


AS_ROOT = [
    Command("git clone ADDRESS /opt/sis", "Cloning into '/opt/sis'"),
    Command("cd /opt/sis"),
    Command("./bootstrap demo", "Read parameter S-0-0036 (Velocity command value) = 1000.0000 rpm"),
    Command("apt-get install wireshark dpkg-dev file help2man"),
    Command("./bootstrap page", "Open build/sis.html in a browser"),
    Command("./bootstrap docs", "Open build/docs/index.html in a browser"),
    Command("(cd build/plugin && cpack -G DEB)", "_amd64.deb generated"),
    Command("apt-get install --reinstall ./build/plugin/sistap_*.deb"),
]

# Windows: a title, and arguments that end a live capture are not needed, as Wireshark is closed then.
WINDOWS = [
    Command("wireshark -C SIS", "The Wireshark Network Analyzer"),
    Command("sistap capture -i /dev/ttyUSB0 --baud auto -w - | wireshark -C SIS -k -i -", "Capturing from"),
    Command(f"wireshark -C SIS {COURSE}/01-first-conversation.pcapng", "01-first-conversation.pcapng"),
]

OF_README = [
    Command("sistap doctor", "good  plugin     sis.so"),
    Command("sistap capture -i /dev/ttyUSB0 --baud auto -w day.pcapng", "0 of them damaged"),
    Command("sistap doctor -i /dev/ttyUSB0", "good  opens"),
    Command("sistap annotate docklight.txt", "Read phase (SYNAX)"),
    Command("sistap report day.pcapng -o day.html"),
    Command("sistap import usb.pcapng -w imported.pcapng", "written to imported.pcapng"),
]

MORE = [
    Command("grep -c '<title>SIS</title>' /usr/share/doc/sistap/sis.html"),
    Command(f"cat {COURSE}/*.pcapng | wc -c"),
    Command("sistap --version", "sistap "),
    Command("sistap ports"),
    Command("sistap capture -i /dev/ttyUSB0 -c 9", "Reaction"),
    Command("sistap capture -i /dev/ttyUSB0 -w day.pcapng", "overwrite it with --force", 2),
    Command("sistap capture -i /dev/ttyUSB0 -a duration:6 -w ring.pcapng -b filesize:1 -b files:3"),
    Command("sistap capture -i /dev/ttyUSB0 -a duration:4 -w x.pcapng -f 'link[5] == 0x1f'"),
    Command("sistap record -i /dev/ttyUSB0 -a duration:3 --keep writes --before 1 --after 1 -w kept/"),
    Command("sistap report --format text day.pcapng", "TzA"),
    Command("sistap parameters day.pcapng", "S-0-0036"),
    Command("sistap parameters --csv day.pcapng -o parameters.csv"),
    Command("sistap compare day.pcapng imported.pcapng --format html -o changed.html"),
    Command("sistap tables day.pcapng -o tables", "`~/sistap-python/bin/pip install pyarrow`", 1),
    Command("sistap annotate --format html docklight.txt -o log.html"),
    Command("sistap annotate docklight.txt -w log.pcapng"),
    Command("sistap log day.pcapng -o day.txt"),
    Command("sistap import x.sr -w sr.pcapng", "1 telegrams, 0 of them damaged"),
    Command("sistap bus --list", "late-reaction"),
    Command("sistap bus late-reaction -w late.pcapng"),
    Command("sistap bus night -w night.pcapng"),
    Command("sistap report night.pcapng --format json -o night.json"),
    Command("sistap selftest", "p99.9"),
    Command("tshark -C SIS -r day.pcapng -c 3"),
    Command("tshark -q -r day.pcapng -z sis,tree", "By station"),
    Command("tshark -D", "SIS demo bus"),
    Command("tshark -i sistap-demo -a duration:4 -f 'link[5] == 0x1f'", "Write parameter"),
    Command("sistap install", "all users have it"),
    Command("sistap uninstall", "apt-get remove sistap"),
]

REMOVED = [Command("apt-get remove sistap"), Command("rm -r /opt/sis")]


class Failed(Exception):
    """Something is not as it has to be."""


def typed(line: str) -> str:
    """Return a line as it is typed here."""
    for word, here in TYPED.items():
        line = line.replace(word, here)
    return line


def of_readme(text: str) -> list[str]:
    """Return the commands of a README: the indented lines before "## Windows" that are no output."""
    lines = re.findall(r"^    (\S.*)$", text.partition("## Windows")[0], re.MULTILINE)
    return [line.partition("    #")[0].strip() for line in lines if not re.match(r"\d+ -> ", line)]


def run(line: str, *, user: str = "", folder: Path = HOUSE) -> tuple[int, str]:
    """Run a command in a shell; return its exit code and all of its output."""
    shell = ["su", user, "-s", "/bin/bash", "-c", f"cd {folder} && {line}"] if user else ["bash", "-c", line]
    done = subprocess.run(
        shell,
        cwd=folder if folder.exists() else "/",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        timeout=TIMEOUT_S,
        check=False,
    )
    return done.returncode, done.stdout


def check(command: Command, *, user: str = "", folder: Path = HOUSE) -> str:
    """Run a command; return its output. Raise Failed."""
    begun = time.monotonic()
    code, said = run(typed(command.line), user=user, folder=folder)
    if code != command.code or command.words not in said or "Traceback" in said:
        raise Failed(f"{command.line}: exit code {code}, without {command.words!r}:\n{said[-2000:]}")
    print(f"good  {time.monotonic() - begun:5.0f} s  {command.line}", flush=True)
    return said


def installed() -> None:
    """Follow the README as root."""
    for command in AS_ROOT:
        check(command)
    print(run("dpkg-query -W sistap wireshark")[1], end="", flush=True)


@contextmanager
def desk() -> Iterator[None]:
    """Make a user with an empty folder, with the files of others that the README names, and a bus behind the port."""
    run("apt-get install -y xvfb xdotool imagemagick openbox xdg-utils")  # for this trial alone
    for user in ("me", "neat"):
        run(f"useradd -m -s /bin/bash {user}", folder=Path("/"))
    captures = HOUSE / "capture/tests/real-captures"
    DESK.mkdir()
    (DESK / "usb.pcapng").write_bytes(lzma.decompress((captures / USB).read_bytes()))
    (DESK / "docklight.txt").write_text("14.03.2013 08:21:14.641 [TX] - 02 6C 00 00 00 92 00 00\n")
    session(DESK / "x.sr")
    run(f"chown -R me:me {DESK}", folder=Path("/"))
    bus = subprocess.Popen(["sistap", "bus"], stdout=subprocess.PIPE, text=True)
    try:
        assert bus.stdout
        Path(PORT).symlink_to(name := bus.stdout.readline().strip())
        Path(name).chmod(0o666)
        yield
    finally:
        bus.kill()


def session(file: Path) -> None:
    """Write what PulseView would have saved of one telegram: a byte for each sample of 1 us, channel D0 at bit 0."""
    rate, baud, samples = 1_000_000, 9600, bytearray(b"\1" * 5000)
    for value in bytes.fromhex("02e30202000010030301"):
        bits = [0, *(value >> place & 1 for place in range(8)), value.bit_count() % 2, 1]
        begin = len(samples)
        for place, bit in enumerate(bits, 1):
            samples += bytes([bit]) * (begin + place * rate // baud - len(samples))
    metadata = "[device 1]\ncapturefile=logic-1\ntotal probes=1\nsamplerate=1 MHz\nprobe1=D0\nunitsize=1\n"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("version", "2")
        archive.writestr("metadata", metadata)
        archive.writestr("logic-1-1", bytes(samples + b"\1" * 5000))


def profile(user: str) -> Path:
    """Return the folder of a user's copy of the profile."""
    return Path("/home", user, ".config/wireshark/profiles/SIS")


def updated(screen: Screen) -> None:
    """Update to a later version, after one user has changed the profile and another has not. Raise Failed."""
    for user in ("me", "neat"):
        screen.show(user, "wireshark -C SIS", "The Wireshark Network Analyzer")
    mine = profile("me") / "dfilter_buttons"
    mine.write_text(changed := mine.read_text() + '"TRUE","Mine","sis.station == 3",""\n')
    said = check(Command(f"apt-get install -y {later()}", f"kept     {mine}"))
    if f"renewed  {profile('neat')}/colorfilters" not in said or mine.read_text() != changed:
        raise Failed(f"the profiles do not follow the package:\n{said}")
    for user in ("me", "neat"):
        if "# of a later version" not in (profile(user) / "colorfilters").read_text():
            raise Failed(f"{user} has an old profile")
    check(Command("sistap doctor", "changed by you, so an update leaves them: dfilter_buttons"), user="me", folder=DESK)
    screen.show("me", "wireshark -C SIS", "The Wireshark Network Analyzer")


def later() -> Path:
    """Make a package of a later version, whose profile has one more line."""
    folder, made = Path("/tmp/later"), Path("/tmp/later.deb")
    (package,) = HOUSE.glob("build/plugin/sistap_*.deb")
    check(Command(f"dpkg-deb -R {package} {folder}"))
    control = folder / "DEBIAN/control"
    control.write_text(re.sub(r"^(Version: .*)$", r"\1.1", control.read_text(), flags=re.MULTILINE))
    own = folder / "usr/share/sistap/sistap/profile"
    for file in (own / "SIS/colorfilters", folder / "usr/share/wireshark/profiles/SIS/colorfilters"):
        file.write_text("# of a later version\n" + file.read_text())
    with (own / "installed").open("a") as known:
        known.write(run(f"sha256sum {own}/SIS/colorfilters")[1])
    check(Command(f"dpkg-deb -b {folder} {made}"))
    return made


def removed(screen: Screen) -> None:
    """Remove the package: nothing is left but what a user has made, and Wireshark does not complain. Raise Failed."""
    for command in REMOVED:
        check(command)
    left = run("find / -xdev -iname '*sistap*' -not -path '/srv/*' -not -path '/tmp/*' "
               "-not -path '/proc/*' -not -path '/var/lib/dpkg/*'")[1].split()  # fmt: skip
    left += [str(file) for file in profile("neat").glob("*")]
    mine = sorted(file.name for file in profile("me").glob("*"))
    if left or mine != ["dfilter_buttons", "recent"]:
        raise Failed(f"left: {left} {mine}")
    print("good           nothing is left", flush=True)
    for user in ("me", "neat"):
        screen.show(user, "wireshark", "The Wireshark Network Analyzer")


def main(readme: str) -> int:
    """Try everything; return the exit code."""
    known = [command.line for command in (*AS_ROOT, *WINDOWS, *OF_README, *MORE, *REMOVED)]
    try:
        if missing := set(of_readme(Path(readme).read_text())) - set(known):
            raise Failed(f"commands of the README that nobody tries here: {missing}")
        installed()
        with desk(), Screen(Path("/srv/pictures")) as screen:
            for command in WINDOWS:
                screen.show("me", typed(command.line), command.words)
            for command in (*OF_README, *MORE):
                check(command, user="me", folder=DESK)
            updated(screen)
            removed(screen)
    except (Failed, RuntimeError, OSError, subprocess.TimeoutExpired) as error:
        print(f"FAILED {error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
