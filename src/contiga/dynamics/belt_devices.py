"""Devices at the end of a belt: retractor, load limiter, pretensioner and end release.

A segment of webbing and the devices at its end carry one tension T. With ℓ₀ the length at rest, p
what the devices have paid out (less what they have pulled in) and r what slip rings have fed in:

    x = ℓ − ℓ₀ − p − r,    T = F(x),    T = 0 where x < 0

- A retractor that is not locked pays out and reels in by its spring: T = S(p).
- Locked, p changes only under load. Film spool and load limiter pay out one way: T ≤ L(q), and
  where the webbing alone would carry more, their travel q grows until T = L(q). What they have let
  out stays out; the webbing unloads by its own curve. In series they add up: L⁻¹ is the sum of
  theirs. The film of a spool starts at the tension that it locks at.
- A pretensioner pulls in u(t), or as long as T is below its force P(t); it never lets out. P is at
  most L(q): the limiter turns before. It locks the retractor that it fires into.
- A released end carries nothing.

Work: what film and limiter take is ∫ L dq, exact; the spring of the spool stores ∫ S dp; what a
pretensioner does comes from outside.
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
"""Number of steps of Newton's method after which an interval is only halved."""
_MAX_ITERATIONS = 300
_ROOT_TOL = 4.0 * float(np.finfo(np.float64).eps)


class Moment(NamedTuple):
    """The end of a step of a segment."""

    time: float = 0.0
    dt: float = 0.0
    fired: Mapping[str, float] = {}
    """When the triggers of sensors fire; infinite or missing where they do not."""

    def since(self, trigger: str | None) -> float:
        """Time since a trigger fired, negative before; −∞ where it has not."""
        return -math.inf if trigger is None else self.time - self.fired.get(trigger, math.inf)


class DeviceState(NamedTuple):
    """State of the devices of a segment."""

    paid_out: float = 0.0
    """Length that they have let out since the start, less what they have pulled in."""
    fed: float = 0.0
    """Length that slip rings have brought into the segment, less what they took."""
    travel: float = 0.0
    """Travel of film and limiter under load, with the film's up to the tension it was locked at."""
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


class Moved(NamedTuple):
    """A step of a segment."""

    axial: Response
    state: DeviceState


