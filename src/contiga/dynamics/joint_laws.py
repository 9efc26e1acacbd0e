"""Laws of joints: moment over an angle, or force over a travel, with stops and friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import real
from contiga.dynamics.spring_curves import Axial, SpringLaw, spring_law
from contiga.errors import InputError
from contiga.laws.characteristic import Characteristic, CurveLike
from contiga.laws.hysteresis import Hysteresis, hysteresis_of
from contiga.laws.law import above_zero, as_curve, not_negative


class JointLawState(NamedTuple):
    """What a law of a joint has come to. Energies but `stored` add up since the start."""

    value: float
    """Of the coordinate: radians, or length."""
    force: float
    """Moment or force that works against the coordinate, all parts together."""
    memory: float
    """Part of the curve, from which hysteresis goes on."""
    stuck: float
    """Part of friction."""
    damper: float
    """Part of the damper."""
    stored: float
    """Energy of curve, stops and sticking friction."""
    hysteresis: float
    damping: float
    friction: float


@dataclass(frozen=True, init=False, eq=False)
class JointLaw:
    """A law of one coordinate of a joint: an angle in radians, or a travel.

    Parameters
    ----------
    curve : moment (or force) against the coordinate: a number is a stiffness for both signs, a
        table is moment over coordinate
    unloading, hysteresis_slope : as of a `Spring`; the curves are then for both senses alike, over
        the size of the coordinate
    damping : moment by the rate, ≥ 0
    friction : moment that the joint slides at, ≥ 0
    friction_slope : stiffness with which it sticks, moment over coordinate
    stops : (low, high) values beyond which the stops push back
    stop_curve : moment of a stop over how far it is passed
    start : value of the coordinate at the start

    Notes
    -----
    The force is F(x) + c x' + stop + friction. Friction sticks elastically up to its limit, as
    springs in series with sliders do: its work is stored or lost exactly. The damper's energy is
    counted by the trapezoidal rule, as of springs.

    Raises
    ------
    InputError
        Nothing given, a part without the other that it needs, stops that do not rise, a start
        beyond them, curves that break the rules of `Characteristic` and `Hysteresis`.

    Examples
    --------
    >>> knee = JointLaw(stops=(0.0, 2.4), stop_curve=500.0, damping=0.1, start=0.3)
    >>> state = knee.begin(0.3, 0.0)
    >>> round(knee.step(state, 2.5, 1.0).force, 6)
    50.1
    """

    curve: Characteristic | None
    hysteresis: Hysteresis | None
    damping: float
    friction: float
    friction_slope: float
    stops: tuple[float, float]
    stop_curve: Characteristic | None
    start: float

    def __init__(
        self,
        curve: CurveLike | None = None,
        *,
        unloading: CurveLike | None = None,
        hysteresis_slope: float | None = None,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_slope: float | None = None,
        stops: Sequence[float] | None = None,
        stop_curve: CurveLike | None = None,
        start: float = 0.0,
    ) -> None:
        if curve is None and (unloading is not None or hysteresis_slope is not None):
            raise InputError(
                "is missing: a law that unloads has a curve that it loads by", where="curve"
            )
        _check_pair("friction", friction or None, "friction_slope", friction_slope)
        _check_pair("stops", stops, "stop_curve", stop_curve)
        loading = None if curve is None else as_curve(curve, "curve")
        put = object.__setattr__
        put(self, "curve", loading)
        hysteresis = None
        if loading is not None:
            hysteresis = hysteresis_of(loading, unloading, hysteresis_slope)
        put(self, "hysteresis", hysteresis)
        put(self, "damping", not_negative(damping, "damping"))
        put(self, "friction", not_negative(friction, "friction"))
        slope = 0.0 if friction_slope is None else above_zero(friction_slope, "friction_slope")
        put(self, "friction_slope", slope)
        put(self, "stops", (-math.inf, math.inf) if stops is None else _stops(stops))
        stop = None if stop_curve is None else as_curve(stop_curve, "stop_curve")
        put(self, "stop_curve", stop)
        begin = float(real(start, "start"))
        put(self, "start", begin)
        low, high = self.stops
        if not low <= begin <= high:
            raise InputError(
                f"the joint starts {max(low - begin, begin - high):.4g} beyond its stop",
                where="stops",
                found=[low, high],
                allowed=f"stops on both sides of the start, {begin:g}",
                remedy="Give the value that the coordinate starts with as `start`, or move the "
                "stop",
            )

    def begin(self, value: float, rate: float) -> JointLawState:
        """Return the state at the start, with a coordinate and its rate; nothing is lost yet."""
        state = self.step(JointLawState(0.0, *8 * (0.0,)), value, rate)
        return self.begun(
            state._replace(  # friction sticks where it starts
                force=state.force - state.stuck,
                stuck=0.0,
                stored=state.stored - self._sticking(state.stuck),
            )
        )

    @staticmethod
    def begun(state: JointLawState) -> JointLawState:
        """Return a state with nothing lost yet."""
        return state._replace(hysteresis=0.0, damping=0.0, friction=0.0)

    def step(self, last: JointLawState, value: float, rate: float) -> JointLawState:
        """Return the state after a step from `last` to a coordinate `value`, at `rate`."""
        way = value - last.value
        own = self._moved(last, value)
        stop, stored = self._stop(value)
        trial = last.stuck + self.friction_slope * way
        stuck = min(max(trial, -self.friction), self.friction)
        slid = abs(trial - stuck) / self.friction_slope if self.friction_slope else 0.0
        damper = self.damping * rate
        return JointLawState(
            value,
            own.force + stop + stuck + damper,
            own.force,
            stuck,
            damper,
            own.stored + stored + self._sticking(stuck),
            last.hysteresis + own.lost,
            last.damping + 0.5 * (last.damper + damper) * way,
            last.friction + abs(stuck) * slid,
        )

    def stiffness_bound(self, value: float) -> float:
        """Return a bound of the slope that a step from `value` may come upon, ≥ 0."""
        bound = self.friction_slope
        if self._law is not None:
            bound += self._law.max_slope(value if self.hysteresis is None else abs(value))
        if self._stop_law is not None:
            bound += self._stop_law.max_slope(self._beyond(value))
        return bound

    @cached_property
    def _law(self) -> SpringLaw | None:
        return None if self.curve is None else spring_law(self.curve, self.hysteresis)

    @cached_property
    def _stop_law(self) -> SpringLaw | None:
        return None if self.stop_curve is None else spring_law(self.stop_curve, None)

    def _moved(self, last: JointLawState, value: float) -> Axial:
        """The curve's part; with hysteresis either sense is loaded from nothing."""
        if self._law is None:
            return Axial(0.0, 0.0, 0.0, 0.0)
        if self.hysteresis is None:
            return self._law.move(last.value, last.memory, value)
        sense = math.copysign(1.0, value)
        own = self._law.move(sense * last.value, max(sense * last.memory, 0.0), abs(value))
        return own._replace(force=sense * own.force)

    def _beyond(self, value: float) -> float:
        """How far a stop is passed, ≥ 0."""
        return max(self.stops[0] - value, value - self.stops[1], 0.0)

    def _stop(self, value: float) -> tuple[float, float]:
        """Force of the stops and the energy in them."""
        beyond = self._beyond(value)
        if self._stop_law is None or beyond == 0.0:
            return 0.0, 0.0
        pushed = self._stop_law.move(0.0, 0.0, beyond)
        return math.copysign(pushed.force, value - self.stops[0]), pushed.stored

    def _sticking(self, stuck: float) -> float:
        return 0.5 * stuck * stuck / self.friction_slope if self.friction_slope else 0.0


def _check_pair(first: str, one: object, second: str, other: object) -> None:
    """Refuse one of two options that only work together."""
    if (one is None) != (other is None):
        missing, given = (first, second) if one is None else (second, first)
        raise InputError(f"is missing: {given} does nothing without it", where=missing)


def _stops(stops: Sequence[float]) -> tuple[float, float]:
    values = np.asarray(real(stops, "stops"), np.float64)
    if values.shape != (2,) or not np.isfinite(values).all() or not values[0] < values[1]:
        raise InputError(
            "must be two numbers that rise", where="stops", found=stops, allowed="(low, high)"
        )
    return float(values[0]), float(values[1])
