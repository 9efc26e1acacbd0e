"""Foam with rates in a deck, *MAT_FU_CHANG_FOAM with a table, as foam of the case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.decks import CONTACT, END, FLIGHT, RIGID, card, converted, deck, pad, sphere

import contiga as cg

FIRST = len(sphere()[0]) + 1
LOW = [FIRST + k for k, p in enumerate(pad()[0]) if p[2] < -9.0]
HELD = ["*SET_NODE_LIST", card(6), *(card(*LOW[k : k + 8]) for k in range(0, len(LOW), 8))]
SPC = ["*BOUNDARY_SPC_SET", card(6, 0, 1, 1, 1)]
POINTS = [(0.0, 0.0), (0.1, 1e-4), (0.6, 2e-4), (0.9, 2e-3)]
DENSITY, MODULUS = 1e-7, 3e-3


def curve(number: int, scale: float) -> list[str]:
    return ["*DEFINE_CURVE", card(number), *(f"{x:20}{scale * y:20.6g}" for x, y in POINTS)]


CURVES = [*curve(51, 1.0), *curve(52, 1.5), *curve(53, 2.5)]
RATES = (1e-4, 0.02, 0.5)
"""The first is at rest."""
IN_ORDER = ["*DEFINE_TABLE", card(50), *(f"{rate:20}" for rate in RATES), *CURVES]
BY_NUMBER = [
    "*DEFINE_TABLE_2D_TITLE", "rates", card(50),
    *(f"{rate:20}{number:20}" for rate, number in zip(RATES, (51, 52, 53), strict=True)), *CURVES,
]  # fmt: skip
SCALED = ["*DEFINE_TABLE", card(50, 1e-3), *(f"{1e3 * r:20}" for r in RATES), *CURVES]


def foam(second: str = card(0, 1, 0, 0, 0, 0, 0, 0.2), shape: float = 7.0) -> list[str]:
    first = card(22, DENSITY, MODULUS, "", "", "", "", 50)
    return ["*MAT_FU_CHANG_FOAM", first, second, "", card(0, 0, 0, 0, 0, 0, 0, shape)]


def case_of(folder: Path, *pieces: list[str]) -> tuple[cg.Case, str]:
    return converted(folder, deck(RIGID, CONTACT, FLIGHT, END, HELD, SPC, *pieces))


@pytest.mark.parametrize("table", [IN_ORDER, BY_NUMBER, SCALED])
def test_a_table_of_curves_is_foam_with_rates(tmp_path: Path, table: list[str]) -> None:
    case, text = case_of(tmp_path, foam(), table)
    (slave,) = cg.build(case).slaves.values()
    assert isinstance(slave.motion, cg.motion.Deforming)
    made = slave.motion.material
    np.testing.assert_array_equal(made.loading, POINTS)
    assert [rate for rate, _ in made.rates] == pytest.approx(RATES[1:], rel=1e-12)
    for (_, found), scale in zip(made.rates, (1.5, 2.5), strict=True):
        np.testing.assert_allclose(found, np.array(POINTS) * [1.0, scale], rtol=1e-12)
    assert (made.hysteresis, made.shape, made.tension) == (0.2, 7.0, MODULUS)
    # Twelve times as long as a wave takes through a facet.
    size = np.sqrt(2.0 * slave.slave.area.sum() / len(slave.slave.facets))
    assert made.filter == pytest.approx(12.0 * size / np.sqrt(MODULUS / DENSITY), rel=0.01)
    assert "Not understood" not in text
    assert "rates are smoothed" in text
    assert "SFLAG" not in text


def test_a_table_of_one_curve_has_no_rates(tmp_path: Path) -> None:
    alone = ["*DEFINE_TABLE", card(50), f"{1e-4:20}", *curve(51, 1.0)]
    case, text = case_of(tmp_path, foam(), alone)
    assert case.slave[0].motion.material.instance.rates == ()
    assert "smoothed" not in text


@pytest.mark.parametrize(
    ("pieces", "why"),
    [
        ([foam()], "there is no table 50"),
        ([foam(), ["*DEFINE_TABLE_2D", card(50), f"{1.0:20}{77:20}"]], "there is no curve 77"),
        ([["*MAT_083", card(22, DENSITY, MODULUS), card(0)]], "no table TBID"),
        (
            [foam(), [*BY_NUMBER[:3], *BY_NUMBER[5:6], f"{2.0:20}{51:20}", *CURVES]],
            "the stress falls with the rate",
        ),
    ],
)
def test_a_table_that_makes_no_foam_is_listed_and_the_part_rests(
    tmp_path: Path, pieces: list[list[str]], why: str
) -> None:
    case, text = case_of(tmp_path, *pieces)
    assert case.slave[0].motion.kind == "fixed"
    assert why in text.partition("Not understood")[2]


def test_what_it_is_not_is_said(tmp_path: Path) -> None:
    second = card(1, 0, 1, 1, 0, 0, 0, 0.2)
    _, text = case_of(tmp_path, foam(second), IN_ORDER)
    assert "its rates are taken as of nominal strain, SFLAG is 0" in text
    assert "*MAT_FU_CHANG_FOAM (BVFLAG 1, RFLAG 1, TFLAG 1), line" in text
