"""Solids that nearly touch are told as they are read, and clearances are not."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from tests import occ_rig

import contiga as cg
from contiga.errors import ContigaWarning
from contiga.io.cad.near_solids import slits_between


def tiles(path: Path, gap: float, unit: str = "MM") -> Path:
    """Two boxes of 2 by 3 by 4 side by side, mm."""
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    made.assembly("all", (box, occ_rig.at(0, 0, 0), "a"), (box, occ_rig.at(2 + gap, 0, 0), "b"))
    return made.write(path, unit)


@pytest.mark.parametrize("gap", [1e-5, 4e-5])
def test_a_slit_that_is_not_closed_is_told_with_its_width_and_place(tmp_path, gap):
    with pytest.warns(
        ContigaWarning, match=rf"nearly touch: patches \d+ and \d+ are {gap:.3g} apart at \(2"
    ):
        body = cg.read_cad(tiles(tmp_path / "near.step", gap))
    (slit,) = slits_between(body)
    assert slit.width == pytest.approx(gap, rel=1e-6)
    assert abs(body.project([slit.point]).gap[0]) <= 1e-12


def test_a_clearance_is_none_however_large_or_small_the_unit(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error", ContigaWarning)
        for gap, unit in ((1e-4, "MM"), (2e-3, "M"), (0.05, "MM")):
            assert cg.read_cad(tiles(tmp_path / f"{unit}{gap}.step", gap, unit)).closed


def boxes(*lows):
    """Boxes of one a side, faces outward."""
    return [
        face.translated(low)
        for low in lows
        for face in (
            cg.shapes.bilinear(*np.array(corners, float))
            for corners in (
                [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)],
                [(0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1)],
                [(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 1)],
                [(0, 1, 0), (0, 1, 1), (1, 1, 0), (1, 1, 1)],
                [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1)],
                [(1, 0, 0), (1, 1, 0), (1, 0, 1), (1, 1, 1)],
            )
        )
    ]


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e3])
def test_what_touches_in_a_point_or_along_a_line_or_shares_an_edge_has_no_slit(size):
    ball = cg.shapes.sphere(radius=0.5, centre=(0.5, 0.5, 1.5))
    roller = cg.shapes.torus(major=3.0, minor=0.5, centre=(0.5, 0.5, 1.5 + 1e-9))
    for patches in (
        [*boxes((0, 0, 0)), ball],
        [*boxes((0, 0, 0)), ball.translated((0.0, 0.0, 1e-6))],
        [*boxes((-3, -3, 0), (3, 3, 0)), roller],
        boxes((0, 0, 0), (1 + 1e-6, 1 + 1e-6, 0)),
        boxes((0, 0, 0), (1 + 1e-3, 0, 0)),
        boxes((0, 0, 0), (3, 0, 0)),
    ):
        assert slits_between(cg.Body([p.scaled(size) for p in patches])) == []
    near = boxes((0, 0, 0), (1 + 3e-6, 0.3, 0.2), (0, 0, 5))
    (slit,) = slits_between(cg.Body([p.scaled(size) for p in near]))
    assert slit.width == pytest.approx(3e-6 * size, rel=1e-6)
