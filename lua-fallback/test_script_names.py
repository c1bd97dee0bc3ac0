# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua has the codes and texts of plugin/sis/names.c."""

from __future__ import annotations

import pytest

import names


def test_script_is_current() -> None:
    assert names.current() in names.SCRIPT.read_text(), "run lua-fallback/names.py"


def test_entry_that_cannot_be_read() -> None:
    with pytest.raises(ValueError, match="sis_errors_list"):
        names.section(
            "/* Errors. */\nconst value_string sis_errors_list[] = {\n"
            '    {0x01, "one"},\n    {TWO "two"},\n    {0, NULL},\n};\n',
            "typedef enum { SIS_STATION } sis_address_kind_t;",
        )


def test_ranges_values_and_kinds() -> None:
    made = names.section(
        "/* Said\n * before. */\n"
        'const range_string sis_a[] = {\n    {0x00, 0x0F, "x, {y}"},\n    {0, 0, NULL},\n};\n'
        '/* Kinds. */\nconst value_string sis_b[] = {{SIS_STATION, "s"}, {0, NULL}};\n',
        "typedef enum { SIS_STATION, SIS_GROUP } sis_address_kind_t;",
    )
    assert 'N.a = {\n  {0x00, 0x0F, "x, {y}"},\n}' in made
    assert '-- Kinds.\nN.b = {\n  [K.STATION] = "s",\n}' in made
    assert "K.STATION = 0\nK.GROUP = 1\n" in made
