"""Velocities given with a step: what they make of rates and slip, and which are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

pose = cg.motion.pose
POINTS = np.array([[0.0, 0.0, 1.1], [0.1, 0.0, 1.1], [np.nan, 0.0, 0.0]])
AT_REST = np.zeros((3, 3))
STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def pressed(**given: Any) -> cg.State:
    """A ball that comes down on two points and one that is nowhere."""
    law = cg.PenaltyLaw(100.0, damping=7.0)
    ball, slave = cg.Body([cg.shapes.sphere()]), cg.Slave(np.nan_to_num(POINTS), area=np.ones(3))
    contact = cg.Contact(ball, slave, law=law, friction=cg.ViscousFriction(0.5, 1e-6))
    X_WB = pose.translation([0.0, 0.0, 0.2])
    return contact.step(contact.start(POINTS), POINTS, X_WB, 0.1, **given)


def test_rates_and_slip_are_those_of_the_velocities_not_of_the_step() -> None:
    velocity = np.array([[0.0, 0.3, -0.2], [0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    state = pressed(velocity=velocity, twist=((0.0, 0.0, 0.5), (2.0, 0.0, 0.0)))
    # At the top of the ball: sinking by 0.5 + 0.2, and against the spin, -1.8 along y, by 2.1.
    assert state.damping[0] == pytest.approx(7.0 * 0.7, rel=1e-12)
    normal = state.normal_force[0]
    assert normal == pytest.approx(100.0 * 0.1 + 4.9, rel=1e-12)
    np.testing.assert_allclose(state.friction[0], [0.0, -0.5 * normal, 0.0], atol=1e-9)
    assert not state.force[2].any()


UNKNOWN = np.where(np.arange(3)[:, None] == 1, np.nan, AT_REST)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"velocity": AT_REST}, "twist: .*which moves, is not; allowed: both or neither"),
        ({"twist": STILL}, "velocity: .*is not; allowed: both or neither"),
        ({"velocity": AT_REST[:2], "twist": STILL}, "velocity must have .*found 2; allowed: 3"),
        ({"velocity": UNKNOWN, "twist": STILL}, r"velocity\[1\]: a point that has a place"),
        ({"velocity": AT_REST + np.inf, "twist": STILL}, r"velocity\[0\]: a point that has"),
        ({"velocity": "fast", "twist": STILL}, "velocity must be an array of numbers"),
        ({"velocity": AT_REST, "twist": (0.0, np.nan)}, "twist: .*three finite numbers each"),
        ({"velocity": AT_REST, "twist": ((0, 0, np.nan), (0, 0, 0))}, "twist: .*three finite"),
        ({"velocity": AT_REST, "twist": np.zeros(6)}, "twist: .*three finite numbers each"),
        ({"velocity": AT_REST, "twist": 1.0}, "twist: .*three finite numbers each"),
    ],
)
def test_wrong_velocities_are_refused(given, message) -> None:
    with pytest.raises(InputError, match=message):
        pressed(**given)
