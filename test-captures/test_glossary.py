# SPDX-License-Identifier: GPL-2.0-or-later
"""The glossary explains each word once, in order, and other languages have words for those of the protocol."""

from __future__ import annotations

from pathlib import Path

import pytest

from pages import glossary, markdown

# The words of chapters 2 to 10 of the SIS definition that a reader of a German manual looks up.
PROTOCOL = (
    *(
        "Baud rate",
        "Channel",
        "Checksum",
        "Command",
        "Contents",
        "Data status",
        "Element",
        "Header",
        "Interval",
        "Level",
    ),
    *("Master", "Operating data", "Parameter", "Parameter control", "Parity", "Phase", "Point to point"),
    *("Procedure command", "Reaction", "Sequential telegrams", "Service", "Slave", "Start character", "Station"),
    *("Status", "Subaddress", "Subservice", "Telegram", "Telegram control", "Telegram number", "Tmas", "Token", "TrS"),
    *("TwM", "TzA", "Useful data", "Useful data header"),
)


def test_words_stand_in_order_and_once() -> None:
    found = glossary.words()
    assert len(set(found)) == len(found) > 80
    assert found == sorted(found, key=str.lower)


@pytest.mark.parametrize("language", glossary.languages())
def test_another_language_has_words_of_the_glossary(language: str) -> None:
    assert set(glossary.languages()[language]) <= set(glossary.words())


def test_german_has_the_words_of_the_protocol() -> None:
    assert set(PROTOCOL) <= set(glossary.languages()["German"])


def test_words_stand_behind_the_english_one() -> None:
    assert "- **Checksum** (German: Checksumme, Prüfsumme, CS): the second byte" in glossary.text()
    assert "<strong>Useful data header</strong> (German: Nutzdatenkopf):" in markdown.html(glossary.text())


def test_a_language_is_added_with_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "glossary.fr.txt").write_text("# French\nChecksum = somme de contrôle\n")
    (tmp_path / "glossary.de.txt").write_text("# German\nChecksum = Prüfsumme (CS)\n")
    monkeypatch.setattr(glossary, "HERE", tmp_path)
    assert "- **Checksum** (German: Prüfsumme, CS; French: somme de contrôle): the" in glossary.text()
    (tmp_path / "glossary.fr.txt").write_text("# French\nChecksum: somme\n")
    with pytest.raises(ValueError, match=r"glossary\.fr\.txt begins with"):
        glossary.text()
