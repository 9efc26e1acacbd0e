"""Cards by their layouts: fields by name, defaults, and what no reader has asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.errors import FileError, MeshError
from contiga.io.mesh.lsdyna_cards import (
    Block,
    Row,
    layout,
    read_blocks,
    row_of,
    rows_of,
    unread_fields,
)

CARD = layout("~EID:8 NID:8 MASS:16 SF=1 DIR=X")


def block_of(folder: Path, *cards: str, keyword: str = "*CARD") -> Block:
    (folder / "a.k").write_text("\n".join(["*KEYWORD", keyword, *cards, "*END", ""]), "utf-8")
    (block,) = read_blocks(folder / "a.k")
    return block


def cut(folder: Path, *cards: str, keyword: str = "*CARD") -> tuple[Row, Block]:
    block = block_of(folder, *cards, keyword=keyword)
    return row_of(block.cards[0], block, CARD), block


FIXED = f"{7:8d}{12:8d}{2.5:16}{3.0:10}{'Y':>10}"
LONG = f"{7:20d}{12:20d}{2.5:20}{3.0:20}{'Y':>20}"


@pytest.mark.parametrize(
    ("text", "keyword"), [(FIXED, "*CARD"), ("7,12,2.5,3.0,Y", "*CARD"), (LONG, "*CARD+")]
)
def test_fields_are_found_by_name_in_every_format(tmp_path: Path, text: str, keyword: str) -> None:
    row, block = cut(tmp_path, text, keyword=keyword)
    assert (row.whole("NID"), row.reals("MASS SF"), row.text("DIR")) == (12, (2.5, 3.0), "Y")
    assert list(unread_fields(block)) == []


@pytest.mark.parametrize("scale", ["", "0", "0.0", "1", "1.0", "1.0E+00"])
@pytest.mark.parametrize("direction", ["", "X", "x"])
def test_blank_and_zero_are_the_default_and_not_listed(
    tmp_path: Path, scale: str, direction: str
) -> None:
    row, block = cut(tmp_path, f"7,,,{scale},{direction}")
    assert list(unread_fields(block)) == []
    assert (row.real("SF"), row.real("MASS"), row.whole("NID")) == (1.0, 0.0, 0)


def test_what_is_not_asked_for_is_left_with_its_name(tmp_path: Path) -> None:
    row, block = cut(tmp_path, FIXED, "", f"{1:8d}", "0 0", " 1 2", keyword="*CARD")
    assert row.real("MASS") == 2.5
    expected = [("NID", "12"), ("SF", "3.0"), ("DIR", "Y"), ("card 3:", "1"), ("card 5:", "1 2")]
    assert list(unread_fields(block)) == expected
    block.mark_read(block.cards[2])
    assert ("card 3:", "1") not in list(unread_fields(block))


@pytest.mark.parametrize(
    ("text", "left"),
    [
        (f"{FIXED}{0:10}{1:10}", [("field 7", "1")]),
        (f"{FIXED:80} a remark", []),
        ("7,12,2.5,3.0,Y,0,1", [("field 7", "1")]),
        (f"{FIXED}      word", [("field 6", "word")]),
    ],
)
def test_fields_that_no_layout_has_are_left_by_their_place(
    tmp_path: Path, text: str, left: list[tuple[str, str]]
) -> None:
    row, block = cut(tmp_path, text)
    row.text("DIR"), row.reals("NID MASS SF")
    assert list(unread_fields(block)) == left


def test_a_field_that_is_only_looked_at_is_left(tmp_path: Path) -> None:
    row, block = cut(tmp_path, "7,12")
    assert row.peek("NID") == 12
    assert list(unread_fields(block)) == [("NID", "12")]


def test_cards_that_are_not_there_are_blank(tmp_path: Path) -> None:
    block = block_of(tmp_path, FIXED)
    first, second = rows_of(block, block.cards, CARD, layout("T1=2 T2"))
    assert first.whole("NID") == 12
    assert second.reals("T1 T2") == (2.0, 0.0)


def test_a_field_that_is_no_number_names_its_line(tmp_path: Path) -> None:
    row, _ = cut(tmp_path, "7,x,&m")
    with pytest.raises(MeshError, match=r"line 3: \*CARD: .*found 'x'; allowed: a whole number"):
        row.whole("NID")
    with pytest.raises(MeshError, match=r"found '&m'.*write the deck out flat"):
        row.real("MASS")


def test_a_deck_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    (tmp_path / "deck.k").mkdir()
    with pytest.raises(FileError, match=r"deck\.k: cannot be read"):
        list(read_blocks(tmp_path / "deck.k"))
