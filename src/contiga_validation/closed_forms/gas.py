"""Gas in chambers: compressed, blown in, let out, and shared between two of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import contiga as cg
from contiga.gas import (
    Chamber,
    IdealGas,
    Inflator,
    Mixture,
    Surroundings,
    ThermallyPerfectGas,
    Vent,
)
from contiga_validation.closed_forms.case import ROUNDING, Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Gas in chambers")
GAMMA, CONSTANT = 1.4, 287.05
AIR = IdealGas(GAMMA, CONSTANT)
C_P = GAMMA * CONSTANT / (GAMMA - 1.0)
PRESSURE, TEMPERATURE = 101_325.0, 293.15
AROUND = Surroundings(PRESSURE, TEMPERATURE, AIR)
VOLUME, COMPRESSED_VOLUME = 0.060, 0.040
"""Volumes before and after the compression, m³."""
AREA = 4e-4
"""Area of vents, m²."""
EXACT = 1e-12
"""Relative error allowed of masses and energies."""
FLOW_TOL = 1e-6
"""Relative error allowed of flows at the step of the case."""
CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


class Piston:
    """Motion of a box of unit base, whose lid goes evenly from one height to another.

    Parameters
    ----------
    start, end : heights of the lid
    after, until : times at which it starts to move, and at which it reaches `end`
    """

    def __init__(self, start: float, end: float, after: float, until: float) -> None:
        self.start, self.after, self.speed = start, after, (end - start) / (until - after)

    def points(self, t: float) -> FloatArray:
        """Return the corners (8, 3) at a time."""
        return CORNERS * [1.0, 1.0, self.start + self.speed * max(t - self.after, 0.0)]

    def velocities(self, t: float) -> FloatArray:
        """Return the velocities (8, 3) of the corners at a time."""
        return CORNERS * [0.0, 0.0, self.speed if t > self.after else 0.0]


def _run(
    chambers: dict[str, tuple[Chamber, float]],
    end: float,
    step: float,
    *,
    to: float | None = None,
    after: float = 0.0,
) -> dict[str, FloatArray]:
    """Return the history of chambers in boxes, each given with its volume at the start.

    Volumes stay, or go evenly to `to` from the time `after` until the end.
    """
    facets = np.array([[(a, b, c), (a, c, d)] for a, b, c, d in SIDES]).reshape(-1, 3)
    slaves: dict[str, Any] = {}
    for name, (_, volume) in chambers.items():
        piston = Piston(volume, volume if to is None else to, after, end)
        slaves[f"box of {name}"] = (cg.Slave(piston.points(0.0), facets), piston)
    gas = {name: chamber for name, (chamber, _) in chambers.items()}
    simulation = cg.Simulation(bodies={}, slaves=slaves, contacts=[], gas=gas, end=end, step=step)
    return dict(simulation.run().history)


def _chamber(name: str = "air", around: Surroundings = AROUND, **options: Any) -> Chamber:
    return Chamber(f"box of {name}", around, name=name, **options)


@CASES.add(
    "gas-compression",
    "Adiabatic compression",
    "p = p₀ (V₀/V)^γ: 178,749 Pa; T = T₀ (V₀/V)^(γ−1): 344.768 K; ΔU = 2,676.18 J",
    "Air of 60 litres at 101,325 Pa and 293.15 K in a box whose lid goes down to 40 litres.",
)
def _compression() -> Answer:
    history = _run({"air": (_chamber(), VOLUME)}, 0.01, 1e-3, to=COMPRESSED_VOLUME)
    t, volume, pressure = (history[name] for name in ("time", "air.volume", "air.pressure"))
    exact = PRESSURE * (VOLUME / (VOLUME + (COMPRESSED_VOLUME - VOLUME) * t / t[-1])) ** GAMMA
    energy = pressure * volume / (GAMMA - 1.0)
    first = PRESSURE * VOLUME / (GAMMA - 1.0)
    squeezed = (VOLUME / COMPRESSED_VOLUME) ** (GAMMA - 1.0)
    around = PRESSURE * (COMPRESSED_VOLUME - VOLUME)
    checks = (
        relative("pressure", pressure[-1], 178_749.0, 5e-6),
        relative("temperature", history["air.temperature"][-1], 344.768, 2e-6),
        relative("energy gained", energy[-1] - energy[0], 2_676.18, 2e-6),
        zero("pressure over the way", np.abs(pressure / exact - 1.0).max(), EXACT),
        relative("temperature by the formula", history["air.temperature"][-1],
                 TEMPERATURE * squeezed, EXACT),
        relative("energy of the ledger", history["energy.gas"][-1],
                 first * (squeezed - 1.0) + around, ROUNDING),
    )  # fmt: skip
    return Answer(checks, comparison(("t", "p"), [("formula", t, exact)], [("run", t, pressure)]))


@CASES.add(
    "gas-filling",
    "Filling a fixed volume",
    "dp/dt = γ R T_in ṁ/V = 468.848 kPa/s; T = p V/(m R)",
    "0.1 kg/s of air at 700 K blow into 60 litres at 101,325 Pa and 293.15 K for 50 ms.",
)
def _filling() -> Answer:
    rate, hot, end = 0.1, 700.0, 0.05
    chamber = _chamber(inflators=[Inflator(rate, hot)])
    history = _run({"air": (chamber, VOLUME)}, end, 1e-3)
    t, pressure, mass = (history[name] for name in ("time", "air.pressure", "air.mass"))
    slope = GAMMA * CONSTANT * hot * rate / VOLUME
    exact = PRESSURE + slope * t
    first = PRESSURE * VOLUME / (CONSTANT * TEMPERATURE)
    checks = (
        relative("pressure gained by time", (pressure[-1] - pressure[0]) / end, 468_848.0, 1e-6),
        zero("pressure over time", np.abs(pressure / exact - 1.0).max(), EXACT),
        relative("temperature", history["air.temperature"][-1],
                 exact[-1] * VOLUME / (CONSTANT * (first + rate * end)), EXACT),
        relative("mass", mass[-1], first + rate * end, EXACT),
        relative("enthalpy that came", history["air.flow_in"][-1], rate * end * C_P * hot, EXACT),
        zero("energy out of nothing, by what came",
             history["energy.error"][-1] / history["air.flow_in"][-1], EXACT),
    )  # fmt: skip
    return Answer(checks, comparison(("t", "p"), [("formula", t, exact)], [("run", t, pressure)]))


def _blown_down(around: float, end: float, step: float) -> dict[str, FloatArray]:
    """Return the history of a box of air at 8 atm that a vent empties into a room.

    The room has the pressure `around`, and is so large that it hardly changes.
    """
    full = _chamber("air", AROUND._replace(pressure=8.0 * PRESSURE), vents=[Vent(AREA, to="room")])
    room = _chamber("room", AROUND._replace(pressure=around))
    return _run({"air": (full, VOLUME), "room": (room, 1e9)}, end, step)


@CASES.add(
    "gas-heat-capacity",
    "Mixed gases whose heat capacities depend on temperature",
    "Σ m_k u_k(T) = Σ m_k u_k(T₀) + m_in h(T_in); Σ m_k ∫ c_v,k/T dT = Σ m_k R_k ln(V₀/V)",
    "Gas with c_p = a + b T and argon, at 900 K, blow into 60 litres of air; then a lid goes down "
    "to 40 litres.",
)
def _heat_capacity() -> Answer:
    a, b, constant, hot, rate, blown, end = 980.0, 0.2, 296.8, 900.0, 0.4, 0.1, 0.2
    nitrogen = ThermallyPerfectGas(constant, [[200.0, a + 200.0 * b], [2000.0, a + 2000.0 * b]])
    argon = IdealGas(5.0 / 3.0, 208.13)
    mixture = Mixture([(nitrogen, 0.8), (argon, 0.2)])
    blow = Inflator([[0.0, rate], [blown, rate]], hot, mixture)
    history = _run(
        {"air": (_chamber(inflators=[blow]), VOLUME)}, end, 1e-3, to=COMPRESSED_VOLUME, after=blown
    )
    t, temperature = history["time"], history["air.temperature"]
    masses = PRESSURE * VOLUME / (CONSTANT * TEMPERATURE), 0.8 * rate * blown, 0.2 * rate * blown
    heats = masses[0] * AIR.c_v + masses[2] * argon.c_v
    mass_constant = masses[0] * CONSTANT + masses[1] * constant + masses[2] * argon.constant
    low = 200.0 * (a + 200.0 * b)  # below its table c_p stays

    def enthalpy(x: float) -> float:
        return low + a * (x - 200.0) + 0.5 * b * (x * x - 200.0**2)

    enthalpy_in = masses[1] * enthalpy(hot) + masses[2] * argon.c_p * hot

    def gained(x: float) -> float:
        energy = heats * x + masses[1] * (enthalpy(x) - constant * x)
        return energy - masses[0] * AIR.c_v * TEMPERATURE - enthalpy_in

    warm = float(brentq(gained, TEMPERATURE, hot, xtol=1e-12))

    def entropy_change(x: float) -> float:
        entropy = (heats + masses[1] * (a - constant)) * math.log(x / warm)
        return (
            entropy
            + masses[1] * b * (x - warm)
            - mass_constant * math.log(VOLUME / COMPRESSED_VOLUME)
        )

    last = float(brentq(entropy_change, warm, 2.0 * warm, xtol=1e-12))
    row = int(np.argmin(np.abs(t - blown)))
    checks = (
        relative("enthalpy that came", history["air.flow_in"][-1], enthalpy_in, ROUNDING),
        relative("temperature when all is in", temperature[row], warm, ROUNDING),
        relative(
            "pressure then", history["air.pressure"][row], mass_constant * warm / VOLUME, ROUNDING
        ),
        relative("temperature at the end", temperature[-1], last, ROUNDING),
        relative("mass", history["air.mass"][-1], sum(masses), EXACT),
    )
    lines = [("formula", np.array([blown, end]), np.array([warm, last]))]
    return Answer(checks, comparison(("t", "T"), lines, [("run", t, temperature)]))


@CASES.add(
    "gas-choked",
    "A vent as fast as sound",
    "p = p₀ (1 + (γ−1)/2 · (2/(γ+1))^((γ+1)/(2(γ−1))) · A c₀ t/V)^(−2γ/(γ−1))",
    "60 litres of air at 8 atm flow out by 4 cm² while they do not see what is behind it.",
)
def _choked() -> Answer:
    end, first = 0.2, 8.0 * PRESSURE
    choked = (2.0 / (GAMMA + 1.0)) ** (0.5 * (GAMMA + 1.0) / (GAMMA - 1.0))
    rate = choked * AREA * math.sqrt(GAMMA * CONSTANT * TEMPERATURE) / VOLUME

    def exact(t: FloatArray | float) -> Any:
        past = 1.0 + 0.5 * (GAMMA - 1.0) * rate * np.asarray(t)
        return first * past ** (-2.0 * GAMMA / (GAMMA - 1.0))

    def error(step: float) -> float:
        run = _blown_down(PRESSURE, end, step)
        return abs(float(run["air.pressure"][-1]) / float(exact(end)) - 1.0)

    history = _blown_down(PRESSURE, end, 5e-4)
    t, pressure = history["time"], history["air.pressure"]
    checks = (
        zero("pressure over time", np.abs(pressure / exact(t) - 1.0).max(), FLOW_TOL),
        relative("temperature", history["air.temperature"][-1],
                 TEMPERATURE * (exact(end) / first) ** (1.0 - 1.0 / GAMMA), FLOW_TOL),
    )  # fmt: skip
    draw = comparison(("t", "p"), [("formula", t, exact(t))], [("run", t, pressure)])
    return Answer(checks, draw, order_of("pressure at the end", 8e-3, error))


@CASES.add(
    "gas-subsonic",
    "A vent slower than sound",
    "V dm/dt = −C A p √(2γ/((γ−1) R T) (π^(2/γ) − π^((γ+1)/γ))), T = T₀ (p/p₀)^((γ−1)/γ)",
    "60 litres of air at 1.8 atm flow out by 4 cm² to 1 atm: against the formula's flow integrated "
    "to ten digits.",
)
def _subsonic() -> Answer:
    end, first = 0.08, 1.8 * PRESSURE
    full = _chamber("air", AROUND._replace(pressure=first), vents=[Vent(AREA, to="room")])
    boxes = {"air": (full, VOLUME), "room": (_chamber("room"), 1e9)}
    power = (GAMMA - 1.0) / GAMMA

    def slope(_: float, p: FloatArray) -> FloatArray:
        ratio = PRESSURE / p
        swing = ratio ** (2.0 / GAMMA) - ratio ** ((GAMMA + 1.0) / GAMMA)
        hot = TEMPERATURE * (p / first) ** power
        flow = AREA * p * np.sqrt(2.0 * GAMMA / ((GAMMA - 1.0) * CONSTANT * hot) * swing)
        return -GAMMA * CONSTANT * hot * flow / VOLUME

    reference = solve_ivp(slope, (0.0, end), [first], rtol=1e-11, atol=1e-6, dense_output=True)

    def error(step: float) -> float:
        run = _run(boxes, end, step)
        return abs(float(run["air.pressure"][-1] / reference.y[0, -1]) - 1.0)

    history = _run(boxes, end, 1e-4)
    t, pressure = history["time"], history["air.pressure"]
    exact = reference.sol(t)[0]
    checks = (
        zero("pressure over time", np.abs(pressure / exact - 1.0).max(), FLOW_TOL),
        relative("temperature", history["air.temperature"][-1],
                 TEMPERATURE * (exact[-1] / first) ** power, FLOW_TOL),
    )  # fmt: skip
    draw = comparison(("t", "p"), [("formula", t, exact)], [("run", t, pressure)])
    return Answer(checks, draw, order_of("pressure at the end", 4e-3, error))


@CASES.add(
    "gas-blow-down",
    "Blown up, then out to the surroundings",
    "p₁ = p₀ + γ R T_in ṁ t/V; as fast as sound to p = p_a ((γ+1)/2)^(γ/(γ−1)), slower after it",
    "0.8 kg/s of air at 700 K blow into 60 litres for 50 ms, then a vent of 4 cm² opens: the same "
    "as fabric that leaks, of so much area in all.",
)
def _blow_down() -> Answer:
    rate, hot, blown, end = 0.8, 700.0, 0.05, 0.25
    power, around = (GAMMA - 1.0) / GAMMA, 2.0 + 4.0 * VOLUME
    blow = Inflator([[0.0, rate], [blown, rate]], hot)
    vent = Vent(AREA, opens_after=blown)
    history = _run({"air": (_chamber(inflators=[blow], vents=[vent]), VOLUME)}, end, 1e-4)
    t, pressure, mass = (history[name] for name in ("time", "air.pressure", "air.mass"))
    full = PRESSURE + GAMMA * CONSTANT * hot * rate * blown / VOLUME
    masses = PRESSURE * VOLUME / (CONSTANT * TEMPERATURE) + rate * blown
    warm = full * VOLUME / (CONSTANT * masses)
    choked = (2.0 / (GAMMA + 1.0)) ** (0.5 * (GAMMA + 1.0) / (GAMMA - 1.0))
    pace = 0.5 * (GAMMA - 1.0) * choked * AREA * math.sqrt(GAMMA * CONSTANT * warm) / VOLUME
    slower = PRESSURE * (0.5 * (GAMMA + 1.0)) ** (1.0 / power)
    subsonic_start = blown + ((slower / full) ** (-0.5 * power) - 1.0) / pace

    def slope(_: float, p: FloatArray) -> FloatArray:
        swing = (PRESSURE / p) ** (2.0 / GAMMA) - (PRESSURE / p) ** ((GAMMA + 1.0) / GAMMA)
        now = warm * (p / full) ** power
        flow = AREA * p * np.sqrt(2.0 * GAMMA / ((GAMMA - 1.0) * CONSTANT * now) * swing)
        return -GAMMA * CONSTANT * now * flow / VOLUME

    late = solve_ivp(
        slope, (subsonic_start, end), [slower], rtol=1e-11, atol=1e-6, dense_output=True
    )
    exact = PRESSURE + (full - PRESSURE) * np.minimum(t / blown, 1.0)
    fast, slow = (t > blown) & (t <= subsonic_start), t > subsonic_start
    exact[fast] = full * (1.0 + pace * (t[fast] - blown)) ** (-2.0 / power)
    exact[slow] = late.sol(t[slow])[0]
    remaining_mass = masses * (exact[-1] / full) ** (1.0 / GAMMA)
    enthalpy_in, enthalpy_out = history["air.flow_in"], history["air.flow_out"]
    inside = (pressure[-1] - PRESSURE) * VOLUME / (GAMMA - 1.0)
    by_fabric, by_vent = (
        _run({"air": (_chamber(inflators=[blow], **opening), VOLUME)}, blown, 1e-4)
        for opening in ({"leak": AREA / around}, {"vents": [Vent(AREA)]})
    )
    checks = (
        zero("pressure over time", np.abs(pressure / exact - 1.0).max(), FLOW_TOL),
        relative("mass at the end", mass[-1], remaining_mass, FLOW_TOL),
        zero("energy, by what came",
             (enthalpy_in[-1] - enthalpy_out[-1] - inside) / enthalpy_in[-1], EXACT),
        relative("pressure of fabric that leaks", by_fabric["air.pressure"][-1],
                 by_vent["air.pressure"][-1], EXACT),
    )  # fmt: skip
    return Answer(checks, comparison(("t", "p"), [("formula", t, exact)], [("run", t, pressure)]))


@CASES.add(
    "gas-two-chambers",
    "Two chambers come to one pressure",
    "p = (p₁V₁ + p₂V₂)/(V₁ + V₂), T₁ = T₀ (p/p₁)^((γ−1)/γ)",
    "60 litres of air at 3 atm and 40 litres at 1 atm, both of 293.15 K, with a vent of 4 cm² "
    "between them. What stays in the first expands by itself; the second mixes.",
)
def _two() -> Answer:
    first = 3.0 * PRESSURE
    full = _chamber("air", AROUND._replace(pressure=first), vents=[Vent(AREA, to="room")])
    boxes = {"air": (full, VOLUME), "room": (_chamber("room"), COMPRESSED_VOLUME)}
    common = (first * VOLUME + PRESSURE * COMPRESSED_VOLUME) / (VOLUME + COMPRESSED_VOLUME)
    power = (GAMMA - 1.0) / GAMMA
    cooled = TEMPERATURE * (common / first) ** power
    masses = (first * VOLUME + PRESSURE * COMPRESSED_VOLUME) / (CONSTANT * TEMPERATURE)
    remaining_mass = common * VOLUME / (CONSTANT * cooled)
    history = _run(boxes, 0.3, 1e-4)
    t = history["time"]
    mass = history["air.mass"] + history["room.mass"]
    energy = history["air.pressure"] * VOLUME + history["room.pressure"] * COMPRESSED_VOLUME
    lines = [(f"p of {name}", t, history[f"{name}.pressure"]) for name in ("air", "room")]
    checks = (
        relative("pressure of the first", history["air.pressure"][-1], common, FLOW_TOL),
        relative("pressure of the second", history["room.pressure"][-1], common, FLOW_TOL),
        relative("temperature of the first", history["air.temperature"][-1], cooled, FLOW_TOL),
        relative("temperature of the second", history["room.temperature"][-1],
                 common * COMPRESSED_VOLUME / (CONSTANT * (masses - remaining_mass)), FLOW_TOL),
        zero("mass, by that of all", np.abs(mass / mass[0] - 1.0).max(), EXACT),
        zero("energy, by that of all", np.abs(energy / energy[0] - 1.0).max(), EXACT),
    )  # fmt: skip
    return Answer(checks, comparison(("t", "p"), [("formula", t, np.full(len(t), common))], lines))
