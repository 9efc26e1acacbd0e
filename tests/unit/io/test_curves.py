"""Curves of CSV files and keyword decks, converted to the units of a case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import FileError, InputError, MeshError, UnitError
from contiga.io.curves import read_curve
from contiga.io.mesh.lsdyna_cards import read_blocks
from contiga.io.mesh.lsdyna_curves import read_curves
from contiga.io.units import quantity_factor

CASE = ("mm", "kg", "ms")  # stresses in GPa, forces in kN
STRESS = ("ratio", "stress")

DECK = """*KEYWORD
*DEFINE_CURVE_TITLE
foam, static
$     lcid      sidr       sfa       sfo      offa      offo    dattyp
        12         0      0.01       2.0      10.0       0.5         0
$                 a1                  o1
                 0.0                 0.0
                50.0                 1.5
*DEFINE_CURVE
7
0.0, 0.0
1.0, 3.0
*DEFINE_CURVE+
8
                 0.0                 1.0
                 2.0               1.5-3
*END
"""


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_curves_of_a_deck_are_scaled_and_shifted(tmp_path: Path) -> None:
    curves = read_curves(read_blocks(write(tmp_path, "deck.k", DECK)))
    assert [(c.number, c.title) for c in curves.values()] == [
        (12, "foam, static"),
        (7, ""),
        (8, ""),
    ]
    np.testing.assert_allclose(curves[12].table, [[0.1, 1.0], [0.6, 4.0]], rtol=1e-15)
    assert curves[7].table.tolist() == [[0.0, 0.0], [1.0, 3.0]]
    assert curves[8].table.tolist() == [[0.0, 1.0], [2.0, 0.0015]]


def test_a_curve_of_a_deck_is_converted(tmp_path: Path) -> None:
    deck = write(tmp_path, "deck.k", DECK)
    actual = read_curve(deck, STRESS, CASE, curve=12, units=["1", "MPa"])
    np.testing.assert_allclose(actual, [[0.1, 1e-3], [0.6, 4e-3]], rtol=1e-15)
    assert read_curve(deck, STRESS, CASE, curve=7).tolist() == [[0.0, 0.0], [1.0, 3.0]]


def test_a_blank_title_is_a_card(tmp_path: Path) -> None:
    text = "*DEFINE_CURVE_TITLE\n\n5\n0.0, 0.0\n0.25, 1.0\n0.5, 2.0\n*END\n"
    actual = read_curve(write(tmp_path, "deck.k", text), STRESS, CASE)
    assert actual.tolist() == [[0.0, 0.0], [0.25, 1.0], [0.5, 2.0]]


def test_a_negative_scale_turns_the_points_round(tmp_path: Path) -> None:
    text = "*DEFINE_CURVE\n5, 0, -1.0\n0.0, 3.0\n1.0, 2.0\n1.0, 1.0\n4.0, 0.0\n*END\n"
    actual = read_curve(write(tmp_path, "deck.k", text), STRESS, CASE)
    assert actual.tolist() == [[-4.0, 0.0], [-1.0, 1.0], [-1.0, 2.0], [0.0, 3.0]]


def test_parameters_matter_in_the_curve_that_is_asked_for(tmp_path: Path) -> None:
    text = DECK.replace("*END", "*DEFINE_CURVE\n20, 0, &scale\n0.0, 0.0\n1.0, &top\n*END")
    deck = write(tmp_path, "deck.k", text)
    assert read_curve(deck, STRESS, CASE, curve=7).tolist() == [[0.0, 0.0], [1.0, 3.0]]
    with pytest.raises(MeshError, match=r"\*DEFINE_CURVE: .*found '&scale'"):
        read_curve(deck, STRESS, CASE, curve=20)
    with pytest.raises(FileError, match=r"no \*DEFINE_CURVE 9"):
        read_curve(deck, STRESS, CASE, curve=9)
    alone = write(tmp_path, "alone.k", text[text.index("*DEFINE_CURVE\n20") :])
    with pytest.raises(MeshError, match="&scale"):
        read_curve(alone, STRESS, CASE)


def test_columns_say_their_units_or_are_given_them(tmp_path: Path) -> None:
    text = "strain [%]; note; stress (MPa)\n0; 1; 0\n50; 1; 0.7\n"
    sheet = write(tmp_path, "foam.csv", text)
    actual = read_curve(sheet, STRESS, CASE, columns=["strain", "stress"])
    np.testing.assert_allclose(actual, [[0.0, 0.0], [0.5, 7e-4]], rtol=1e-15)
    plain = write(tmp_path, "spring.csv", "x,F\n0,0\n2,3\n")
    actual = read_curve(plain, ("length", "force"), CASE, units=["in", "N"])
    np.testing.assert_allclose(actual, [[0.0, 0.0], [50.8, 3e-3]], rtol=1e-15)
    assert read_curve(plain, ("length", "force"), CASE).tolist() == [[0.0, 0.0], [2.0, 3.0]]


@pytest.mark.parametrize(
    ("unit", "quantity", "factor"),
    [
        ("N/mm^2", "stress", 1e-3),
        ("psi", "stress", 6.894757293168361e-6),
        ("lbf", "force", 4.4482216152605e-3),
        ("1/s", "rate", 1e-3),
        ("%", "ratio", 0.01),
        ("m/s", "velocity", 1.0),
        ("cm", "length", 10.0),
    ],
)
def test_factors(unit: str, quantity: str, factor: float) -> None:
    assert quantity_factor(unit, quantity, CASE) == pytest.approx(factor, rel=1e-14)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("unit", "quantity"), [("mm", "stress"), ("MPa", "force"), ("s", "rate"), ("mm", "ratio")]
)
def test_units_of_something_else_are_refused(unit: str, quantity: str) -> None:
    with pytest.raises(
        UnitError, match=f"here: not a unit of .*found '{unit}'.*allowed: a unit of .*such as"
    ):
        quantity_factor(unit, quantity, CASE, "here")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "text", "options", "kind", "message"),
    [
        ("d.k", DECK, {"curve": 9}, FileError, r"no \*DEFINE_CURVE 9.*curve = 7, 8, 12"),
        ("d.k", DECK, {}, FileError, "which curve is meant"),
        ("d.k", "*KEYWORD\n*END\n", {}, FileError, r"there is no \*DEFINE_CURVE"),
        ("d.k", DECK, {"curve": 7, "columns": ["a", "b"]}, InputError, "only a CSV file has"),
        ("d.k", DECK, {"curve": 7, "units": ["MPa"]}, InputError, "two units"),
        ("d.k", "*DEFINE_CURVE\n3\n0.0,0.0\n", {}, FileError, "two finite points"),
        ("c.csv", "a,b\n0,0\n1,1\n", {"curve": 7}, InputError, "only a keyword deck"),
        ("c.csv", "a,b,c\n0,0,0\n1,1,1\n", {}, FileError, "which columns are meant"),
        ("c.csv", "0,0\n1,1\n", {}, FileError, "the first line must name the columns"),
        ("c.csv", "a,b\n0,0\n", {}, FileError, "two finite points"),
        ("c.csv", "a,b\n0,0\n1,x\n", {}, FileError, r"c\.csv:3.*a number for a and b"),
        ("c.csv", "a,b [N]\n0,0\n1,1\n", {}, UnitError, "not a unit of stress; found 'N'"),
    ],
)
def test_wrong_curves_are_told(
    tmp_path: Path, name: str, text: str, options: dict, kind: type, message: str
) -> None:
    with pytest.raises(kind, match=message):
        read_curve(write(tmp_path, name, text), STRESS, CASE, **options)
