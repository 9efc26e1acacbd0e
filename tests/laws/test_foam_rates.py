"""Foam with rates: whatever way its strain goes and comes back, it gains no work."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tests.sample import FULL
from tests.unit.matter import rig

from contiga.materials import Foam

REST = np.array([[0.0, 0.0], [0.05, 0.1], [0.6, 0.2], [0.9, 3.0]])
TABLES = ((1e-2, [[0, 0], [0.05, 0.15], [0.6, 0.3], [0.9, 4.0]]), (1.0, REST * [1.0, 4.0]))
CUBE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
STEPS = 100


class Leg(NamedTuple):
    """A straight way of the stretch tensor."""

    stretches: tuple[float, float, float]
    """Principal ones at its end."""
    turn: tuple[float, float, float]
    """Of the principal axes there, as a rotation vector."""
    time: float
    """Decimal logarithm of how long it takes."""


stretch = st.floats(0.3, 1.3)
angle = st.floats(-2.0, 2.0)
legs = st.builds(
    Leg,
    st.tuples(stretch, stretch, stretch),
    st.tuples(angle, angle, angle),
    st.floats(-2.0, 2.5),
)
STILL = (0.0, 0.0, 0.0)
ROUNDING = 1e-25
"""Work of a foam that turns without being strained."""
ACROSS = [
    Leg((1.0, 0.5, 1.0), STILL, 1.7),
    Leg((0.45, 0.5, 1.0), STILL, -1.3),
    Leg((0.45, 1.0, 1.0), STILL, -1.3),
]
"""y slowly, x quickly, y quickly back: it gained work while x's rate was y's, too."""
TURNED = [Leg((0.4, 1.0, 1.0), STILL, -1.0), Leg((0.4, 1.0, 1.0), (0.0, 0.0, 1.4), -1.0)]


class Way(NamedTuple):
    """What a closed way of the strain took."""

    work: float
    both: float
    """What went in and what came out, added."""
    viscosity: float


def there_and_back(ways: list[Leg], last: float, smoothing: float, steps: int = STEPS) -> Way:
    """From rest along `ways` and straight back in 10^last, in so many steps each."""
    foam = Foam(loading=REST, rates=TABLES, filter=smoothing)
    matter = rig.one_part("tet4", CUBE, np.arange(4)[None], foam)
    state, force, begin = matter.start(), np.zeros((4, 3)), np.eye(3)
    work = both = lost = 0.0
    for leg in [*ways, Leg((1.0, 1.0, 1.0), STILL, last)]:
        axes = Rotation.from_rotvec(leg.turn).as_matrix()
        end, dt = axes @ np.diag(leg.stretches) @ axes.T, 10.0**leg.time / steps
        for share in np.arange(1, steps + 1) / steps:
            q = matter.nodes @ ((1.0 - share) * begin + share * end)
            answer = matter.forces(state, q, (q - state.points) / dt, dt)
            done = -0.5 * float(np.sum((answer.force + force) * (q - state.points)))
            work, both, lost = work + done, both + abs(done), lost + answer.energy.viscosity
            state, force = answer.state, answer.force
        begin = end
    return Way(work, both, lost)


@settings(max_examples=500 if FULL else 15)
@given(st.lists(legs, min_size=1, max_size=3), st.floats(-2.0, 2.5), st.sampled_from([0.02, 1.0]))
@example(ACROSS, 1.7, 0.05)
@example(TURNED, -1.0, 0.5)
def test_no_closed_way_of_the_strain_gains_work(
    ways: list[Leg], last: float, smoothing: float
) -> None:
    """Its curves at rest give back all, so that what is left is what the rates took: to the error
    of the trapezoidal rule."""
    way = there_and_back(ways, last, smoothing)
    if abs(way.work - way.viscosity) > 1e-3 * way.both + ROUNDING:
        way = there_and_back(ways, last, smoothing, 4 * STEPS)
    assert way.work >= -1e-4 * way.both - ROUNDING
    assert abs(way.work - way.viscosity) <= 1e-3 * way.both + ROUNDING
