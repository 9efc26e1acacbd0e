"""Newton's method of an implicit code with the contact's tangent: few iterations, quadratic."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block
from tests.elastic import solved, stiffness

import contiga as cg

RADIUS = 10.0
SLAVE = block((12, 4, 4), (24.0, 8.0, 8.0), kind="hexahedron")


def assert_quadratic(residuals: list[float]) -> None:
    """From where contact does not change any more each miss is the last one's square, but for a
    factor and for rounding."""
    before, last = np.array(residuals[-2:]) / residuals[0]
    assert last <= max(1e3 * before**2, 1e-11), residuals
    assert len(residuals) - 1 <= 6, residuals


@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.3)])
def test_a_cylinder_is_pressed_into_rubber_and_drawn_over_it(friction: object) -> None:
    points = SLAVE.points
    elastic = stiffness(points, SLAVE.elements["hexahedron"], 10.0, 0.3)
    free = np.flatnonzero(np.repeat(points[:, 2] > 0.0, 3))
    cylinder = cg.Body([cg.shapes.cylinder(radius=RADIUS, height=40.0, axis=(0, 1, 0))])
    law = cg.StressLaw(20.0, 1.0)
    contact = cg.Contact(cylinder, SLAVE, law=law, friction=friction, quadrature=3)

    def inner(x: np.ndarray) -> tuple:
        return elastic @ (x - points).ravel(), elastic

    def pose(x: float, depth: float) -> np.ndarray:
        return cg.motion.pose.translation([x, 4.0, 8.0 + RADIUS - depth])

    now = contact.start(points, pose(6.0, -0.5)), points
    pressed = [pose(6.0, depth) for depth in (0.25, 0.5, 0.75, 1.0)]
    for place in [*pressed, *(pose(6.0 + x, 1.0) for x in range(1, 9))]:
        found = solved(contact, inner, free, now, place)
        assert_quadratic(found.residuals)
        assert len(found.state.kinks) == 0
        now = found.state, found.points
    drawn, _, pressed_down = found.state.total_force
    if friction is None:
        assert abs(drawn) < 0.05 * abs(pressed_down)
    else:
        assert drawn == pytest.approx(0.3 * abs(pressed_down), rel=0.15)
