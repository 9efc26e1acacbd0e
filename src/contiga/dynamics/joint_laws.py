"""Laws of joints: moment over angle, or force over travel, with stops, damping and friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import not_negative, positive, real
from contiga.curves.characteristic import Characteristic, CurveLike, as_curve
from contiga.curves.curve_records import Response
from contiga.curves.hysteresis import Hysteresis, hysteresis_of
from contiga.dynamics.spring_law import SLACK, SpringLaw
from contiga.errors import InputError


class JointLawState(NamedTuple):
    """State of a law at one time. Forces are moments where the coordinate is an angle."""

    value: float
    """Coordinate: radians, or length."""
    force: float
    """Total force that opposes the coordinate: curve, stops, friction and damper."""
    memory: float
    """Force of the curve, from which hysteresis continues."""
    stuck: float
    """Force of friction."""
    damper: float
    """Force of the damper."""
    stored: float
    """Energy stored in the curve, the stops and sticking friction."""
    hysteresis: float
    """Energy lost by the curve since the start."""
    damping: float
    """Energy lost by the damper since the start."""
    friction: float
    """Energy lost by friction since the start."""


_AT_REST = JointLawState(*(0.0 for _ in JointLawState._fields))
"""State of a law at the coordinate 0, without force."""


@dataclass(frozen=True, init=False, eq=False)
class JointLaw:
    """A law of one coordinate of a joint: an angle in radians, or a travel.

    Parameters
    ----------
    curve : moment (or force) over the coordinate: a number is a stiffness for both signs, a table
        has rows (coordinate, moment)
    unloading, hysteresis_slope : unloading curve and slope of a `Spring`; the curves are then
        symmetric, over the absolute value of the coordinate
    damping : moment over rate, ≥ 0
    friction : moment at which the joint slides, ≥ 0
    friction_slope : stiffness of sticking, moment over coordinate, > 0
    stops : (low, high) values of the coordinate beyond which the stops push back
    stop_curve : moment of a stop over its depth, the coordinate beyond the stop: a stiffness or a
        table
    start : coordinate at the start

    Notes
    -----
    The force is F(x) + c x' + stop + friction. Friction sticks elastically up to its limit, like a
    spring in series with a slider, so its work is stored or lost exactly. The energy of the damper
    is integrated by the trapezoidal rule, as for springs.

    Raises
    ------
    InputError
        A part without the other that it needs, stops that do not rise, a start beyond them,
        curves that break the rules of `Characteristic` and `Hysteresis`.

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
                "is missing: an unloading curve or slope needs a loading curve", where="curve"
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
        slope = 0.0 if friction_slope is None else positive(friction_slope, "friction_slope")
        put(self, "friction_slope", slope)
        low, high = -math.inf, math.inf
        if stops is not None:
            limits = np.asarray(real(stops, "stops"), np.float64)
            is_pair = limits.shape == (2,) and bool(np.isfinite(limits).all())
            if not is_pair or not limits[0] < limits[1]:
                raise InputError(
                    "must be two numbers that rise",
                    where="stops",
                    found=stops,
                    allowed="(low, high)",
                )
            low, high = limits.tolist()
        put(self, "stops", (low, high))
        stop = None if stop_curve is None else as_curve(stop_curve, "stop_curve")
        put(self, "stop_curve", stop)
        begin = float(real(start, "start"))
        put(self, "start", begin)
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
        """Return the state at the start, at a coordinate and its rate.

        The curve is loaded from zero up to there; friction is without force, and no energy lost.
        """
        state = self.step(_AT_REST, value, rate)
        return self.begun(
            state._replace(  # friction sticks where it starts
                force=state.force - state.stuck,
                stuck=0.0,
                stored=state.stored - self._sticking_energy(state.stuck),
            )
        )

    @staticmethod
    def begun(state: JointLawState) -> JointLawState:
        """Return a state with its energy losses set to zero."""
        return state._replace(hysteresis=0.0, damping=0.0, friction=0.0)

    def step(self, last: JointLawState, value: float, rate: float) -> JointLawState:
        """Return the state after a step from `last` to a coordinate `value`, at `rate`.

        Its force is the sum of curve, stops, friction and damper. Losses are summed up since the
        start.
        """
        change = value - last.value
        curve, stop = self._curve_response(last, value), self._stop_response(value)
        trial = last.stuck + self.friction_slope * change
        stuck = min(max(trial, -self.friction), self.friction)
        slip = abs(trial - stuck) / self.friction_slope if self.friction_slope else 0.0
        damper = self.damping * rate
        return JointLawState(
            value=value,
            force=curve.force + stop.force + stuck + damper,
            memory=curve.force,
            stuck=stuck,
            damper=damper,
            stored=curve.stored + stop.stored + self._sticking_energy(stuck),
            hysteresis=last.hysteresis + curve.lost,
            damping=last.damping + 0.5 * (last.damper + damper) * change,
            friction=last.friction + abs(stuck) * slip,
        )

    def stiffness_bound(self, value: float) -> float:
        """Return an upper bound of the slope dF/dx in a step from `value`, ≥ 0, without damping."""
        bound = self.friction_slope
        if self._law is not None:
            bound += self._law.max_slope(value if self.hysteresis is None else abs(value))
        if self._stop_law is not None:
            bound += self._stop_law.max_slope(self._stop_depth(value))
        return bound

    @cached_property
    def _law(self) -> SpringLaw | None:
        return None if self.curve is None else SpringLaw(self.curve, self.hysteresis)

    @cached_property
    def _stop_law(self) -> SpringLaw | None:
        return None if self.stop_curve is None else SpringLaw(self.stop_curve, None)

    def _curve_response(self, last: JointLawState, value: float) -> Response:
        """Return force and energies of the curve in a step from `last`; slack without a curve.

        Hysteresis loads each sign of the coordinate from zero.
        """
        if self._law is None:
            return SLACK
        if self.hysteresis is None:
            return self._law.move(last.value, last.memory, value)
        sign = math.copysign(1.0, value)
        response = self._law.move(sign * last.value, max(sign * last.memory, 0.0), abs(value))
        return response._replace(force=sign * response.force)

    def _stop_depth(self, value: float) -> float:
        """Return the depth beyond a stop, ≥ 0."""
        return max(self.stops[0] - value, value - self.stops[1], 0.0)

    def _stop_response(self, value: float) -> Response:
        """Return force and energies of the stops, elastic; slack between them."""
        depth = self._stop_depth(value)
        if self._stop_law is None or depth == 0.0:
            return SLACK
        response = self._stop_law.move(0.0, 0.0, depth)
        return response._replace(force=math.copysign(response.force, value - self.stops[0]))

    def _sticking_energy(self, stuck: float) -> float:
        """Return the energy stored by friction that sticks with a force."""
        return 0.5 * stuck * stuck / self.friction_slope if self.friction_slope else 0.0


def _check_pair(first: str, value_1: object, second: str, value_2: object) -> None:
    """Refuse one of two options, by their names and values, without the other."""
    if (value_1 is None) != (value_2 is None):
        missing, useless = (first, second) if value_1 is None else (second, first)
        raise InputError(f"is missing: {useless} has no effect without it", where=missing)
