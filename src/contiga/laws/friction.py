"""Friction: from normal force and sliding to the tangential force on each point in contact.

All vectors are in the axes of the master, whose frame moves with it: a rigid motion of the whole
scene makes no sliding. Forces are those on the slave; the master feels the opposite at the same
places.

`Coulomb` sticks and slips by a return mapping (Simo & Hughes, Computational Inelasticity, 1998,
ch. 1; Wriggers, Computational Contact Mechanics, 2006, 5.2): a spring in the tangent plane is
stretched by the sliding, and cut back to the cone where it exceeds it.
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

GRAIN = 8192
"""Smallest number of points of a thread."""


class FrictionInput(NamedTuple):
    """The input of a friction law for n points in contact; vectors in the axes of the master."""

    normal: FloatArray
    """(n, 3) unit normals of the master at the feet, to the free side."""
    normal_before: FloatArray
    """(n, 3) those of the last step; zeros of a point without a past."""
    force: FloatArray
    """(n,) normal forces ≥ 0."""
    stiffness: FloatArray
    """(n,) of the law of normal force: `LawOutput.stiffness`."""
    area: FloatArray
    """(n,) contact areas."""
    path: FloatArray
    """(n, 3) way of the point against the master in the step; of a point that came in, the part
    behind its entry. What is normal to the surface does not count."""
    velocity: FloatArray
    """(n, 3) of the point against the master; what is normal to the surface does not count."""
    dt: float
    """Length of the step, zero at the start and in statics."""
    memory: FloatArray
    """(n, m) what friction left of each point at the last step; zeros of a point without a past."""


class FrictionOutput(NamedTuple):
    """The output of a friction law for n points in contact."""

    force: FloatArray
    """(n, 3) tangential forces on the slave, axes of the master."""
    stiffness: FloatArray
    """(n,) of the tangential springs, force a length; zero without springs."""
    stored: FloatArray
    """(n,) elastic energy in the springs."""
    lost: FloatArray
    """(n,) energy turned into heat in the step, never negative."""
    memory: FloatArray
    """(n, m) numbers of each point for the next step."""


class FrictionChange(NamedTuple):
    """Changes of the input of a friction law in m directions, for its derivatives.

    A block that slips under a normal force of 10; with one more it is held back by 0.4 more:

    >>> up, along, none = np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]]), np.zeros(1)
    >>> ten, rest = np.full(1, 10.0), np.zeros((1, 7))
    >>> pulled = FrictionInput(up, up, ten, none, none, along, along, 1.0, rest)
    >>> stays = np.zeros((1, 3, 1))
    >>> heavier = FrictionChange(np.ones((1, 1)), np.zeros((1, 1)), stays, stays, stays)
    >>> Coulomb(0.4, stiffness=100.0).changes(pulled, heavier)[0, :, 0].round(12).tolist()
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
    """(n, 3, m); none (0, 3, m) where it stays."""


class CoulombNumbers(NamedTuple):
    """The numbers of a `Coulomb`, as its kernel reads them."""

    static: float
    dynamic: float
    decay: float
    stiffness: float
    per_area: bool


class Friction(Protocol):
    """Friction as a contact uses it.

    It may have more, which is asked for by name:

    - ``has_rate``: True if the force depends on the velocity. `Contact.step` without ``dt`` and
      velocities is then refused.
    - ``viscosity(force, speed)`` and the number ``coefficient``, for friction without a jump at
      rest: force over sliding speed (n,) at normal forces (n,) and sliding speeds (n,), and the
      largest ratio of friction to normal force. Automatic steps are then short enough for it.
    - ``changes(inp: FrictionInput, change: FrictionChange)``, which returns the changes (n, 3, m)
      of the forces: `Contact.tangent` needs it.
    """

    @property
    def n_memory(self) -> int:
        """Numbers a point that it keeps from one step to the next."""

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Tangential forces, energies and memory of the points in contact."""

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return the way slid (n, 3) since each point came in, from its memory (n, m)."""


