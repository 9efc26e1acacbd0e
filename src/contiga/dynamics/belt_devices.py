"""Devices at the end of a belt: retractor, load limiter, pretensioner and end release.

A segment of webbing and the devices at its end carry one tension T. With ℓ₀ the length at rest, p
the length that the devices have paid out (less the length pulled in) and r the length that slip
rings have fed in:

    x = ℓ − ℓ₀ − p − r,    T = F(x),    T = 0 where x < 0

- An unlocked retractor pays out and reels in by its spring: T = S(p).
- Locked, it pays out only under load. Film spool and load limiter pay out, but do not reel in:
  T ≤ L(q). Where the webbing alone would carry more, their travel q grows until T = L(q). The
  webbing unloads by its own curve. In series their travels add up: L⁻¹ is the sum of both inverse
  functions. The film of a spool starts at the tension at which the spool locks.
- A pretensioner pulls in u(t), or until T reaches its force P(t); it never pays out. P is at most
  L(q), as the limiter yields first. A pretensioner locks the retractor.
- A released end carries no tension.

Work: film and limiter dissipate ∫ L dq, exactly; the spring of the spool stores ∫ S dp; the work of
a pretensioner comes from outside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.curves.curve_records import CurvePoint, Curves, Response, piecewise
from contiga.curves.kernels import curve_nb
from contiga.curves.tables import check_never_falls, table_of
from contiga.dynamics.spring_law import SLACK, SpringLaw
from contiga.errors import InputError
from contiga.records import FloatArray

_N_NEWTON = 60
"""Number of Newton steps after which the bracket is only halved."""
_MAX_ITERATIONS = 300
_ROOT_TOL = 4.0 * float(np.finfo(np.float64).eps)


class Moment(NamedTuple):
    """The end of a step of a segment."""

    time: float = 0.0
    dt: float = 0.0
    """Length of the step; 0 at the start."""
    fired: Mapping[str, float] = {}
    """Time at which the trigger of each sensor fires; infinite or missing if it does not."""

    def since(self, trigger: str | None) -> float:
        """Return the time since a trigger fired, negative before; −∞ if it does not fire."""
        return -math.inf if trigger is None else self.time - self.fired.get(trigger, math.inf)


class DeviceState(NamedTuple):
    """State of the devices of a segment."""

    paid_out: float = 0.0
    """Length that they have paid out since the start, less the length pulled in."""
    fed: float = 0.0
    """Length that slip rings have fed into the segment, less the length fed out of it."""
    travel: float = 0.0
    """Travel of film and limiter under load, including the film's up to the locking tension."""
    pulled_in: float = 0.0
    """Length that the pretensioner has pulled in."""
    spool: float = 0.0
    """Energy in the spring of the retractor since the start."""
    work: float = 0.0
    """Work of the pretensioner since the start."""
    locked: float = math.inf
    """Time at which the retractor locked; infinite before."""
    released: float = math.inf
    """Time at which the end was released; infinite before."""


class SegmentStep(NamedTuple):
    """Result of a step of a segment."""

    axial: Response
    """Tension, stiffness and energies; `lost` includes the work of film and limiter."""
    state: DeviceState


