"""Gas in chambers against closed forms: compressed, blown in, let out, shared."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from contiga.dynamics.gas import (
    Chamber,
    Chambers,
    Exposed,
    GasState,
    Inflator,
    Surroundings,
    Vent,
)
from contiga.dynamics.gases import IdealGas
from contiga.errors import InputError

AIR = IdealGas(1.4, 287.05)
AROUND = Surroundings(101_325.0, 293.15, AIR)
LITRE = 1e-3


def exposed(chambers: Chambers, area: float = 1.0) -> list[Exposed]:
    return [Exposed(area, np.ones(len(one.vents))) for one in chambers.chambers]


def alone(**given: Any) -> Chambers:
    return Chambers([Chamber("bag", AROUND, **given)])


def gone(chambers: Chambers, start: list[GasState], end: float, steps: int) -> list[GasState]:
    """Steps at volumes that stay."""
    now, volumes = start, np.array([state.volume for state in start])
    for k in range(1, steps + 1):
        now = chambers.step(now, volumes, exposed(chambers), k * end / steps, end / steps)
    return now


def test_compression_is_adiabatic() -> None:
    """60 to 40 litres of air: 178,749 Pa, 344.768 K, 2,676.18 J."""
    chambers = alone()
    (state,) = chambers.start(np.array([60 * LITRE]))
    before = state.energy
    for k in range(1, 8):
        volume = 60 * LITRE - k * 20 * LITRE / 7
        (state,) = chambers.step([state], np.array([volume]), exposed(chambers), 0.1 * k, 0.1)
    assert state.pressure == pytest.approx(101_325.0 * 1.5**1.4, rel=1e-12)
    assert state.pressure == pytest.approx(178_749.0, rel=1e-5)
    assert state.temperature == pytest.approx(344.768, rel=1e-5)
    assert state.energy - before == pytest.approx(2676.18, rel=1e-5)


def test_filling_at_a_fixed_volume_raises_the_pressure_evenly() -> None:
    """0.1 kg/s at 700 K into 60 litres: dp/dt = γ R T ṁ / V = 468.848 kPa/s."""
    chambers = alone(inflators=[Inflator(0.1, 700.0)])
    (state,) = gone(chambers, chambers.start(np.array([60 * LITRE])), 0.05, 7)
    assert state.pressure - 101_325.0 == pytest.approx(468_848.0 * 0.05, rel=1e-5)
    assert state.came == pytest.approx(0.1 * 0.05 * AIR.c_p * 700.0, rel=1e-12)


def blown(pressure: float, volume: float, vent: Vent) -> tuple[Chambers, list[GasState]]:
    """A chamber of air at the temperature around it and another pressure."""
    chambers = alone(vents=[vent])
    (state,) = chambers.start(np.array([volume]))
    more = pressure / state.pressure
    return chambers, [
        state._replace(masses=more * state.masses, energy=more * state.energy, pressure=pressure)
    ]


@pytest.mark.interpreted
def test_choked_outflow_follows_the_closed_form() -> None:
    """p = p₀ (1 + (γ−1)/2 · t/τ)^{−2γ/(γ−1)} with τ = V / (C A c₀) of an adiabatic blow-down."""
    area, volume, first = 1e-4, 10 * LITRE, 8e5
    chambers, start = blown(first, volume, Vent(area, coefficient=0.8))
    g, end = 1.4, 0.2
    choked = math.sqrt(g) * (2.0 / (g + 1.0)) ** ((g + 1.0) / (2.0 * (g - 1.0)))
    rate = 0.8 * area / volume * choked * math.sqrt(287.05 * 293.15)
    wanted = first * (1.0 + 0.5 * (g - 1.0) * rate * end) ** (-2.0 * g / (g - 1.0))
    assert wanted > 2.0 * 101_325.0
    errors = []
    for steps in (20, 40):
        (state,) = gone(chambers, start, end, steps)
        errors.append(abs(state.pressure / wanted - 1.0))
        assert state.temperature == pytest.approx(
            293.15 * (wanted / first) ** (2.0 / 7.0), rel=1e-3
        )
    assert errors[1] < 2e-5
    assert errors[0] > 3.0 * errors[1]


def test_outflow_goes_on_to_the_pressure_around() -> None:
    area, volume, first = 2e-3, 10 * LITRE, 3e5
    chambers, start = blown(first, volume, Vent(area))

    def slope(_: float, y: np.ndarray) -> list[float]:
        mass, energy = y
        temperature = energy / (mass * AIR.c_v)
        pressure = mass * 287.05 * temperature / volume
        if pressure <= 101_325.0:
            return [0.0, 0.0]
        ratio = max(101_325.0 / pressure, (2.0 / 2.4) ** 3.5)
        swing = 7.0 / (287.05 * temperature) * (ratio ** (2.0 / 1.4) - ratio ** (2.4 / 1.4))
        rate = area * pressure * math.sqrt(swing)
        return [-rate, -rate * AIR.c_p * temperature]

    first_y = [float(start[0].masses[0]), start[0].energy]
    wanted = solve_ivp(slope, (0.0, 0.01), first_y, rtol=1e-10, atol=1e-12).y[:, -1]
    (state,) = gone(chambers, start, 0.01, 50)
    np.testing.assert_allclose([state.masses[0], state.energy], wanted, rtol=2e-4)
    (late,) = gone(chambers, start, 1.0, 50)
    assert late.pressure == pytest.approx(101_325.0, rel=1e-6)
    assert late.left - late.came == pytest.approx(start[0].energy - late.energy, rel=1e-9)


def test_two_chambers_come_to_one_pressure_and_keep_mass_and_energy() -> None:
    chambers = Chambers(
        [
            Chamber("a", AROUND, vents=[Vent(1e-3, to="other")], name="one"),
            Chamber("b", AROUND, name="other"),
        ]
    )
    start = chambers.start(np.array([20 * LITRE, 30 * LITRE]))
    start[0] = start[0]._replace(
        masses=3.0 * start[0].masses, energy=3.0 * start[0].energy, pressure=3.0 * 101_325.0
    )
    end = gone(chambers, start, 1.0, 100)
    assert end[0].pressure == pytest.approx(end[1].pressure, rel=1e-6)
    # Of one gas the energy by volume is the pressure.
    assert end[0].pressure == pytest.approx(101_325.0 * (3.0 * 20 + 30) / 50, rel=1e-6)
    for what in ("energy", "masses"):
        before, after = (sum(np.sum(getattr(s, what)) for s in states) for states in (start, end))
        assert after == pytest.approx(before, rel=1e-12)
    assert end[0].temperature < 293.15 < end[1].temperature


@pytest.mark.parametrize("area", [1e-2, 1.0, 1e6])
@pytest.mark.parametrize("dt", [1e-3, 1e-5])
def test_a_vent_as_wide_as_can_be_lets_out_what_comes_in(area: float, dt: float) -> None:
    """The pressure is that around, and what goes is what came: no gas goes to and fro."""
    chambers = alone(inflators=[Inflator(0.01, 600.0)], vents=[Vent(area)])
    now = chambers.start(np.array([60 * LITRE]))
    for k in range(1, 301):
        now = chambers.step(now, np.array([60 * LITRE]), exposed(chambers), k * dt, dt)
    came = 300 * dt * 0.01 * AIR.c_p * 600.0
    assert now[0].pressure == pytest.approx(101_325.0, rel=2e-5)
    assert now[0].came == pytest.approx(came, rel=1e-4)
    assert now[0].left <= now[0].came * (1.0 + 1e-9)
    assert now[0].left == pytest.approx(came, rel=2e-2 * (1e-3 / dt) if area < 0.1 else 1e-4)


@pytest.mark.interpreted
def test_gases_mix() -> None:
    helium = IdealGas(5.0 / 3.0, 2077.0)
    chambers = alone(inflators=[Inflator(0.01, 293.15, helium)])
    (start,) = chambers.start(np.array([60 * LITRE]))
    (state,) = gone(chambers, [start], 1.0, 200)
    mass, added = float(start.masses[0]), 0.01
    energy = start.energy + added * helium.c_p * 293.15
    temperature = energy / (mass * AIR.c_v + added * helium.c_v)
    assert state.temperature == pytest.approx(temperature, rel=1e-12)
    pressure = (mass * 287.05 + added * 2077.0) * temperature / (60 * LITRE)
    assert state.pressure == pytest.approx(pressure, rel=1e-12)


def test_flow_between_chambers_of_nearly_one_pressure_is_a_number() -> None:
    chambers = Chambers(
        [
            Chamber("a", AROUND, vents=[Vent(4e-4, to="other")], name="one"),
            Chamber("b", AROUND, name="other"),
        ]
    )
    for more in (1e-6, 1e-10, 1e-12, 1e-13):
        start = chambers.start(np.array([60 * LITRE, 40 * LITRE]))
        energy = (1.0 + more) * start[0].energy
        temperature = (1.0 + more) * start[0].temperature
        start[0] = start[0]._replace(energy=energy, temperature=temperature)
        end = gone(chambers, start, 0.1, 100)
        assert end[0].pressure == pytest.approx(end[1].pressure, rel=1e-13)


def test_fabric_leaks_by_its_pressure() -> None:
    leaky = alone(leak=[[0.0, 0.0], [50_000.0, 0.0], [100_000.0, 0.02]])
    ends = []
    for pressure in (140_000.0, 202_650.0):
        (state,) = leaky.start(np.array([60 * LITRE]))
        more = pressure / state.pressure
        state = state._replace(masses=more * state.masses, energy=more * state.energy)
        (after,) = leaky.step([state], np.array([60 * LITRE]), exposed(leaky), 1e-4, 1e-4)
        ends.append(after.left)
    assert ends[0] == 0.0
    assert ends[1] > 0.0


def test_a_covered_vent_lets_nothing_out() -> None:
    chambers, start = blown(3e5, 10 * LITRE, Vent(1e-3))
    ends = []
    for share in (0.0, 0.5, 1.0):
        open_part = [Exposed(1.0, np.array([share]))]
        (after,) = chambers.step(start, np.array([10 * LITRE]), open_part, 1e-6, 1e-6)
        ends.append(after.left)
    assert ends[0] == 0.0
    assert ends[1] == pytest.approx(0.5 * ends[2], rel=1e-3)


def test_a_vent_opens_at_its_pressure_and_stays_open() -> None:
    vent = Vent(1e-3, opens_at=50_000.0)
    chambers = alone(inflators=[Inflator([[0.0, 0.1], [0.2, 0.1]], 700.0)], vents=[vent])
    now = chambers.start(np.array([60 * LITRE]))
    pressures = []
    for k in range(1, 101):
        now = chambers.step(now, np.array([60 * LITRE]), exposed(chambers), 0.005 * k, 0.005)
        pressures.append(now[0].pressure)
    # It opens within a step; from one to the next the pressure rises by 2,345 Pa.
    assert 151_325.0 - 2_345.0 < max(pressures) <= 151_325.0 + 2_345.0
    assert pressures[-1] == pytest.approx(101_325.0, rel=1e-3)


def test_steps_end_where_flows_bend() -> None:
    rate, vents = (
        [[0.5, 0.1], [2.0, 0.3]],
        [Vent(1.0, opens_after=7.0), Vent([[3.0, 1.0]], over="time")],
    )
    chamber = Chamber("bag", AROUND, inflators=[Inflator(rate, 300.0)], vents=vents)
    assert sorted(chamber.kinks.tolist()) == [0.0, 0.5, 2.0, 3.0, 7.0]


@pytest.mark.interpreted
def test_fabric_leaks_by_its_area() -> None:
    leaky, vented = alone(leak=0.01), alone(vents=[Vent(0.02)])
    ends = []
    for chambers in (leaky, vented):
        (state,) = chambers.start(np.array([60 * LITRE]))
        state = state._replace(masses=2 * state.masses, energy=2 * state.energy, pressure=202_650.0)
        (after,) = chambers.step(
            [state], np.array([60 * LITRE]), exposed(chambers, 2.0), 1e-4, 1e-4
        )
        ends.append(after.pressure)
    assert ends[0] == pytest.approx(ends[1], rel=1e-14)


def test_gas_comes_in_where_the_pressure_is_lower() -> None:
    chambers = alone(vents=[Vent(1e-3)])
    (state,) = chambers.start(np.array([60 * LITRE]))
    now = [state]
    for k in range(1, 101):
        now = chambers.step(
            now, np.array([(60 + 0.2 * k) * LITRE]), exposed(chambers), 0.01 * k, 0.01
        )
    assert now[0].came > 0.0
    assert now[0].pressure == pytest.approx(101_325.0, rel=5e-3)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: IdealGas(1.0, 287.0), "gamma"),
        (lambda: Inflator(-0.1, 300.0), "mass_rate"),
        (lambda: Inflator([[0.0, 0.1], [0.0, 0.2]], 300.0), "go back or repeat"),
        (lambda: Inflator(0.1, [[0.0, 0.0], [1.0, 300.0]]), "temperature"),
        (lambda: Vent(-1.0), "area"),
        (lambda: Vent(1.0, over="way"), "over"),
        (lambda: Vent(1.0, coefficient=0.0), "coefficient"),
        (lambda: Vent(1.0, opens_at=math.nan), "opens_at"),
        (lambda: Vent(1.0, opens_after="soon"), "opens_after"),
        (lambda: Inflator(0.1, 300.0, gas=1.4), r"gas\[0\]: must be a gas"),
        (lambda: IdealGas("air", 287.0), "gamma"),
        (lambda: Chamber("bag", {"pressure": 1.0}), "surroundings"),
        (lambda: Chamber("bag", Surroundings(1e5, 293.0, "air")), "surroundings: gas"),
        (lambda: alone(leak="much"), "leak"),
        (lambda: alone(leak=-1.0), "leak"),
        (lambda: alone(vents=[Vent(1.0, to="gas")]), "leads to no other chamber"),
        (lambda: alone(vents=[0.1]), "vents"),
        (lambda: Chamber("bag", Surroundings(0.0, 293.0, AIR)), "pressure"),
        (lambda: Chamber("bag", AROUND, name="ambient"), "stands for the surroundings"),
        (
            lambda: Chambers(
                [
                    Chamber("a", AROUND, vents=[Vent(1.0, to="two")], name="one"),
                    Chamber("b", AROUND, vents=[Vent(1.0, to="one")], name="two"),
                ]
            ),
            "gas flows both ways through each vent",
        ),
    ],
)
def test_what_is_wrong_is_told(make: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()


def test_the_times_of_an_inflator_count_from_when_it_is_fired() -> None:
    table = [[0.0, 0.0], [0.1, 0.2]]
    waiting = alone(inflators=[Inflator(table, 700.0, trigger="crash")])
    known = alone(inflators=[Inflator(table, 700.0)])
    volumes, one = np.array([60 * LITRE]), np.ones(1)
    (state,) = (before,) = waiting.start(volumes)
    for k in range(1, 6):  # fired at 0.3, told in time
        (state,) = waiting.step([state], volumes, one, 0.1 * k, 0.1, {"crash": 0.3})
        assert (state.came > 0.0) == (k > 3)
    (exact,) = known.step([before], volumes, one, 0.1, 0.1)
    assert state.came == pytest.approx(exact.came, rel=1e-12)
    assert waiting.step([before], volumes, one, 0.1, 0.1)[0].came == 0.0
    assert not waiting.chambers[0].kinks.size


@pytest.mark.interpreted
def test_a_vent_is_shut_until_its_trigger_fires_and_its_times_count_from_then() -> None:
    """Fired at 0.25, which is known in time: one opens at once, two 0.1 later, for a while one."""
    area = [[0.1, 0.0], [0.1001, 1e-5], [0.2, 1e-5], [0.2001, 0.0]]
    vents = {
        "at once": Vent(1e-5, trigger="crash"),
        "after": Vent(1e-5, opens_after=0.1, trigger="crash"),
        "known": Vent(1e-5, opens_after=0.35),
        "table": Vent(area, over="time", trigger="crash"),
    }
    chambers = {name: blown(3e5, 10 * LITRE, vent)[0] for name, vent in vents.items()}
    (start,) = blown(3e5, 10 * LITRE, vents["known"])[1]
    states, left = {name: [start] for name in vents}, {}
    for k in range(1, 101):
        fired = {"crash": 0.25} if k > 25 else {}
        for name, each in chambers.items():
            volumes, time = np.array([start.volume]), 0.005 * k
            states[name] = each.step(states[name], volumes, exposed(each), time, 0.005, fired)
        left[k] = {name: state.left for name, (state,) in states.items()}
        opened = {name for name, one in left[k].items() if one > 0.0}
        assert opened == (set(vents) if k > 70 else {"at once"} if k > 50 else set())
        assert left[k]["after"] == pytest.approx(left[k]["known"], rel=1e-12)
    assert left[91]["table"] == left[100]["table"] < left[100]["after"]
    assert chambers["after"].chambers[0].kinks.size == 0
    assert list(chambers["after"].chambers[0].waiting) == ["vents[0]"]
