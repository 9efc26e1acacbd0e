"""Faces that lie on each other in what hangs together by its edges."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.borders.test_meetings import MOVED, UNIT, ball, box, rod

import contiga as cg
from contiga.search.borders.coincident import coincident_at
from contiga.search.borders.openings import openings_of


@pytest.mark.parametrize("moved", [False, True])
def test_a_wall_between_tiles_that_share_all_its_edges_is_found(moved: bool) -> None:
    body = cg.Body(box(*UNIT) + box((1, 0, 0), (2, 1, 1)))
    if moved:
        body = body.transformed(MOVED)
    found = coincident_at(body)
    assert found is not None
    a, b, place = found
    assert {a, b} == {1, 6}  # the upper end in x of the first, the lower end of the second
    for patch in (a, b):
        gap = cg.Body([body.patches[patch]]).project(place[None]).gap
        assert abs(gap[0]) < 1e-12 * body.size + 1e-14 * np.abs(place).max()
    assert not openings_of(body).closed


@pytest.mark.parametrize("patches", [box(*UNIT), rod(1.0, 0.0, 2.0), ball(2.0) + ball(1.0)])
def test_sound_bodies_and_thin_ones_have_none(patches: list[cg.NurbsSurface]) -> None:
    for factor in (1e-6, 1.0, 1e4):
        assert coincident_at(cg.Body(patches).scaled(factor)) is None
    thin = np.diag([1.0, 1.0, 1e-4, 1.0])
    assert coincident_at(cg.Body(patches).transformed(thin)) is None
