"""Shells that touch half a thickness off their mid-surface: closed forms, moments, energy."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg
from contiga.errors import InputError

LAW = cg.PenaltyLaw(50.0, per_area=True)


def _table() -> cg.Body:
    return cg.Body([cg.shapes.plane(width=10.0, length=10.0)], name="table")


def _sheet(thickness: float | None = 0.2) -> cg.Slave:
    return cg.Slave(*square_sheet(1.0, 9), thickness=thickness, name="sheet")


@pytest.mark.parametrize(("side", "height"), [("front", -0.1), ("back", 0.1), ("none", 0.0)])
def test_a_sheet_feels_the_table_half_its_thickness_away(side: str, height: float) -> None:
    sheet = _sheet()
    contact = cg.Contact(
        _table(), sheet, law=LAW, quadrature=3, shell_offset=side, search="penetration"
    )
    for depth in (-1e-3, 0.02):
        state = contact.start(np.add(sheet.points, [0.0, 0.0, height - depth]))
        expected = 50.0 * max(depth, 0.0) * sheet.area.sum()
        assert state.total_force[2] == pytest.approx(expected, rel=1e-12, abs=1e-15)
        assert state.force[:, 2].sum() == pytest.approx(expected, rel=1e-12, abs=1e-15)
        assert state.total_area == pytest.approx(sheet.area.sum() if depth > 0.0 else 0.0)


def test_friction_on_the_outside_turns_the_sheet() -> None:
    """A tangential force at the face of a belt has a moment about the mid-surface."""
    sheet = _sheet()
    contact = cg.Contact(
        _table(),
        sheet,
        law=LAW,
        quadrature=3,
        shell_offset="back",
        friction=cg.Coulomb(0.5),
    )
    state = contact.start(np.add(sheet.points, [0.0, 0.0, 0.11]))
    for x in np.linspace(0.0, 0.05, 20):
        points = np.add(sheet.points, [x, 0.0, 0.09])
        state = contact.step(state, points, dt=1.0)
    normal = 50.0 * 0.01 * sheet.area.sum()
    np.testing.assert_allclose(state.force.sum(axis=0), [-0.5 * normal, 0.0, normal], rtol=1e-9)
    moment = np.cross(points - points.mean(axis=0), state.force).sum(axis=0)
    np.testing.assert_allclose(moment, [0.0, 0.1 * 0.5 * normal, 0.0], atol=1e-9)


def test_forces_are_the_gradient_of_the_energy() -> None:
    """Of a wavy sheet on a ball: by differences of the energy that the points have stored."""
    rng, sheet = np.random.default_rng(3), _sheet()
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(
        ball, sheet, law=LAW, quadrature=6, shell_offset="back", search="penetration"
    )
    points = sheet.points - sheet.points.mean(axis=0) + [0.0, 0.0, 1.05]
    points = points + 0.01 * rng.normal(size=points.shape)
    state, h = contact.start(points), 1e-6
    way = rng.normal(size=points.shape)
    ahead, behind = (contact.start(points + s * h * way).energy.stored for s in (1.0, -1.0))
    assert state.energy.stored > 0.0
    assert (state.force * way).sum() == pytest.approx(-(ahead - behind) / (2.0 * h), rel=1e-6)


def test_what_it_cannot_stand_off_from_is_told() -> None:
    sheet = _sheet()
    with pytest.raises(InputError, match="contact is at the nodes"):
        cg.Contact(_table(), sheet, law=LAW, shell_offset="front")
    with pytest.raises(InputError, match="unknown shell_offset"):
        cg.Contact(_table(), sheet, law=LAW, quadrature=3, shell_offset="both")
    with pytest.raises(InputError, match="no thickness"):
        cg.Contact(_table(), _sheet(None), law=LAW, quadrature=3, shell_offset="front")
