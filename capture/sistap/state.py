# SPDX-License-Identifier: GPL-2.0-or-later
"""Where sistap keeps what it has to remember from one run to the next."""

from __future__ import annotations

import os
from pathlib import Path


def folder() -> Path:
    """Say which folder (XDG base directories); it may not exist. RuntimeError if this user has no home."""
    state = os.environ.get("XDG_STATE_HOME", "")
    return (Path(state) if Path(state).is_absolute() else Path.home() / ".local/state") / "sistap"
