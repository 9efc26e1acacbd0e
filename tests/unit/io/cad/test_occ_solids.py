"""Closed pieces of bodies as solids of OpenCASCADE."""

from __future__ import annotations

import numpy as np
import pytest
from tests import occ_solids as made
from tests.unit.search.borders.test_meetings import MOVED, UNIT, ball, box, cavity, rod

import contiga as cg
from contiga.io.cad.occ_solids import Solid, hollow_out, solid_of, volume_of

SCALE = 512.0

PIECES = {
    "box": box(*UNIT),
    "rod": rod(1.0, 0.0, 2.0),
    "ball": ball(1.0),
    "torus": [cg.shapes.torus(major=3.0, minor=1.0)],
}


def _solid(body: cg.Body) -> Solid:
    solid = solid_of(body, range(len(body.patches)), SCALE)
    assert solid is not None
    return solid


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_is_a_solid_of_its_volume_whose_faces_know_their_patches(name: str) -> None:
    body = cg.Body(PIECES[name]).transformed(MOVED)
    solid = _solid(body)
    assert volume_of(solid.shape) == pytest.approx(SCALE**3 * body.volume(), rel=1e-7)
    assert set(solid.patches) == set(range(len(body.patches)))


@pytest.mark.parametrize("name", ["link_rod", "rounded_box"])
def test_faces_that_were_read_are_made_solids_again(name: str, tmp_path) -> None:
    body = cg.read_cad(made.write(getattr(made, name)(), tmp_path / "a.step"))
    assert volume_of(_solid(body).shape) == pytest.approx(SCALE**3 * body.volume(), rel=1e-6)


def test_what_is_open_is_none() -> None:
    assert solid_of(cg.Body(box(*UNIT)[:5]), range(5), SCALE) is None


def test_a_cavity_is_cut_out_where_it_lies_within() -> None:
    body = cg.Body(ball(2.0) + cavity(ball(1.0, 0.3, 0.0, 0.0)) + ball(1.0, 1.5, 0.0, 0.0))
    out, hole, beyond = (solid_of(body, [k], SCALE) for k in range(3))
    assert out is not None
    assert hole is not None
    assert beyond is not None
    hollow = hollow_out(out, hole)
    assert hollow is not None
    assert volume_of(hollow.shape) == pytest.approx(SCALE**3 * 4.0 / 3.0 * np.pi * 7.0, rel=1e-7)
    assert set(hollow.patches) == {0, 1}
    assert hollow_out(out, beyond) is None
