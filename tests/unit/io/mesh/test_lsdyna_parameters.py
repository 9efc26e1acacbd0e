"""Parameters of keyword decks: what stands for &name, and what is not understood."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from contiga.io.mesh.lsdyna_cards import Block, layout, read_blocks, row_of

EIGHT = layout("A B C D E F G H")


def values(folder: Path, text: str, *names: str) -> list[str]:
    """What stands for names in a card at the end of a deck."""
    (folder / "a.k").write_text(f"*KEYWORD\n{text}\n*LAST\n{','.join(names)}\n*END\n", "utf-8")
    last = at_end(folder)
    return row_of(last.cards[0], last, EIGHT).texts[: len(names)]


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2.0*(a+b)", 2.0 * 5.5), ("-&b**2", -16.0), ("sqrt(&b)", 2.0), ("7/2.", 3.5), ("8/4", 2.0),
        ("1.5d1+b", 19.0), ("max(a,b,nint(7.5))", 8.0), ("cos(60.0*acos(-1.0)/180.0)", 0.5),
        ("mod(7,b)", 3.0), ("c", 1.5e-3),
    ],
)  # fmt: skip
def test_expressions_are_worked_out(tmp_path: Path, expression: str, value: float) -> None:
    given = "*PARAMETER\nR a,1.5,I b,4,R c,1.5-3\n*PARAMETER_EXPRESSION\n"
    for line in (f"R x       {expression}", f"R x, {expression}"):
        values(tmp_path, given + line, "&x")
        last = at_end(tmp_path)
        assert math.isclose(row_of(last.cards[0], last, EIGHT).real("A"), value, rel_tol=1e-15)


def at_end(folder: Path) -> Block:
    return list(read_blocks(folder / "a.k"))[-1]


@pytest.mark.parametrize(
    "expression",
    ["3/2", "nothing", "1/0.0", "9**9**9**9", "open('a')", "a if a else a", "((", "1e"],
)
def test_what_is_no_number_is_left(tmp_path: Path, expression: str) -> None:
    text = f"*PARAMETER\nR a,1.5\n*PARAMETER_EXPRESSION\nR x, {expression}"
    assert values(tmp_path, text, "&x") == ["&x"]
    (left,) = at_end(tmp_path).parameters.unresolved
    assert (left.block.line, left.line, left.reason) == (4, 5, f"&x = {expression}")


@pytest.mark.parametrize("letter", ["R", "I"])
def test_an_infinite_value_is_left(tmp_path: Path, letter: str) -> None:
    text = f"*PARAMETER_EXPRESSION\n{letter} x, 1e308*10.0"
    assert values(tmp_path, text, "&x") == ["&x"]
    assert len(at_end(tmp_path).parameters.unresolved) == 1


def test_an_expression_goes_on_under_an_empty_name(tmp_path: Path) -> None:
    text = "*PARAMETER_EXPRESSION\nR x       1.0 +\n          2.0\nI n       2*3"
    assert values(tmp_path, text, "&x", "&n", "-&n") == ["3.0", "6", "-6"]


def test_the_long_format_has_wide_fields(tmp_path: Path) -> None:
    text = f"*PARAMETER+\n{'R x':20}{'1.0':20}{'R y':20}{'-2.0':20}"
    assert values(tmp_path, text, "&x", "-&y", "& y") == ["1.0", "2.0", "-2.0"]


def test_the_first_definition_stands_and_local_ones_stay_in_their_file(tmp_path: Path) -> None:
    (tmp_path / "in.k").write_text(
        "*PARAMETER_LOCAL\nR a,5.0,R b,6.0\n*PARAMETER\nR c,7.0\n*INSIDE\n&a,&b\n", "utf-8"
    )
    text = "*PARAMETER\nR a,1.0\n*INCLUDE\nin.k\n*PARAMETER\nR a,2.0"
    assert values(tmp_path, text, "&a", "&b", "&c") == ["1.0", "&b", "7.0"]
    blocks = list(read_blocks(tmp_path / "a.k"))
    inside = next(block for block in blocks if block.keyword == "INSIDE")
    assert row_of(inside.cards[0], inside, EIGHT).texts[:2] == ["5.0", "6.0"]
    assert [each.reason for each in inside.parameters.unresolved] == [
        "&a again, the first one stands"
    ]