@dataclass(frozen=True, init=False, eq=False)
class Retractor:
    """A spool that pays out and reels in by its spring until it locks, irreversibly.

    Parameters
    ----------
    spool : force of its spring, a number, or rows of length paid out and force, constant beyond
        both ends
    trigger : name of the sensor whose trigger locks it (the acceleration of the vehicle)
    rate : speed of pay-out above which it locks, > 0; it locks at the end of the step in which the
        speed is above it
    film : rows of length and force, from 0: length that the tightening spool pays out once it is
        locked, at most that of the last row

    Raises
    ------
    InputError
        Rows whose force falls, a film that does not start at length 0 or whose force does not
        rise, a rate that is not above zero, neither trigger nor rate.

    Examples
    --------
    >>> Retractor(spool=5.0, rate=1.5, film=[[0, 0], [30, 2000], [60, 8000]]).rate
    1.5
    """

    spool: FloatArray
    trigger: str | None
    rate: float | None
    film: FloatArray | None

    def __init__(
        self,
        spool: ArrayLike = 0.0,
        *,
        trigger: str | None = None,
        rate: float | None = None,
        film: ArrayLike | None = None,
    ) -> None:
        if trigger is None and rate is None:
            raise InputError(
                "a retractor that never locks holds nobody",
                where="lock",
                found="neither",
                allowed="a trigger, a rate of pay-out, or both",
            )
        rows = np.array([[0.0, spool]]) if np.ndim(spool) == 0 else spool
        put = object.__setattr__
        put(self, "spool", _monotone_rows("spool", rows, ("paid out", "force")))
        put(self, "trigger", trigger)
        put(self, "rate", None if rate is None else positive(rate, "rate"))
        if film is not None:
            film = _monotone_rows("film", film, ("paid out", "force"))
            if film[0, 0] != 0.0 or not (np.diff(film[:, 1]) > 0.0).all():
                raise InputError(
                    "what a film lets out is a function of the force, from 0 on",
                    where="film",
                    found=film.tolist(),
                    allowed="rows [paid out, force] from 0, both strictly increasing",
                )
        put(self, "film", film)

    def unlocked(self) -> Retractor:
        """Return a copy that does not lock."""
        unlocked = copy(self)
        object.__setattr__(unlocked, "trigger", None)
        object.__setattr__(unlocked, "rate", None)
        return unlocked


@dataclass(frozen=True, init=False, eq=False)
class LoadLimiter:
    """A torsion bar or the like, which pays out under load, at a force that depends on its travel.

    Parameters
    ----------
    force : a number, or one for each travel, never falling; linear between, constant beyond the
        last
    travel : lengths, from 0, strictly increasing

    Raises
    ------
    InputError
        A force that is not above zero or falls, travels that do not start at 0 or rise.

    Examples
    --------
    >>> LoadLimiter([3000, 3000, 5000], travel=[0, 100, 120]).force.tolist()
    [3000.0, 3000.0, 5000.0]
    """

    force: FloatArray
    travel: FloatArray

    def __init__(self, force: ArrayLike, travel: ArrayLike | None = None) -> None:
        forces = np.atleast_1d(np.asarray(force, dtype=np.float64))
        travels = np.zeros(1) if travel is None else np.atleast_1d(np.asarray(travel, np.float64))
        if forces.ndim != 1 or forces.shape != travels.shape:
            raise InputError(
                "needs a travel for each force",
                where="travel",
                found=travels.shape,
                allowed=f"{forces.shape}",
            )
        rows = _monotone_rows("force", np.column_stack([travels, forces]), ("travel", "force"))
        if rows[0, 0] != 0.0:
            raise InputError("must start at 0", where="travel", found=float(rows[0, 0]))
        positive(float(forces[0]), "force")
        object.__setattr__(self, "force", rows[:, 1])
        object.__setattr__(self, "travel", rows[:, 0])


@dataclass(frozen=True, init=False, eq=False)
class Pretensioner:
    """A pretensioner, which pulls in webbing once a trigger has fired.

    Parameters
    ----------
    trigger : name of the sensor whose trigger fires it
    pull : rows of the time since firing and the length pulled in, never falling; or
    force : rows of that time and the pulling force, zero before and after them
    stroke : largest length that a force pulls in

    Raises
    ------
    InputError
        Both or neither of pull and force, a length that falls, a negative force, a stroke with a
        pull.

    Examples
    --------
    >>> Pretensioner("crash", pull=[[0, 0], [5, 80]]).pull.tolist()
    [[0.0, 0.0], [5.0, 80.0]]
    """

    trigger: str
    pull: FloatArray | None
    force: FloatArray | None
    stroke: float

    def __init__(
        self,
        trigger: str,
        *,
        pull: ArrayLike | None = None,
        force: ArrayLike | None = None,
        stroke: float | None = None,
    ) -> None:
        if (pull is None) == (force is None):
            raise InputError("must be given one of pull and force", where="pull")
        if pull is not None and stroke is not None:
            raise InputError(
                "is that of a force: a pull says how far it goes", where="stroke", found=stroke
            )
        put = object.__setattr__
        put(self, "trigger", trigger)
        put(self, "pull", None if pull is None else _monotone_rows("pull", pull, ("t", "length")))
        rows = None if force is None else table_of(force, ("t", "force"), where="force")
        if rows is not None and not (rows[:, 1] >= 0.0).all():
            raise InputError("must not be negative", where="force", found=rows.tolist())
        put(self, "force", rows)
        put(self, "stroke", math.inf if stroke is None else positive(stroke, "stroke"))

    @property
    def kinks(self) -> FloatArray:
        """Times (k,) since firing at which its pull or force has kinks."""
        rows = self.force if self.pull is None else self.pull
        assert rows is not None
        return np.asarray(rows[:, 0])

    def length_at(self, since: float) -> float:
        """Return the length that its pull prescribes at a time since firing.

        It is 0 before, and the last one after the last row; 0 for a pretensioner with a force.
        """
        if self.pull is None or since < 0.0:
            return 0.0
        return float(np.interp(since, self.pull[:, 0], self.pull[:, 1]))

    def force_at(self, since: float) -> float:
        """Return its pulling force at a time since firing; 0 outside its rows, or without them."""
        if self.force is None or not self.force[0, 0] <= since <= self.force[-1, 0]:
            return 0.0
        return float(np.interp(since, self.force[:, 0], self.force[:, 1]))


