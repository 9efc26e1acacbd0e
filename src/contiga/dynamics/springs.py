"""Springs and dampers between two points of bodies, nodes of slaves, or the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import (
    as_numbers,
    check_types,
    checked_choice,
    not_negative,
    read_only,
    real,
)
from contiga.criteria.filters import NAMES as FILTERS
from contiga.curves.characteristic import Characteristic, CurveLike, as_curve
from contiga.curves.hysteresis import Hysteresis, hysteresis_of
from contiga.dynamics.belt_devices import (
    Devices,
    DeviceState,
    LoadLimiter,
    Moment,
    Pretensioner,
    Retractor,
    SegmentStep,
    Webbing,
)
from contiga.dynamics.spring_law import SpringLaw
from contiga.errors import InputError, RunError
from contiga.records import FloatArray, IntArray

GROUND = "ground"
_NO_MOMENT = Moment()
_SAME_POINT = 1e-12
"""Distance of two points, over their largest coordinate, that counts as rounding."""


class Spread(NamedTuple):
    """Nodes of a slave that share an end of a spring, such as the last row of a belt."""

    nodes: IntArray
    """(k,) numbers of the nodes."""
    shares: FloatArray
    """(k,) share of each node in the force on the end; they sum to 1."""


class SpringState(NamedTuple):
    """State of a spring. `stored` is an energy at that time; losses are sums since the start."""

    ends: FloatArray
    """(2, 3) world."""
    length: float
    force: float
    """Tension of spring and damper."""
    damper: float
    """Force of the damper alone."""
    stiffness: float
    """d force / d elongation, without the damper."""
    memory: float
    """Tension without the damper, from which hysteresis continues."""
    stored: float
    """Recoverable energy."""
    hysteresis: float
    """Energy lost since the start by hysteresis, and to the devices."""
    damping: float
    """Energy lost by the damper since the start."""
    devices: DeviceState = DeviceState()
    """State of the devices at its end."""

    @property
    def pull(self) -> FloatArray:
        """Force (3,) on the body of the first end, world axes; the second end has the opposite.

        It is zero while the ends coincide, and the spring has no direction.
        """
        if self.length == 0.0:
            return np.zeros(3)
        (x0, y0, z0), (x1, y1, z1) = self.ends.tolist()
        share = self.force / self.length
        return np.array([(x1 - x0) * share, (y1 - y0) * share, (z1 - z0) * share])


@dataclass(frozen=True, init=False, eq=False)
class Spring:
    """A spring, a damper or both between two points.

    Parameters
    ----------
    between : names of two bodies or slaves, or of one and "ground"
    at : (2, 3) one point of each, world coordinates at the start of the run; on a slave the spring
        ends at the nearest node
    curve : force over elongation, tension positive: a number is a stiffness for both signs; a
        table is extrapolated as its `extrapolation` says
    unloading, hysteresis_slope : as for the laws of a contact. Such a spring carries tension only
        (a belt, a Kelvin restraint): it is slack when shorter than its rest length, which erases
        its memory, and its damper never pushes.
    damping : force over the rate of elongation, ≥ 0
    length : length at rest, ≥ 0; the distance of the points at the start if None
    name : name in results; "<first>-<second>" if empty
    filter : "CFC60", "CFC180", "CFC600" or "CFC1000" (SAE J211) for the force in results; none if
        omitted
    retractor, limiter, pretensioner : devices at its end, of `contiga.belts`. Such a spring is
        webbing: it carries tension only, and has no damper.
    release : name of the sensor whose trigger releases its end
    spread : for each end, the nodes of its slave that share it, None for the node nearest to `at`

    Notes
    -----
    The force is F(ℓ − ℓ₀) + c ℓ', along the line between the ends. The stored energy is ∫₀ˣ F dx,
    exact for tables; hysteresis loses energy as in the law of a contact (`Hysteresis`); the loss of
    the damper is integrated by the trapezoidal rule, consistent with the Verlet integrator. Ends
    that coincide have no direction between them: the force on both is zero.

    Raises
    ------
    InputError
        Neither curve nor damping; both ends of one body, or both on the ground; two equal points;
        curves that break the rules of `Characteristic` and `Hysteresis`; an unknown filter.

    Examples
    --------
    >>> belt = Spring(("dummy", "ground"), at=[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]], curve=50.0)
    >>> state = belt.start([[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], np.zeros((2, 3)))
    >>> state.force, state.stored, state.pull.tolist()
    (50.0, 25.0, [50.0, 0.0, 0.0])
    """

    between: tuple[str, str]
    at: FloatArray
    curve: Characteristic | None
    hysteresis: Hysteresis | None
    damping: float
    length: float
    name: str
    filter: str | None
    devices: Devices
    is_webbing: bool
    """True if it is webbing with devices at its end, or in slip rings."""
    is_taut: bool
    """True if the length at rest is the distance of the points at the start."""
    spread: tuple[Spread | None, Spread | None]
    """Nodes that share each end."""

    def __init__(
        self,
        between: Sequence[str],
        *,
        at: ArrayLike,
        curve: CurveLike | None = None,
        unloading: CurveLike | None = None,
        hysteresis_slope: float | None = None,
        damping: float = 0.0,
        length: float | None = None,
        name: str = "",
        filter: str | None = None,
        retractor: Retractor | None = None,
        limiter: LoadLimiter | None = None,
        pretensioner: Pretensioner | None = None,
        release: str | None = None,
        spread: tuple[Spread | None, Spread | None] = (None, None),
    ) -> None:
        pair, ends = _checked_pair(between), _checked_ends(at)
        damping = not_negative(damping, "damping")
        if curve is None:
            for key, value in (("unloading", unloading), ("hysteresis_slope", hysteresis_slope)):
                if value is not None:
                    raise InputError(
                        "is missing: a spring that unloads has a curve that it loads by",
                        where="curve",
                        remedy=f"Give the curve, or remove {key}",
                    )
            if damping == 0.0:
                raise InputError(
                    "a spring needs a curve or a damping",
                    where="curve",
                    found="neither",
                    allowed="a stiffness, a table of force over elongation, or damping > 0",
                )
        loading = as_curve(0.0 if curve is None else curve, "curve")
        hysteresis = hysteresis_of(loading, unloading, hysteresis_slope)
        is_bounded = loading.is_table and loading.extrapolation == "error"
        if is_bounded and not loading.x[0] <= 0.0 <= loading.x[-1]:
            raise InputError(
                "a table that must not be left needs the elongation zero in it",
                where=loading.name,
                found=[float(loading.x[0]), float(loading.x[-1])],
                remedy='Add a row for it, or set extrapolation = "linear" or "constant"',
            )
        rest = math.dist(*ends.tolist()) if length is None else not_negative(length, "length")
        put = object.__setattr__
        put(self, "between", pair)
        put(self, "at", ends)
        put(self, "curve", None if curve is None else loading)
        put(self, "hysteresis", hysteresis)
        put(self, "damping", damping)
        put(self, "length", rest)
        put(self, "name", name or "-".join(pair))
        put(self, "filter", None if filter is None else checked_choice("filter", filter, FILTERS))
        put(self, "is_taut", length is None)
        put(self, "spread", spread)
        devices = Devices(retractor, limiter, pretensioner, release)
        put(self, "devices", devices)
        for device, kind in zip(devices, (Retractor, LoadLimiter, Pretensioner, str), strict=True):
            if device is not None:
                check_types(kind, (device,), kind.__name__.lower(), "must be", kind.__name__)
        put(self, "is_webbing", any(device is not None for device in devices))
        if self.is_webbing:
            _check_webbing(self, "a device")

    def as_webbing(self) -> Spring:
        """Return a copy that carries tension only, as webbing through a slip ring does.

        Raises
        ------
        InputError
            The spring has no curve, a damper, or a curve that falls.
        """
        _check_webbing(self, "a slip ring")
        segment = copy(self)
        object.__setattr__(segment, "is_webbing", True)
        return segment

    def resting(self) -> Spring:
        """Return a copy for coming to rest before a run: nothing fires, no retractor locks.

        It keeps retractor and load limiter, without pretensioner and release.
        """
        resting, retractor = copy(self), self.devices.retractor
        unlocked = None if retractor is None else retractor.unlocked()
        object.__setattr__(resting, "devices", Devices(unlocked, self.devices.limiter))
        return resting

    def with_ends(self, at: FloatArray) -> Spring:
        """Return a copy between other points (2, 3) at the start.

        Its length at rest is the same if it was given, else the new distance of the points. An
        `InputError` is raised if they are not two different, finite points.
        """
        moved, ends = copy(self), _checked_ends(at)
        object.__setattr__(moved, "at", ends)
        if self.is_taut:
            object.__setattr__(moved, "length", math.dist(*ends.tolist()))
        return moved

    def start(
        self, ends_W: ArrayLike, velocities_W: ArrayLike, *, moment: Moment = _NO_MOMENT
    ) -> SpringState:
        """Return the state at the start, with stored energy but no losses.

        Parameters
        ----------
        ends_W, velocities_W : (2, 3) of the two points, world axes
        moment : time of the start, for its devices
        """
        return self.begun(self.step(self.at_rest, ends_W, velocities_W, moment=moment))

    @property
    def at_rest(self) -> SpringState:
        """State before the start, at its length at rest."""
        return SpringState(self.at, self.length, *7 * (0.0,))

    @staticmethod
    def begun(state: SpringState) -> SpringState:
        """Return a state with losses and work of the devices set to zero."""
        devices = state.devices._replace(work=0.0)
        return state._replace(hysteresis=0.0, damping=0.0, devices=devices)

    def step(
        self,
        last: SpringState,
        ends_W: ArrayLike,
        velocities_W: ArrayLike,
        *,
        moment: Moment = _NO_MOMENT,
        fed: float = 0.0,
    ) -> SpringState:
        """Return the state after a step from `last`.

        The energy stored in webbing that is released in this step is lost, with its work until
        then.

        Parameters
        ----------
        last : state before the step
        ends_W, velocities_W : (2, 3) of the two points at the end of the step, world axes; webbing
            has no damper and does not use velocities
        moment : time and length of the step, and fired triggers, for its devices
        fed : length that slip rings feed in during the step, for webbing only

        Raises
        ------
        RunError
            Pretensioner and slip rings have used up all the webbing, or the elongation is beyond a
            table that must not be left.
        """
        ends = np.array(real(ends_W), dtype=np.float64)
        (x0, y0, z0), (x1, y1, z1) = ends.tolist()
        (u0, v0, w0), (u1, v1, w1) = np.asarray(real(velocities_W), dtype=np.float64).tolist()
        x, y, z = x1 - x0, y1 - y0, z1 - z0
        length = math.hypot(x, y, z)
        damper = 0.0
        if self.is_webbing:
            response, devices = self.moved(last, length, fed, moment)
            if self.length + devices.paid_out + devices.fed <= 0.0:
                raise RunError(
                    f"t = {moment.time:g}: spring {self.name!r} has no webbing left: "
                    f"{self.length:g} at the start, {-devices.paid_out:g} pulled in and "
                    f"{-devices.fed:g} gone through slip rings. Start with a longer piece"
                )
            lost, stored = response.lost, response.stored + devices.spool
            if math.isfinite(devices.released) and math.isinf(last.devices.released):
                # The stored energy is lost, with the work of this step.
                lost = last.stored + 0.5 * last.force * (length - last.length - fed)
        else:
            devices, law = last.devices, self._law
            response = law.move(last.length - self.length, last.memory, length - self.length)
            lost, stored = response.lost, response.stored
            # Coinciding ends have no direction, and so no rate.
            rate = (x * (u1 - u0) + y * (v1 - v0) + z * (w1 - w0)) / length if length else 0.0
            damper = self.damping * rate
            if self.hysteresis is not None:  # carries tension only
                damper = 0.0 if length < self.length else max(damper, -response.force)
        return SpringState(
            ends,
            length,
            response.force + damper,
            damper,
            response.stiffness,
            response.force,
            stored,
            last.hysteresis + lost,
            last.damping + 0.5 * (last.damper + damper) * (length - last.length),
            devices,
        )

    def moved(self, last: SpringState, length: float, fed: float, moment: Moment) -> SegmentStep:
        """Return the result of a step from `last` to a `length` of webbing and its devices.

        Rings feed the length `fed` into it during the step.
        """
        old, devices = (self.elongation(last), last.memory), last.devices
        return self._webbing.move(old, devices, length - self.length, devices.fed + fed, moment)

    def elongation(self, state: SpringState) -> float:
        """Return its elongation from rest, less the webbing that is paid out and fed in."""
        return state.length - self.length - state.devices.paid_out - state.devices.fed

    def stiffness_bound(self, state: SpringState) -> tuple[float, float]:
        """Return upper bounds of the stiffness along and across the spring, for the critical step.

        Along it the steepest slope of a step: the slope of hysteresis, else the largest of the
        current piece of the table and its neighbours. Across it the tension over the length.
        """
        axial = (self._webbing if self.is_webbing else self._law).max_slope(self.elongation(state))
        return axial, max(state.force, 0.0) / state.length if state.length > 0.0 else axial

    @cached_property
    def _law(self) -> SpringLaw:
        curve = Characteristic(0.0) if self.curve is None else self.curve
        return SpringLaw(curve, self.hysteresis)

    @cached_property
    def _webbing(self) -> Webbing:
        return Webbing(self._law, self.devices)


def _checked_pair(between: Sequence[str]) -> tuple[str, str]:
    """Return two different names; an `InputError` is raised for anything else."""
    allowed = f'the names of two bodies or slaves, or of one and "{GROUND}"'
    names = [between] if isinstance(between, str) else list(between)
    if len(names) != 2 or not all(isinstance(name, str) and name for name in names):
        raise InputError("must be two names", where="between", found=between, allowed=allowed)
    first, second = names
    if first != second:
        return first, second
    problem = "both ends are on the ground" if first == GROUND else "both ends are of one body"
    raise InputError(
        f"{problem}: the spring would move nothing", where="between", found=names, allowed=allowed
    )


def _checked_ends(at: ArrayLike) -> FloatArray:
    """Return two finite points (2, 3), read-only.

    An `InputError` is raised for anything else, or a distance that is rounding (`_SAME_POINT`).
    """
    ends = as_numbers(at, "at", "must be two points", allowed="(2, 3)")
    if ends.shape != (2, 3) or not np.isfinite(ends).all():
        raise InputError("must be two finite points", where="at", found=at, allowed="(2, 3)")
    if math.dist(*ends.tolist()) <= _SAME_POINT * float(np.abs(ends).max()):
        raise InputError(
            "the two points are one: a spring between them has no direction", where="at", found=at
        )
    return read_only(ends)


def _check_webbing(spring: Spring, device: str) -> None:
    """Refuse a spring that cannot be webbing, as its `device` needs.

    An `InputError` is raised for a damper, no curve, a curve by a function, and one that does not
    begin at [0, 0] or falls.
    """
    curve = spring.curve
    if curve is None:
        raise InputError(
            f"is missing: {device} needs webbing",
            where="curve",
            allowed="a stiffness or a table of force over elongation",
        )
    if spring.damping:
        raise InputError(
            f"webbing with {device} has no damper: one tension acts in all of it",
            where="damping",
            found=spring.damping,
            remedy="Give the webbing an unloading curve",
        )
    if not curve.is_table:
        raise InputError(f"{device} needs webbing by numbers", where="curve", allowed="a table")
    x, y = curve.carried_pieces.x, curve.carried_pieces.y
    falls = curve.extrapolation == "linear" and curve.end_slopes[1] < 0.0
    if x[0] != 0.0 or float(curve(0.0)) != 0.0 or (np.diff(y) < 0.0).any() or falls:
        raise InputError(
            f"the webbing that {device} is on carries nothing at rest, and never less when longer",
            where="curve",
            found=np.column_stack([curve.x, curve.y]).tolist(),
            allowed="a table from [0, 0] on whose force never falls",
        )
