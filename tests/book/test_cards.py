"""Flash cards say what the pages' tables say, each row once, in TeX that Anki draws."""

import re
import sqlite3
import zipfile

import pytest

from tools import cards


def test_each_row_of_the_tables_is_a_card():
    found = cards.cards()
    rows = [
        line
        for path in cards.PAGES.values()
        for line in (cards.ROOT / path).read_text(encoding="utf-8").splitlines()
        if line.startswith("| ") and not line.startswith(("| Word |", "| Symbol |", "| Kernel |"))
        and cards.IDEA not in line
    ]  # fmt: skip
    again = {"Cauchy", "Geman–McClure", "Welsch", "TLS"}  # the cheat sheet's table of kernels
    assert len(found) == len(rows) - len(again) > 90
    fronts = [card.front for card in found]
    assert again < set(fronts) and len(set(fronts)) == len(fronts)


def test_sides_have_words_and_formulas_and_nothing_of_markdown():
    by_front = {card.front: card for card in cards.cards()}
    weight = by_front["IRLS weight"]
    assert (weight.back, weight.heading) == (r"\(w(u) = \psi(u)/u\)", "Robust SLAM: L14")
    assert by_front[r"\(\Phi(w)\)"].back.startswith("penalty on small weights: ")
    for card in by_front.values():
        assert card.front and card.back
        for side in (card.front, card.back):
            words = re.sub(r"\\\(.*?\\\)", "", side)
            assert not re.search(r"[$`*{}\\|]|\]\(", words), side
            assert side.count(r"\(") == side.count(r"\)")


def test_the_deck_holds_them_and_knows_a_card_again(tmp_path, monkeypatch):
    ids = []
    monkeypatch.setattr(cards, "ROOT", tmp_path)
    monkeypatch.setattr(cards, "TARGET", tmp_path / "deck.apkg")
    found = [cards.Card("a", "1", "Symbols", "Words"), cards.Card("b", "2", "Symbols", "Words")]
    for back in ("1", "changed"):
        found[0] = cards.Card("a", back, "Symbols", "Words")
        monkeypatch.setattr(cards, "cards", lambda: found)
        assert cards.main() == 0
        with zipfile.ZipFile(tmp_path / "deck.apkg") as archive:
            archive.extract("collection.anki2", tmp_path)
        with sqlite3.connect(tmp_path / "collection.anki2") as notes:
            ids.append(notes.execute("select guid from notes order by flds").fetchall())
    assert len(ids[0]) == 2 and ids[0] == ids[1]


def test_a_page_without_tables_is_named(tmp_path):
    for path in cards.PAGES.values():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text("# Nothing", encoding="utf-8")
    with pytest.raises(ValueError, match=r"symbols\.md: no table"):
        cards.cards(tmp_path)