@dataclass(frozen=True, init=False, eq=False)
class Retractor:
    """A spool that pays out and reels in by its spring until it locks, for good.

    Parameters
    ----------
    spool : force of its spring, a number, or rows of length paid out and force; those of the ends
        stay beyond them
    trigger : name of the sensor whose trigger locks it (the acceleration of the vehicle)
    rate : speed of pay-out above which it locks, > 0; the step in which it is passed is the last
        unlocked one
    film : rows of length and force, from 0: what the tight spool pays out once it is locked, no
        more than in the last row

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
        put(self, "spool", _rising("spool", rows, ("paid out", "force")))
        put(self, "trigger", trigger)
        put(self, "rate", None if rate is None else positive(rate, "rate"))
        tight = None if film is None else _rising("film", film, ("paid out", "force"))
        if tight is not None and (tight[0, 0] != 0.0 or not (np.diff(tight[:, 1]) > 0.0).all()):
            raise InputError(
                "what a film lets out is a function of the force, from 0 on",
                where="film",
                found=tight.tolist(),
                allowed="rows [paid out, force] from 0, both strictly increasing",
            )
        put(self, "film", tight)

    def unlocked(self) -> Retractor:
        """A copy that does not lock."""
        free = copy(self)
        object.__setattr__(free, "trigger", None)
        object.__setattr__(free, "rate", None)
        return free


@dataclass(frozen=True, init=False, eq=False)
class LoadLimiter:
    """A torsion bar or the like: it pays out under load, at a force that its travel decides.

    Parameters
    ----------
    force : a number; or of each stage, at the travels given, linear between: never falling, that of
        the last stays
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
        ways = np.zeros(1) if travel is None else np.atleast_1d(np.asarray(travel, np.float64))
        if forces.ndim != 1 or forces.shape != ways.shape:
            raise InputError(
                "needs a travel for each force",
                where="travel",
                found=ways.shape,
                allowed=f"{forces.shape}",
            )
        rows = _rising("force", np.column_stack([ways, forces]), ("travel", "force"))
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
    pull : rows of the time since then and the length pulled in, never falling; or
    force : rows of that time and the force it pulls with, nothing before and after them
    stroke : the most that a force pulls in

    Raises
    ------
    InputError
        Not one of pull and force, a length that falls or a force below zero, a stroke of a pull.

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
        put(self, "pull", None if pull is None else _rising("pull", pull, ("t", "length")))
        rows = None if force is None else table_of(force, ("t", "force"), where="force")
        if rows is not None and not (rows[:, 1] >= 0.0).all():
            raise InputError("must not be negative", where="force", found=rows.tolist())
        put(self, "force", rows)
        put(self, "stroke", math.inf if stroke is None else positive(stroke, "stroke"))

    @property
    def kinks(self) -> FloatArray:
        """Times since it fires at which what it does bends."""
        rows = self.force if self.pull is None else self.pull
        assert rows is not None
        return np.asarray(rows[:, 0])

    def pulled(self, since: float) -> float:
        """Length that is to be pulled in by then."""
        if self.pull is None or since < 0.0:
            return 0.0
        return float(np.interp(since, self.pull[:, 0], self.pull[:, 1]))

    def strength(self, since: float) -> float:
        """Force that it pulls with then."""
        if self.force is None or not self.force[0, 0] <= since <= self.force[-1, 0]:
            return 0.0
        return float(np.interp(since, self.force[:, 0], self.force[:, 1]))


class Devices(NamedTuple):
    """Devices at the end of a segment; None for each that it has not."""

    retractor: Retractor | None = None
    limiter: LoadLimiter | None = None
    pretensioner: Pretensioner | None = None
    release: str | None = None
    """Name of the sensor whose trigger releases the end."""

    @property
    def triggers(self) -> dict[str, str]:
        """Names of the sensors that they wait for, by who does."""
        retractor = None if self.retractor is None else self.retractor.trigger
        pretensioner = None if self.pretensioner is None else self.pretensioner.trigger
        named = {"retractor": retractor, "pretensioner": pretensioner, "release": self.release}
        return {who: name for who, name in named.items() if name is not None}