class Devices(NamedTuple):
    """Devices at the end of a segment; None for each that is not there."""

    retractor: Retractor | None = None
    limiter: LoadLimiter | None = None
    pretensioner: Pretensioner | None = None
    release: str | None = None
    """Name of the sensor whose trigger releases the end."""

    @property
    def triggers(self) -> dict[str, str]:
        """Names of the sensors that the devices wait for, by device."""
        retractor = None if self.retractor is None else self.retractor.trigger
        pretensioner = None if self.pretensioner is None else self.pretensioner.trigger
        sensors = {"retractor": retractor, "pretensioner": pretensioner, "release": self.release}
        return {device: name for device, name in sensors.items() if name is not None}


class Webbing:
    """The law of webbing with the devices at its end."""

    def __init__(self, webbing: SpringLaw, devices: Devices) -> None:
        self._webbing = webbing
        self._devices = devices
        self._slider = _slider(devices)
        self._spool = None if devices.retractor is None else _curve(devices.retractor.spool)

    def max_slope(self, x: float) -> float:
        """Return an upper bound of dT/dx, ≥ 0: that of the webbing without devices."""
        return self._webbing.max_slope(max(x, 0.0))

    def move(
        self,
        old: tuple[float, float],
        last: DeviceState,
        reach: float,
        fed: float,
        moment: Moment,
    ) -> SegmentStep:
        """Return the response of webbing and devices at the end of a step, and their new state.

        A released end is slack for good. An unlocked retractor follows its spool; it locks at the
        first trigger of its own or of the pretensioner, or by its rate at the end of a step.

        Parameters
        ----------
        old : elongation and tension before the step
        last : state of the devices before the step
        reach : ℓ − ℓ₀ at the end of the step
        fed : r, the length that slip rings have fed in, at the end of the step
        moment : time and length of the step, and fired triggers
        """
        last = last._replace(fed=fed)
        retractor, _, pretensioner, release = self._devices
        if moment.since(release) >= 0.0:
            released = min(last.released, moment.fired[release or ""])
            return SegmentStep(SLACK, last._replace(released=released, spool=0.0))
        if retractor is not None and math.isinf(last.locked):
            triggers = [retractor.trigger, None if pretensioner is None else pretensioner.trigger]
            since = max(moment.since(trigger) for trigger in triggers)
            if since < 0.0:
                return self._step_unlocked(old, last, reach - fed, moment)
            last = self._lock(last, old[1], moment.time - since)
        return self._step_locked(old, last, reach - fed, moment)

    def _lock(self, last: DeviceState, tension: float, time: float) -> DeviceState:
        """Return the devices with the retractor locked, the film tightened up to a tension."""
        travel = 0.0 if self._slider is None else self._slider.travel(tension)
        return last._replace(locked=time, travel=travel)

    def _webbing_at(self, old: tuple[float, float], x: float) -> Response:
        """Return the response of the webbing to a step from `old` to an elongation; slack below 0.

        `old` has elongation and tension.
        """
        return self._webbing.move(*old, x) if x >= 0.0 else SLACK

    def _step_unlocked(
        self, old: tuple[float, float], last: DeviceState, reach: float, moment: Moment
    ) -> SegmentStep:
        """Return the step in which webbing and spool carry the same force.

        `reach` is ℓ − ℓ₀ less the length fed in. The retractor locks, from the next step on, if the
        spool paid out faster than its rate.
        """
        spool, retractor = self._spool, self._devices.retractor
        assert spool is not None
        assert retractor is not None

        def excess(x: float) -> tuple[float, float]:
            """Return the spool's force less the tension at an elongation, and the slope."""
            webbing, point = self._webbing_at(old, x), _point(spool, reach - x)
            return point.value - webbing.force, -point.slope - webbing.stiffness

        x = root(excess, 0.0, max(old[0], 1e-3 * abs(reach), _ROOT_TOL))
        webbing, (force, slope, stored) = self._webbing_at(old, x), _point(spool, reach - x)
        state = last._replace(paid_out=reach - x, spool=stored)
        paid_out = state.paid_out - last.paid_out
        if retractor.rate is not None and moment.dt > 0.0 and paid_out > retractor.rate * moment.dt:
            state = self._lock(state, force, moment.time)
        stiffness = _in_series(webbing.stiffness, slope)
        return SegmentStep(Response(force, stiffness, webbing.stored, webbing.lost), state)

    def _step_locked(
        self, old: tuple[float, float], last: DeviceState, reach: float, moment: Moment
    ) -> SegmentStep:
        """Return the step in which the pretensioner pulls in, or film and limiter pay out.

        The pretensioner pulls in its length, or until the tension is the smaller of its force and
        the yield force; film and limiter pay out until it is the yield force. Both stop at the end
        of their strokes. The work of film and limiter is added to the losses of the webbing.
        `reach` is ℓ − ℓ₀ less the length fed in.
        """
        pretensioner, slider = self._devices.pretensioner, self._slider
        pulled_in, pull_force = last.pulled_in, 0.0
        if pretensioner is not None:
            since = moment.since(pretensioner.trigger)
            pulled_in = max(pulled_in, pretensioner.length_at(since))
            pull_force = pretensioner.force_at(since)
        paid_out = last.paid_out - (pulled_in - last.pulled_in)
        x = reach - paid_out
        webbing = self._webbing_at(old, x)
        force, stiffness, travel, lost = webbing.force, webbing.stiffness, last.travel, 0.0
        yield_force = math.inf if slider is None else _point(slider.curve, travel).value
        target = min(pull_force, yield_force)
        if force < target:

            def shortage(pull: float) -> tuple[float, float]:
                """Return the tension missing once `pull` is pulled in, and the slope."""
                response = self._webbing_at(old, x + pull)
                return target - response.force, -response.stiffness

            stroke = pretensioner.stroke - pulled_in if pretensioner else 0.0
            at_end = math.isfinite(stroke) and shortage(stroke)[0] > 0.0
            pull = stroke if at_end else root(shortage, 0.0, max(1e-3 * abs(x), _ROOT_TOL))
            pulled_in, paid_out = pulled_in + pull, paid_out - pull
            webbing = self._webbing_at(old, x + pull)
            force = webbing.force if at_end else target
            stiffness = webbing.stiffness if at_end else 0.0
        elif force > yield_force:
            assert slider is not None

            def overload(slip: float) -> tuple[float, float]:
                """Return the tension above the yield force after a slip, and the slope."""
                response = self._webbing_at(old, x - slip)
                limit = _point(slider.curve, travel + slip)
                return response.force - limit.value, -response.stiffness - limit.slope

            stroke = slider.end - travel
            at_end = math.isfinite(stroke) and overload(stroke)[0] > 0.0
            slip = stroke if at_end else root(overload, 0.0, max(x, _ROOT_TOL))
            webbing, limit = self._webbing_at(old, x - slip), _point(slider.curve, travel + slip)
            lost = limit.integral - _point(slider.curve, travel).integral
            travel, paid_out = travel + slip, paid_out + slip
            force, stiffness = limit.value, _in_series(webbing.stiffness, limit.slope)
            if at_end:
                force, stiffness = webbing.force, webbing.stiffness
        work = last.work + 0.5 * (old[1] + force) * (pulled_in - last.pulled_in)
        state = last._replace(paid_out=paid_out, travel=travel, pulled_in=pulled_in, work=work)
        response = Response(force, stiffness, webbing.stored, webbing.lost + lost)
        return SegmentStep(response, state)


