# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall` as root, into the real folders of this system.

Each test has a throw-away root: this system under a layer in memory that takes all writes. So the layer also lists
everything that was changed. It disappears with its mount namespace.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest
from portable import unpackaged
from test_hostile_text import ODD, odd_ones

pytestmark = [
    pytest.mark.thorough,
    unpackaged,
    pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="needs root on Linux"),
]

CAPTURE = Path(__file__).parents[1]
SCRIPT = CAPTURE.parent / "lua-fallback/sis.lua"
LEDGER = "/var/lib/sistap/installed-for-all.json"

# Three folders: one for it, that of the packages, sis.lua. No /dev of this machine is in it: one null device is made.
MAKE_ROOT = """\
set -eu
mount -t tmpfs -o mode=755 none "$1"
layer=$1/layer root=$1/root
mkdir "$layer" "$1/work" "$root"
mount -t overlay overlay -o "lowerdir=/,upperdir=$layer,workdir=$1/work" "$root" || exit 77
[ -c "$root/dev/null" ] || mknod -m 666 "$root/dev/null" c 1 3
mkdir -p "$root/opt/sistap/tree/capture" "$root/opt/sistap/tree/lua-fallback"
cp -r "$2/sistap" "$2/sisbus" "$root/opt/sistap/tree/capture/"
cp "$3" "$root/opt/sistap/tree/lua-fallback/"
chown -R root:root "$root/opt/sistap"
chmod -R go-w "$root/opt/sistap"

as_root() {
    chroot "$root" env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \\
        PYTHONPATH=/opt/sistap/tree/capture PYTHONDONTWRITEBYTECODE=1 "$@"
}
sistap() {
    echo "-- $1"
    as_root /usr/bin/python3 -P -m sistap "$@" 2>&1 && echo "-- exit 0" || echo "-- exit $?"
}
# What was written, removed (a device there) or made a link, but for what this script has done.
changed() {
    echo "-- changed"
    (cd "$layer" && find . ! -type d ! -path './opt/*' ! -path './dev/*' ! -path './tmp/*' -printf '/%P %y %m %U\\n')
}
"""


class Root:
    """The throw-away root; a shell script runs in it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def run(self, script: str) -> dict[str, list[str]]:
        """Return the lines after each heading (`-- install`), in the order in which they came."""
        folder = [str(path) for path in (self._folder, CAPTURE, SCRIPT)]
        done = subprocess.run(
            ["unshare", "--mount", "sh", "-c", MAKE_ROOT + script, "sh", *folder],
            capture_output=True,
            check=False,
            timeout=120,
        )
        if done.returncode == 77:
            pytest.skip("no overlay file system here")
        text = done.stdout.decode()
        assert done.returncode == 0, text + done.stderr.decode()
        assert "Traceback" not in text
        assert not odd_ones(text)
        parts: dict[str, list[str]] = {}
        for line in text.splitlines():
            if line.startswith("-- "):
                heading = f"{line.removeprefix('-- ')}{' again' if line.removeprefix('-- ') in parts else ''}"
                parts[heading] = []
            else:
                parts[heading].append(line)
        return parts


@pytest.fixture
def root(tmp_path: Path) -> Root:
    if not shutil.which("unshare"):
        pytest.skip("needs unshare")
    return Root(tmp_path)


def put(lines: list[str]) -> set[str]:
    return {line.removeprefix("put").strip() for line in lines if line.startswith("put ")}


def test_what_is_put_is_taken_away_and_nothing_else_is_touched(root: Root) -> None:
    found = root.run("sistap install; changed; sistap uninstall; changed")
    there = [line.rsplit(" ", 3) for line in found["changed"]]
    assert put(found["install"]) | {LEDGER} == {name for name, *_ in there}
    assert len(put(found["install"])) > 3
    for name, kind, mode, owner in there:
        assert (kind, owner) == ("f", "0"), name
        assert mode in ("644", "755"), name
    assert found["changed again"] == []


@pytest.mark.attack("as root: the list of installed files names foreign files", "none is touched; a message names each")
def test_a_list_that_names_what_is_not_ours(root: Root) -> None:
    """With the right sums, links and dots on the way, folders of the system, and names that control a terminal."""
    names = [
        "/etc/passwd",
        "/etc/../etc/shadow",
        "/usr/lib/x86_64-linux-gnu/wireshark/plugins/../../../../../etc/group",
        "/usr/local/bin/../../../etc/hostname",
        "/opt/link/passwd",
        "etc/passwd",
        f"/usr/local/bin/{ODD}",
        "/usr/local/bin",
    ]
    files = {name: sha256(Path(name).read_bytes()).hexdigest() if Path(name).is_file() else "" for name in names}
    files["/opt/link/passwd"] = files["etc/passwd"] = files["/etc/passwd"]
    ledger = json.dumps({"files": files, "folders": ["/", "/etc", "/usr", "/usr/local/bin", f"/etc/{ODD}", ""]})
    make = f"""