class Webbing:
    """The law of webbing with the devices at its end."""

    def __init__(self, webbing: SpringLaw, devices: Devices) -> None:
        self._webbing = webbing
        self._devices = devices
        self._slider = _slider(devices)
        self._spool = None if devices.retractor is None else _held(devices.retractor.spool)

    def max_slope(self, x: float) -> float:
        """Bound of dT/dx, ≥ 0: devices in series only make it softer."""
        return self._webbing.max_slope(max(x, 0.0))

    def move(
        self,
        old: tuple[float, float],
        last: DeviceState,
        reach: float,
        fed: float,
        moment: Moment,
    ) -> Moved:
        """The step from elongation and tension `old` and devices `last`.

        Parameters
        ----------
        old : elongation and tension before the step
        last : state of the devices before the step
        reach : ℓ − ℓ₀ at its end
        fed : r at its end
        moment : time and length of the step, and fired triggers
        """
        last = last._replace(fed=fed)
        if moment.since(self._devices.release) >= 0.0:
            released = min(last.released, moment.fired[self._devices.release or ""])
            return Moved(SLACK, last._replace(released=released, spool=0.0))
        held = self._held(last, old[1], moment)
        if self._spool is not None and math.isinf(held.locked):
            return self._unlocked(old, held, reach - fed, moment)
        return self._locked(old, held, reach - fed, moment)

    def _held(self, last: DeviceState, tension: float, moment: Moment) -> DeviceState:
        """The devices, their retractor locked where a trigger does it."""
        retractor, pretensioner = self._devices.retractor, self._devices.pretensioner
        if retractor is None or math.isfinite(last.locked):
            return last
        by = [retractor.trigger, None if pretensioner is None else pretensioner.trigger]
        since = max(moment.since(trigger) for trigger in by)
        return self._lock(last, tension, moment.time - since) if since >= 0.0 else last

    def _lock(self, last: DeviceState, tension: float, time: float) -> DeviceState:
        travel = 0.0 if self._slider is None else self._slider.travel(tension)
        return last._replace(locked=time, travel=travel)

    def _at(self, old: tuple[float, float], x: float) -> Response:
        return self._webbing.move(*old, x) if x >= 0.0 else SLACK

    def _unlocked(
        self, old: tuple[float, float], last: DeviceState, reach: float, moment: Moment
    ) -> Moved:
        spool = self._spool
        assert spool is not None

        def surplus(x: float) -> tuple[float, float]:
            """Return the spool's force less the tension at an elongation, and the slope."""
            webbing, point = self._at(old, x), _point(spool, reach - x)
            return point.value - webbing.force, -point.slope - webbing.stiffness

        x = root(surplus, 0.0, max(old[0], 1e-3 * abs(reach), _ROOT_TOL))
        webbing, (force, slope, stored) = self._at(old, x), _point(spool, reach - x)
        state = last._replace(paid_out=reach - x, spool=stored)
        rate = self._devices.retractor.rate if self._devices.retractor else None
        way = state.paid_out - last.paid_out
        if rate is not None and moment.dt > 0.0 and way > rate * moment.dt:
            state = self._lock(state, force, moment.time)
        both = webbing.stiffness + slope
        stiffness = webbing.stiffness * slope / both if both > 0.0 else 0.0
        return Moved(Response(force, stiffness, webbing.stored, webbing.lost), state)

    def _locked(
        self, old: tuple[float, float], last: DeviceState, reach: float, moment: Moment
    ) -> Moved:
        pulled, strength = last.pulled_in, 0.0
        if self._devices.pretensioner is not None:
            since = moment.since(self._devices.pretensioner.trigger)
            pulled = max(pulled, self._devices.pretensioner.pulled(since))
            strength = self._devices.pretensioner.strength(since)
        paid_out = last.paid_out - (pulled - last.pulled_in)
        x = reach - paid_out
        webbing = self._at(old, x)
        force, stiffness, travel, lost = webbing.force, webbing.stiffness, last.travel, 0.0
        yields = math.inf if self._slider is None else _point(self._slider.curve, travel).value
        if force < min(strength, yields):
            level = min(strength, yields)

            def short(more: float) -> tuple[float, float]:
                """Return how much tension is missing once more is pulled in, and the slope."""
                there = self._at(old, x + more)
                return level - there.force, -there.stiffness

            room = self._devices.pretensioner.stroke - pulled if self._devices.pretensioner else 0.0
            at_end = short(room)[0] if math.isfinite(room) else -1.0
            pull = room if at_end > 0.0 else root(short, 0.0, max(1e-3 * abs(x), _ROOT_TOL))
            pulled, paid_out = pulled + pull, paid_out - pull
            webbing = self._at(old, x + pull)
            force = webbing.force if at_end > 0.0 else level
            stiffness = webbing.stiffness if at_end > 0.0 else 0.0
        elif force > yields:
            slider = self._slider
            assert slider is not None

            def over(way: float) -> tuple[float, float]:
                """Return the tension less what film and limiter hold at a travel, and the slope."""
                there, limit = self._at(old, x - way), _point(slider.curve, travel + way)
                return there.force - limit.value, -there.stiffness - limit.slope

            room = slider.end - travel
            at_end = over(room)[0] if math.isfinite(room) else -1.0
            way = room if at_end > 0.0 else root(over, 0.0, max(x, _ROOT_TOL))
            webbing, limit = self._at(old, x - way), _point(slider.curve, travel + way)
            lost = limit.integral - _point(slider.curve, travel).integral
            travel, paid_out = travel + way, paid_out + way
            force, both = limit.value, webbing.stiffness + limit.slope
            stiffness = webbing.stiffness * limit.slope / both if both > 0.0 else 0.0
            if at_end > 0.0:
                force, stiffness = webbing.force, webbing.stiffness
        work = last.work + 0.5 * (old[1] + force) * (pulled - last.pulled_in)
        state = last._replace(paid_out=paid_out, travel=travel, pulled_in=pulled, work=work)
        return Moved(Response(force, stiffness, webbing.stored, webbing.lost + lost), state)