class _Slider(NamedTuple):
    """Film and limiter in series: the yield force over their travel."""

    curve: Curves
    """Yield force over the travel of both."""
    end: float
    """Travel at which they stop."""

    def travel(self, tension: float) -> float:
        """Return the least travel at which they hold a tension; 0 without one.

        Above their highest force it is the travel at the last kink.
        """
        return float(np.interp(tension, self.curve.y, self.curve.x)) if tension > 0.0 else 0.0


def _slider(devices: Devices) -> _Slider | None:
    """Return film and limiter in series; None if there is neither.

    A film alone stops at its last row; a limiter pays out without end.
    """
    film = None if devices.retractor is None else devices.retractor.film
    limiter = devices.limiter
    if limiter is None:
        return None if film is None else _Slider(_curve(film), float(film[-1, 0]))
    travels, forces = limiter.travel, limiter.force
    # The film does nothing if it starts to yield at the limiter's highest force or above.
    if film is None or (film[0, 1] > 0.0 and film[0, 1] >= forces[-1]):
        rows = np.column_stack([travels, forces])
    else:
        # Their travels add up at each force at which one of them has a kink.
        film_forces = film[(film[:, 1] < forces[-1]) & ~np.isin(film[:, 1], forces), 1]
        levels = np.concatenate([forces, film_forces])
        of_limiter = np.concatenate([travels, np.interp(film_forces, forces, travels)])
        rows = np.column_stack([of_limiter + np.interp(levels, film[:, 1], film[:, 0]), levels])
    if film is not None:
        rows = np.unique(rows, axis=0)
        # Of several forces at travel 0 the highest counts: lower ones cause no travel.
        at_zero = np.flatnonzero(rows[:, 0] == 0.0)
        rows = rows[at_zero[-1] if len(at_zero) else 0 :]
    return _Slider(_curve(rows), math.inf)