mkdir -p "$layer/var/lib/sistap"
ln -s /etc "$root/opt/link"
cat > "$root{LEDGER}" <<'LIST'
{ledger}
LIST
"""
    found = root.run(make + "sistap uninstall; changed; sistap install; sistap uninstall; changed")
    assert "exit 1" in found
    kept = "\n".join(found["uninstall"])
    for name in names[:6]:
        assert f"kept {name}: {LEDGER} names it, but it is in none of the folders of `sistap install`" in kept
    assert [line.split()[0] for line in found["changed"]] == [LEDGER]
    assert [line.split()[0] for line in found["changed again"]] == [LEDGER]


@pytest.mark.attack("as root: links in the folders of install", "not followed")
def test_links_in_the_way(root: Root) -> None:
    """Root writes nothing through links, and installs everything else."""
    make = """
link() { mkdir -p "$root$(dirname "$2")"; ln -s "$1" "$root$2"; }
link /etc/shadow /usr/local/bin/sistap
link /etc/cron.d/nothing /usr/local/share/zsh/site-functions/_sistap
"""
    found = root.run(make + "sistap install; changed; sistap uninstall; changed")
    names = {line.split()[0] for line in found["changed"]}
    assert not {name for name in names if name.startswith("/etc/")}
    assert "/usr/local/bin/sistap l 777 0" in found["changed"]
    assert any(line.startswith("kept     /usr/local/bin/sistap") for line in found["install"])
    assert [line.split()[0] for line in found["changed again"]] == ["/usr/local/bin/sistap"]


def test_a_file_where_a_folder_is_to_be(root: Root) -> None:
    """Everything installed before that is on the list, so that it can be removed."""
    make = 'rm -rf "$root/usr/local/share/zsh"; touch "$root/usr/local/share/zsh"\n'
    found = root.run(make + "sistap install; changed; sistap uninstall; changed")
    assert list(found)[1] == "exit 1"
    assert found["install"][-1].startswith("sistap: ") and "/usr/local/share/zsh" in found["install"][-1]
    assert put(found["install"]) | {LEDGER} == {line.split()[0] for line in found["changed"]} - {"/usr/local/share/zsh"}
    assert [line.split()[0] for line in found["changed again"]] == ["/usr/local/share/zsh"]


@pytest.mark.attack("as root: `sudo -E` with folders of another user", "ignored, and nothing written there")
def test_an_environment_of_somebody_else(root: Root) -> None:
    """`sudo -E` brings the folders of its caller: root neither trusts a list in them nor writes there."""
    make = """
mkdir -p "$root/home/evil/.local/state/sistap" "$root/home/evil/tmp"
chmod -R 777 "$root/home/evil"
sum=$(sha256sum < /etc/passwd | cut -d ' ' -f 1)
echo "{\\"files\\": {\\"/etc/passwd\\": \\"$sum\\"}, \\"folders\\": []}" \\
    > "$root/home/evil/.local/state/sistap/installed-for-all.json"
as_other() {
    echo "-- $1"
    evil=/home/evil
    as_root HOME=$evil XDG_STATE_HOME=$evil/.local/state XDG_DATA_HOME=$evil XDG_CONFIG_HOME=$evil TMPDIR=$evil/tmp \\
        /usr/bin/python3 -P -m sistap "$@" 2>&1 && echo "-- exit 0" || echo "-- exit $?"
}
"""
    found = root.run(make + "as_other install; changed; as_other uninstall; changed")
    theirs = "/home/evil/.local/state/sistap/installed-for-all.json"
    home = [line.split()[0] for line in found["changed"] if line.startswith("/home/")]
    assert home == [theirs]
    assert [line.split()[0] for line in found["changed again"]] == [theirs]
