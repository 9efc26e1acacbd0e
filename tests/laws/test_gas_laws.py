"""Gas of any chambers: nothing is lost, and pressures of one gas come together and stay so."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from contiga.dynamics.gas import Chamber, Chambers, Exposed, GasState, Surroundings, Vent
from contiga.dynamics.gases import Gas, IdealGas, ThermallyPerfectGas

GASES: tuple[Gas, ...] = (
    IdealGas(1.4, 287.05),
    IdealGas(5.0 / 3.0, 2077.0),
    ThermallyPerfectGas(296.8, [[300.0, 1040.0], [600.0, 1075.0], [1000.0, 1167.0]]),
)


def powers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda power: 10.0**power)


ROOMS = st.builds(Surroundings, powers(3.0, 6.5), st.floats(150.0, 2500.0), st.sampled_from(GASES))
SIZES = st.tuples(powers(-4.0, 1.0), powers(-4.0, 1.0))
AREAS, STEPS = powers(-9.0, 3.0), powers(-8.0, 0.0)


def kept(states: list[GasState]) -> tuple[np.ndarray, float]:
    return sum((s.masses for s in states), np.zeros(1)), sum(s.energy for s in states)


@given(rooms=st.tuples(ROOMS, ROOMS), sizes=SIZES, area=AREAS, dt=STEPS)
def test_two_chambers_keep_all_they_have_and_pass_no_common_pressure(
    rooms: tuple[Surroundings, Surroundings], sizes: tuple[float, float], area: float, dt: float
) -> None:
    chambers = Chambers(
        [
            Chamber("a", rooms[0], vents=[Vent(area, to="other")], name="one"),
            Chamber("b", rooms[1], name="other"),
        ]
    )
    volumes, exposed = np.array(sizes), [Exposed(0.0, np.ones(1)), Exposed(0.0, np.zeros(0))]
    now = chambers.start(volumes)
    masses, energy = kept(now)
    excess, high = now[0].pressure - now[1].pressure, max(s.pressure for s in now)
    for k in range(1, 6):
        now = chambers.step(now, volumes, exposed, k * dt, dt)
        after = now[0].pressure - now[1].pressure
        np.testing.assert_allclose(kept(now)[0], masses, rtol=1e-12)
        np.testing.assert_allclose(kept(now)[1], energy, rtol=1e-12)
        if rooms[0].gas == rooms[1].gas:  # a cold gas may lower the pressure of a hot one
            assert abs(after) <= abs(excess) + 1e-9 * high
            assert after * np.sign(excess) >= -1e-9 * high
        assert all((state.masses >= 0.0).all() for state in now)
        excess = after


@given(room=ROOMS, squeezed=st.floats(0.2, 5.0), area=AREAS, dt=STEPS)
def test_what_a_chamber_gains_is_what_came_and_the_work_on_it(
    room: Surroundings, squeezed: float, area: float, dt: float
) -> None:
    """Squeezed to another volume and back, with a vent open, it has lost what went out."""
    chambers = Chambers([Chamber("a", room, vents=[Vent(area)], leak=area)])
    (start,) = now = chambers.start(np.array([0.03]))
    exposed, worked = [Exposed(0.5, np.ones(1))], 0.0
    for k, volume in enumerate((0.03 * squeezed, 0.03 * squeezed, 0.03, 0.03), 1):
        (before,) = now
        (after,) = now = chambers.step(now, np.array([volume]), exposed, k * dt, dt)
        flowed = (after.came - before.came) - (after.left - before.left)
        work = after.energy - before.energy - flowed
        if volume == before.volume:
            assert abs(work) <= 1e-12 * (after.energy + after.came + after.left)
        else:  # a smaller volume takes work, a larger one gives it
            assert work * (before.volume - volume) > 0.0
        worked += work
    assert worked >= -1e-12 * (start.energy + now[0].came)
