# SPDX-License-Identifier: GPL-2.0-or-later
"""A pytest plugin for the tests of a mutant: stop at the first failure, print nothing, limit the resources."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest
from hypothesis import Phase, settings

import sistap

GIGABYTE = 1 << 30

# A mutant that never stops collecting must not exhaust the computer.
resource.setrlimit(resource.RLIMIT_AS, (2 * GIGABYTE, 2 * GIGABYTE))

# The same examples for every mutant, and no search for the smallest failing one.
settings.register_profile(
    "mutant", derandomize=True, database=None, deadline=None, phases=(Phase.explicit, Phase.generate)
)
settings.load_profile("mutant")


def pytest_configure(config: pytest.Config) -> None:
    """Refuse to test another copy of the package than the mutated one."""
    found = Path(sistap.__file__).parents[1]
    if found != config.rootpath:
        raise pytest.UsageError(f"sistap is imported from {found}, not from {config.rootpath}")