class _Slider(NamedTuple):
    """Film and limiter in series: the force over their travel that they pay out at."""

    curve: Curves
    end: float
    """Travel that they stop at."""

    def travel(self, tension: float) -> float:
        """Least travel at which they hold a tension."""
        return float(np.interp(tension, self.curve.y, self.curve.x)) if tension > 0.0 else 0.0


def _slider(devices: Devices) -> _Slider | None:
    film = None if devices.retractor is None else devices.retractor.film
    limiter = devices.limiter
    if limiter is None:
        return None if film is None else _Slider(_held(film), float(film[-1, 0]))
    ways, forces = limiter.travel, limiter.force
    if film is None:
        return _Slider(_held(np.column_stack([ways, forces])), math.inf)
    # Their travels add up at each force that one of them bends at.
    also = film[(film[:, 1] < forces[-1]) & ~np.isin(film[:, 1], forces), 1]
    own = np.interp(also, forces, ways)
    levels = np.concatenate([forces, also])
    travels = np.concatenate([ways, own]) + np.interp(levels, film[:, 1], film[:, 0])
    if film[0, 1] > 0.0 and film[0, 1] >= forces[-1]:
        travels, levels = ways, forces
    rows = np.unique(np.column_stack([travels, levels]), axis=0)
    # From the travel at which the least force is passed: what lies below holds without any.
    first = np.flatnonzero(rows[:, 0] == 0.0)[-1] if (rows[:, 0] == 0.0).any() else 0
    return _Slider(_held(rows[first:]), math.inf)


def _held(rows: FloatArray) -> Curves:
    """Return the curve through rows (n, 2), which beyond its ends holds their values."""
    x = np.union1d(rows[:, 0], 0.0)
    return piecewise(x, np.interp(x, rows[:, 0], rows[:, 1]), 0.0, 0.0)


def _point(curve: Curves, x: float) -> CurvePoint:
    """Return a curve at x."""
    return CurvePoint(*curve_nb.point(curve, 0, x))


def root(falling: Callable[[float], tuple[float, float]], low: float, width: float) -> float:
    """Find the zero of a function that never rises, at `low` or above; `low` if it starts below.

    Newton's method between bounds, which is exact where the function is piecewise linear.

    Parameters
    ----------
    low : lower end of the search
    falling : gives value and slope
    width : a guess of how far the zero is, > 0
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
    at = low
    for k in range(_MAX_ITERATIONS):
        then = at - value / slope if slope < 0.0 and k < _N_NEWTON else low
        if not low < then <= high:
            then = 0.5 * (low + high)
        if abs(then - at) <= _ROOT_TOL * abs(then):
            return then
        at = then
        value, slope = falling(at)
        if value == 0.0:
            return at
        low, high = (at, high) if value > 0.0 else (low, at)
    return at


def _rising(where: str, rows: object, columns: tuple[str, str]) -> FloatArray:
    """Return rows (n, 2) whose second column, ≥ 0, never falls."""
    table = table_of(rows, columns, where=where)
    check_never_falls(table, columns, where)
    return table
