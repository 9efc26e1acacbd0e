"""Friction: from normal force and sliding to the tangential force on each point in contact.

All vectors are in the axes of the master, whose frame moves with it: a rigid motion of the whole
scene causes no sliding. Forces are those on the slave; the opposite forces act on the master at the
same places.

`Coulomb` sticks and slips by a return mapping (Simo & Hughes, Computational Inelasticity, 1998,
ch. 1; Wriggers, Computational Contact Mechanics, 2006, 5.2): sliding stretches a spring in the
tangent plane, whose force returns to the cone if it is outside.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from contiga.arrays.layout import not_negative, positive
from contiga.arrays.threads import run_ranges
from contiga.errors import InputError
from contiga.jit import straight
from contiga.laws.kernels import friction_nb
from contiga.records import FloatArray

MIN_POINTS = 8192
"""Least number of points for a thread."""


class FrictionInput(NamedTuple):
    """The input of a friction law for n points in contact; vectors in the axes of the master."""

    normal: FloatArray
    """(n, 3) unit normals of the master at the feet, to the free side."""
    normal_before: FloatArray
    """(n, 3) normals of the last step; zeros for a new point."""
    force: FloatArray
    """(n,) normal forces ≥ 0."""
    stiffness: FloatArray
    """(n,) stiffness of the law of normal force, force / length: `LawOutput.stiffness`."""
    area: FloatArray
    """(n,) contact areas."""
    path: FloatArray
    """(n, 3) displacement of the point relative to the master in the step; for a new point, its
    part after the entry. The part normal to the surface does not count."""
    velocity: FloatArray
    """(n, 3) velocity relative to the master; the part normal to the surface does not count."""
    dt: float
    """Length of the step, zero at the start and in statics."""
    memory: FloatArray
    """(n, m) output memory of the last step; zeros for a new point."""


class FrictionOutput(NamedTuple):
    """The output of a friction law for n points in contact."""

    force: FloatArray
    """(n, 3) tangential forces on the slave, axes of the master."""
    stiffness: FloatArray
    """(n,) stiffness of the tangential springs, force / length; zero without springs."""
    stored: FloatArray
    """(n,) elastic energy in the springs."""
    lost: FloatArray
    """(n,) energy dissipated in the step, never negative."""
    memory: FloatArray
    """(n, m) memory of each point for the next step."""


class FrictionChange(NamedTuple):
    """Changes of the input of a friction law in m directions, for its derivatives.

    A block slips under a normal force of 10; with one unit more, friction is 0.4 larger:

    >>> z, x, none = np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]]), np.zeros(1)
    >>> slipping = FrictionInput(z, z, np.full(1, 10.0), none, none, x, x, 1.0, np.zeros((1, 7)))
    >>> constant = np.zeros((1, 3, 1))
    >>> heavier = FrictionChange(np.ones((1, 1)), np.zeros((1, 1)), constant, constant, constant)
    >>> Coulomb(0.4, stiffness=100.0).changes(slipping, heavier)[0, :, 0].round(12).tolist()
    [-0.4, 0.0, 0.0]
    """

    force: FloatArray
    """(n, m)."""
    stiffness: FloatArray
    """(n, m)."""
    normal: FloatArray
    """(n, 3, m)."""
    path: FloatArray
    """(n, 3, m)."""
    velocity: FloatArray
    """(n, 3, m), or (0, 3, m) if no velocity changes."""


class CoulombNumbers(NamedTuple):
    """The parameters of a `Coulomb` for its kernel; `dynamic` is `static` if it has none."""

    static: float
    dynamic: float
    decay: float
    stiffness: float
    per_area: bool


class Friction(Protocol):
    """A friction law of a contact.

    It may have further attributes:

    - ``has_rate``: True if the force depends on the velocity. `Contact.step` without ``dt`` and
      velocities is then refused.
    - ``viscosity(force, speed)`` and the number ``coefficient``, for friction without a jump at
      rest: force over sliding speed (n,) at normal forces (n,) and sliding speeds (n,), and the
      largest ratio of friction to normal force. They limit automatic steps.
    - ``changes(inp: FrictionInput, change: FrictionChange)``, which returns the changes (n, 3, m)
      of the forces: `Contact.tangent` needs it.
    - ``largest_coefficient``: the largest ratio of friction to normal force at any speed. Checks of
      a model compare it with coefficients of real surfaces.

    Without ``has_rate``, velocities are taken to have no effect on the force.
    """

    @property
    def n_memory(self) -> int:
        """Number of values by point that friction keeps from one step to the next."""

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Return tangential forces, energies and memory of the points in contact."""

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return the slip (n, 3) of each point since it came in, from its memory (n, m)."""


@dataclass(frozen=True)
class Coulomb:
    """Friction with stick and slip: ``|t| ≤ μ F``.

    ``μ = μ_d + (μ_s − μ_d) e^(−decay |v|)``, v the sliding velocity: from the static coefficient
    down to the dynamic one, as explicit crash codes do.

    Parameters
    ----------
    static : μ_s ≥ 0
    dynamic : μ_d ≥ 0, not above `static`; as `static` if None
    decay : time / length, ≥ 0; 0 (default) is the static coefficient at any velocity
    stiffness : k_t of the spring of a sticking point, force / length; 0 (default) is the largest
        stiffness of the point's law of normal force since it came in
    per_area : whether `stiffness` is by unit area

    Notes
    -----
    In a step of a point, the traction of the last step is transported to the new tangent plane by
    the smallest rotation of the old normal to the new one, and stretched, t* = t − k_t d. Here d is
    the tangential part of the path, the mean of its projections to the old and the new plane, and
    k_t the mean stiffness before and after the step. If ``|t*| > μ F``, t* returns to the length
    μ F, and the point slides by d_p = d − (t_old − t)/k_t.

    The energy t²/(2 k_t) is stored, and −½(t_old + t)·d_p is lost. So on a plane the work of the
    mean traction, −½(t_old + t)·d, is exactly the change of the stored energy plus the loss. Only
    if the cone shrinks in a step that reverses, this loss could be negative; then it is zero. On a
    curved surface the transport rotates the traction and adds no energy.

    k_t never decreases while a point is in contact. When it grows, half before and half after the
    path, the traction stays the same, so that the spring stores less energy; the difference is
    lost. A sticking point therefore does not creep under an oscillating normal force.

    A point comes in without traction; its path in that step is the part after its entry. A point
    that leaves loses the energy of its spring; if its normal force vanishes before, the cone has
    relaxed the spring by then.

    Memory, seven values by point: the traction (3), the sliding distance relative to the master
    since the point came in (3), transported like the traction, and k_t.

    Raises
    ------
    InputError
        A coefficient, decay or stiffness that is negative or not finite, static below dynamic; in
        `respond`, a point with a normal force whose law has had no stiffness yet.

    Examples
    --------
    A block of weight 10 on a spring of 100, pulled by 0.02 and then by 0.1 more: μ F = 4

    >>> z, force = np.array([[0.0, 0.0, 1.0]]), np.array([10.0])
    >>> law = Coulomb(0.4, stiffness=100.0)
    >>> inp = FrictionInput(z, z, force, 0.0 * force, 0.0 * force, 0.0 * z, 0.0 * z, 1.0,
    ...                     np.zeros((1, 7)))
    >>> sticks = law.respond(inp._replace(path=np.array([[0.02, 0.0, 0.0]])))
    >>> slips = law.respond(inp._replace(path=np.array([[0.1, 0.0, 0.0]]), memory=sticks.memory))
    >>> sticks.force[0, 0].tolist(), slips.force[0, 0].tolist(), slips.lost.round(12).tolist()
    (-2.0, -4.0, [0.24])
    """

    static: float
    dynamic: float | None = None
    _: KW_ONLY
    decay: float = 0.0
    stiffness: float = 0.0
    per_area: bool = False

    def __post_init__(self) -> None:
        for name in ("static", "dynamic", "decay", "stiffness"):
            value = getattr(self, name)
            if value is not None or name != "dynamic":
                object.__setattr__(self, name, not_negative(value, name))
        if self.dynamic is not None and self.static < self.dynamic:
            raise InputError(
                "the static coefficient must not be below the dynamic one",
                where="static",
                found=self.static,
                allowed=f"{self.dynamic:g} or above",
            )

    n_memory = 7

    @property
    def has_rate(self) -> bool:
        """True if the force depends on the velocity: the coefficient falls with it."""
        return self.decay > 0.0 and self.dynamic not in (None, self.static)

    @property
    def largest_coefficient(self) -> float:
        """Coefficient at rest, which no sliding speed exceeds."""
        return self.static

    def coefficient(self, speed: FloatArray) -> FloatArray:
        """Return μ (n,) at sliding speeds (n,) ≥ 0."""
        dynamic = self._numbers.dynamic
        return np.asarray(dynamic + (self.static - dynamic) * np.exp(-self.decay * speed))

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return the slip (n, 3) of each point since it came in, a view of its memory (n, 7)."""
        return memory[:, 3:6]

    @property
    def _numbers(self) -> CoulombNumbers:
        dynamic = self.static if self.dynamic is None else self.dynamic
        return CoulombNumbers(self.static, dynamic, self.decay, self.stiffness, bool(self.per_area))

    def changes(self, inp: FrictionInput, change: FrictionChange) -> FloatArray:
        """Return the changes (n, 3, m) of the forces with the input, at the same memory.

        A point is differentiated as it is, sticking or slipping; a point at the cone sticks.
        """
        rows, _ = _rows_of(inp, self.n_memory)
        directions, out = _changes_of(change)
        kernel = friction_nb.coulomb_changes
        run_ranges(kernel, len(out), MIN_POINTS, rows, self._numbers, directions, out)
        return out

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Return friction forces inside the cone, with stored and dissipated energy.

        Raises
        ------
        InputError
            Arrays of another shape, a point with a normal force whose spring has no stiffness.
        """
        rows, out = _rows_of(inp, self.n_memory)
        n = len(rows.force)
        run_ranges(straight(friction_nb.coulomb), n, MIN_POINTS, rows, self._numbers, out)
        n_without = np.count_nonzero((rows.force > 0.0) & ~(out.stiffness > 0.0))
        if n_without:
            raise InputError(
                f"{n_without} points have a normal force and no stiffness to stick by: the law of "
                "normal force has none there, and friction was given none",
                where="friction.stiffness",
                found=self.stiffness,
                allowed="above zero",
                remedy="Give one, such as Coulomb(0.4, stiffness=100.0)",
            )
        return out


@dataclass(frozen=True)
class ViscousFriction:
    """Regularised Coulomb friction, without a jump at rest: ``t = −μ F tanh(|v|/v₀) v/|v|``.

    It never sticks: a load below μ F causes slow sliding. Use it for fast sliding only; `Coulomb`
    needs no such choice.

    Parameters
    ----------
    coefficient : μ ≥ 0
    speed : v₀ > 0; at this sliding speed the friction is 0.76 of μ F

    Notes
    -----
    It stores no energy. The work of the step is lost, −½(t_old + t)·d with the tangential part d of
    the path and the force t_old of the last step, transported as by `Coulomb`. The memory is this
    force.

    Raises
    ------
    InputError
        A coefficient that is negative or not finite, a speed that is not above zero.

    Examples
    --------
    >>> x, z = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> ten, none = np.full(1, 10.0), np.zeros(1)
    >>> sliding = FrictionInput(z, z, ten, none, none, 0.1 * x, x, 0.1, np.zeros((1, 3)))
    >>> law = ViscousFriction(0.3, speed=0.01)
    >>> first = law.respond(sliding)
    >>> second = law.respond(sliding._replace(memory=first.memory))
    >>> second.force[0, 0].tolist(), first.lost.round(12).tolist(), second.lost.round(12).tolist()
    (-3.0, [0.15], [0.3])
    """

    coefficient: float
    speed: float

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "coefficient", not_negative(self.coefficient, "coefficient"))
        put(self, "speed", positive(self.speed, "speed"))

    n_memory = 3
    has_rate = True

    @property
    def largest_coefficient(self) -> float:
        """Coefficient of fast sliding, which no sliding speed exceeds."""
        return self.coefficient

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return zeros (n, 3): no sliding distance is remembered."""
        return np.zeros((len(memory), 3))

    def viscosity(self, force: FloatArray, speed: FloatArray) -> FloatArray:
        """Return μ F tanh(v/v₀)/v (n,), friction by sliding speed (n,), at normal forces (n,).

        At rest it is that of a speed of 1e-9 v₀, the limit to rounding.

        >>> ViscousFriction(0.3, speed=0.01).viscosity(np.array([10.0]), np.zeros(1)).round(9)
        array([300.])
        """
        ratio = np.maximum(speed / self.speed, 1e-9)
        return np.asarray(self.coefficient * force / self.speed * (np.tanh(ratio) / ratio))

    def changes(self, inp: FrictionInput, change: FrictionChange) -> FloatArray:
        """Return the changes (n, 3, m) of the forces with the input, at the same memory."""
        rows, _ = _rows_of(inp, self.n_memory)
        directions, out = _changes_of(change)
        numbers, kernel = (self.coefficient, self.speed), friction_nb.viscous_changes
        run_ranges(kernel, len(out), MIN_POINTS, rows, *numbers, directions, out)
        return out

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Return forces against the sliding velocity, and their losses, with no stiffness.

        Raises
        ------
        InputError
            Arrays of another shape.
        """
        rows, out = _rows_of(inp, self.n_memory)
        numbers, kernel = (self.coefficient, self.speed), straight(friction_nb.viscous)
        run_ranges(kernel, len(rows.force), MIN_POINTS, rows, *numbers, out)
        return out


def _rows_of(inp: FrictionInput, n_memory: int) -> tuple[FrictionInput, FrictionOutput]:
    """Return the input as contiguous arrays for kernels, and an output with empty arrays to fill.

    Raises
    ------
    InputError
        An array of another shape.
    """
    n = len(inp.force)
    shapes = (n, 3), (n, 3), (n,), (n,), (n,), (n, 3), (n, 3), (), (n, n_memory)
    arrays: list[Any] = []
    values: Any
    for name, values, shape in zip(FrictionInput._fields, inp, shapes, strict=True):
        if name == "dt":
            arrays.append(float(inp.dt))
            continue
        if np.shape(values) != shape:
            raise InputError(
                "the memory is of another friction"
                if name == "memory"
                else "friction must be given one row a point",
                where=name,
                found=np.shape(values),
                allowed=str(shape),
            )
        arrays.append(_contiguous(values))
    columns = np.empty(n), np.empty(n), np.empty(n)
    out = FrictionOutput(np.empty((n, 3)), *columns, np.empty((n, n_memory)))
    return FrictionInput._make(arrays), out


def _changes_of(change: FrictionChange) -> tuple[FrictionChange, FloatArray]:
    """Return the directions as contiguous arrays for kernels, and an array (n, 3, m) to fill."""
    directions = FrictionChange(*map(_contiguous, change))
    n, m = directions.force.shape
    return directions, np.empty((n, 3, m))


def _contiguous(values: Any) -> FloatArray:
    """Return `values` as a writeable, contiguous array, a copy only if they are not."""
    is_float = isinstance(values, np.ndarray) and values.dtype == np.float64
    return values if is_float and values.flags.carray else np.array(values, np.float64, order="C")