@dataclass(frozen=True)
class Coulomb:
    """Friction with stick and slip: ``|t| ≤ μ F``.

    ``μ = μ_d + (μ_s − μ_d) e^(−decay |v|)``, v the sliding velocity: from the static coefficient
    down to the dynamic one, as explicit crash codes do.

    Parameters
    ----------
    static : μ_s ≥ 0
    dynamic : μ_d ≥ 0, not above `static`; as `static` if None
    decay : time a length, ≥ 0; 0 (default) keeps the static coefficient at any velocity
    stiffness : k_t of the spring a point sticks by, force a length; 0 (default) takes the largest
        stiffness the point's law of normal force has had since it came in
    per_area : whether `stiffness` is that of a unit area

    Notes
    -----
    A step, one point: the traction of the last step is carried to the new tangent plane by the
    smallest rotation of the old normal to the new one, and stretched, t* = t − k_t d, by the
    tangential part d of the path, the mean of what the old and the new plane see of it, by the mean
    of the k_t before and after the step. Where ``|t*| > μ F`` it is cut back to μ F, and the point
    has slid by d_p = d − (t_old − t)/k_t.

    The energy t²/(2 k_t) is stored. Lost are −½(t_old + t)·d_p, so that on a plane the work of the
    mean traction, −½(t_old + t)·d, is what is stored more and what is lost, exactly; only where the
    cone shrinks in a step that turns round could the mean say that heat was won, and none is. On a
    curved surface the carrying turns the traction and adds no energy.

    k_t never decreases while a point is in contact. Where it grows, half before and half after the
    path, the traction stays, so that the spring holds less than before; that is lost as well. A
    point that sticks therefore does not creep under a normal force that swings.

    A point comes in without traction; all of the path it is given for that step counts, which is
    the part behind its entry. A point that leaves drops what its spring has stored; where the
    normal force goes to zero before, the cone has cut it back by then.

    Memory, seven numbers a point: the traction (3), the way slid against the master since the
    point came in (3), carried along as the traction is, and k_t.

    Raises
    ------
    InputError
        A coefficient, decay or stiffness that is negative or not finite, static below dynamic; at
        `respond`, a point with a normal force whose law has given no stiffness yet.

    Examples
    --------
    A block of weight 10 on a spring of 100, pulled by 0.02 and then by 0.1 more: μ F = 4

    >>> up, force = np.array([[0.0, 0.0, 1.0]]), np.array([10.0])
    >>> law = Coulomb(0.4, stiffness=100.0)
    >>> pulled = FrictionInput(up, up, force, 0.0 * force, 0.0 * force, 0.0 * up, 0.0 * up, 1.0,
    ...                        np.zeros((1, 7)))
    >>> sticks = law.respond(pulled._replace(path=np.array([[0.02, 0.0, 0.0]])))
    >>> slips = law.respond(pulled._replace(path=np.array([[0.1, 0.0, 0.0]]), memory=sticks.memory))
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

    def coefficient(self, speed: FloatArray) -> FloatArray:
        """μ at sliding speeds (n,) ≥ 0."""
        least = self.static if self.dynamic is None else self.dynamic
        return np.asarray(least + (self.static - least) * np.exp(-self.decay * speed))

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return the sliding distance (n, 3) since each point came in."""
        return memory[:, 3:6]

    @property
    def _numbers(self) -> CoulombNumbers:
        least = self.static if self.dynamic is None else self.dynamic
        numbers = self.static, least, self.decay, self.stiffness
        return CoulombNumbers(*numbers, bool(self.per_area))

    def changes(self, inp: FrictionInput, change: FrictionChange) -> FloatArray:
        """Return the changes (n, 3, m) of the forces with the input, at the same memory."""
        given, _ = _rows_of(inp, self.n_memory)
        ways, out = _changes_of(change)
        law = self._numbers
        run_ranges(friction_nb.coulomb_changes, len(out), GRAIN, given, law, ways, out)
        return out

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Friction forces inside the cone, and their work as stored and dissipated energy."""
        law = self._numbers
        given, out = _rows_of(inp, self.n_memory)
        n = len(given.force)
        run_ranges(straight(friction_nb.coulomb), n, GRAIN, given, law, out)
        loose = np.count_nonzero((given.force > 0.0) & ~(out.stiffness > 0.0))
        if loose:
            raise InputError(
                f"{loose} points have a normal force and no stiffness to stick by: the law of "
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

    It never sticks: a load below μ F slides, slowly. For those who are used to it, and where only
    fast sliding matters; `Coulomb` needs no such choice.

    Parameters
    ----------
    coefficient : μ ≥ 0
    speed : v₀ > 0; at this sliding speed the friction is 0.76 of its full size

    Notes
    -----
    It stores nothing. Lost is the work of the step, −½(t_old + t)·d with the tangential part d of
    the path, and t_old the force of the last step, carried along as by `Coulomb`: it is all that
    is remembered.

    Raises
    ------
    InputError
        A coefficient that is negative or not finite, a speed that is not above zero.

    Examples
    --------
    >>> along, up = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> ten, none = np.full(1, 10.0), np.zeros(1)
    >>> sliding = FrictionInput(up, up, ten, none, none, 0.1 * along, along, 0.1, np.zeros((1, 3)))
    >>> law = ViscousFriction(0.3, speed=0.01)
    >>> begun = law.respond(sliding)
    >>> goes_on = law.respond(sliding._replace(memory=begun.memory))
    >>> goes_on.force[0, 0].tolist(), begun.lost.round(12).tolist(), goes_on.lost.round(12).tolist()
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

    def slid(self, memory: FloatArray) -> FloatArray:
        """Return zeros (n, 3): no sliding distance is remembered."""
        return np.zeros((len(memory), 3))

    def viscosity(self, force: FloatArray, speed: FloatArray) -> FloatArray:
        """Return μ F tanh(v/v₀)/v (n,), friction by sliding speed (n,), at normal forces (n,).

        >>> ViscousFriction(0.3, speed=0.01).viscosity(np.array([10.0]), np.zeros(1)).round(9)
        array([300.])
        """
        part = np.maximum(speed / self.speed, 1e-9)
        return np.asarray(self.coefficient * force / self.speed * (np.tanh(part) / part))

    def changes(self, inp: FrictionInput, change: FrictionChange) -> FloatArray:
        """Return the changes (n, 3, m) of the forces with the input."""
        given, _ = _rows_of(inp, self.n_memory)
        ways, out = _changes_of(change)
        numbers = self.coefficient, self.speed
        run_ranges(friction_nb.viscous_changes, len(out), GRAIN, given, *numbers, ways, out)
        return out

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Forces against the sliding velocity."""
        given, out = _rows_of(inp, self.n_memory)
        numbers = self.coefficient, self.speed
        run_ranges(
            straight(friction_nb.viscous),
            len(given.force),
            GRAIN,
            given,
            *numbers,
            out,
        )
        return out


def _rows_of(inp: FrictionInput, n_memory: int) -> tuple[FrictionInput, FrictionOutput]:
    """The input as kernels read it, arrays of one row a point, and an output to be filled.

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
        arrays.append(_ready(values))
    rows, none = np.empty((n, 3)), (np.empty(n), np.empty(n), np.empty(n))
    return FrictionInput._make(arrays), FrictionOutput(rows, *none, np.empty((n, n_memory)))


def _changes_of(change: FrictionChange) -> tuple[FrictionChange, FloatArray]:
    """Directions as kernels read them, and an array (n, 3, m) to be filled."""
    ways = FrictionChange(*map(_ready, change))
    n, m = ways.force.shape
    return ways, np.empty((n, 3, m))


def _ready(values: Any) -> FloatArray:
    """An array as kernels read it. Those that a contact hands over are so, but for locked ones."""
    plain = isinstance(values, np.ndarray) and values.dtype == np.float64
    ready = plain and values.flags.carray
    return values if ready else np.array(values, np.float64, order="C")