def _in_series(first: float, second: float) -> float:
    """Return the stiffness of two springs in series; 0 if their sum is not positive."""
    total = first + second
    return first * second / total if total > 0.0 else 0.0


def _curve(rows: FloatArray) -> Curves:
    """Return the curve through rows (n, 2), constant beyond its ends, with a point at x = 0."""
    x = np.union1d(rows[:, 0], 0.0)
    return piecewise(x, np.interp(x, rows[:, 0], rows[:, 1]), 0.0, 0.0)


def _point(curve: Curves, x: float) -> CurvePoint:
    """Return value, slope and integral of a curve at x."""
    return CurvePoint(*curve_nb.point(curve, 0, x))


def root(falling: Callable[[float], tuple[float, float]], low: float, width: float) -> float:
    """Find the zero of a function that never rises, at `low` or above; `low` if it is ≤ 0 there.

    Newton's method within a bracket, which is exact for piecewise linear functions; ends at a
    relative change of a few rounding errors. A function that stays positive is followed upwards by
    doubling, and the last point returned: nothing is raised.

    Parameters
    ----------
    low : lower end of the search
    falling : returns value and slope
    width : estimate of the distance of the zero from `low`, > 0
    """
    value, slope = falling(low)
    if not value > 0.0:
        return low
    high = low + width
    for _ in range(_MAX_ITERATIONS):
        if not falling(high)[0] > 0.0:
            break
        width *= 2.0
        high = low + width
    x = low
    for k in range(_MAX_ITERATIONS):
        new_x = x - value / slope if slope < 0.0 and k < _N_NEWTON else low
        if not low < new_x <= high:
            new_x = 0.5 * (low + high)
        if abs(new_x - x) <= _ROOT_TOL * abs(new_x):
            return new_x
        x = new_x
        value, slope = falling(x)
        if value == 0.0:
            return x
        low, high = (x, high) if value > 0.0 else (low, x)
    return x


def _monotone_rows(where: str, rows: object, columns: tuple[str, str]) -> FloatArray:
    """Return rows (n, 2) whose second column never falls, checked.

    Raises
    ------
    InputError
        No such rows.
    """
    table = table_of(rows, columns, where=where)
    check_never_falls(table, columns, where)
    return table
