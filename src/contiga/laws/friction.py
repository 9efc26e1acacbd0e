"""Friction: from normal force and sliding to the tangential force on each point in contact.

All vectors are in the axes of the master, whose frame moves with it: a rigid motion of the whole
scene makes no sliding. Forces are those on the slave; the master feels the opposite at the same
places.

`Coulomb` sticks and slips by a return mapping (Simo & Hughes, Computational Inelasticity, 1998,
ch. 1; Wriggers, Computational Contact Mechanics, 2006, 5.2): a spring in the tangent plane is
stretched by the sliding, and cut back to the cone where it exceeds it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple, Protocol

import numpy as np

from contiga.errors import InputError
from contiga.laws.law import above_zero, not_negative
from contiga.records import FloatArray


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
    """Length of the step, zero at the start."""
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
    """(n, m) what friction wants to see of each point at the next step."""


class Friction(Protocol):
    """What a contact asks of friction."""

    @property
    def n_memory(self) -> int:
        """Numbers a point that it keeps from one step to the next."""

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Tangential forces, energies and memory of the points in contact."""

    def slid(self, memory: FloatArray) -> FloatArray:
        """(n, 3) way slid since each point came in, from what is kept of it (n, m)."""


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
        """Whether the force depends on the velocity: whether the coefficient falls with it."""
        return self.decay > 0.0 and self.dynamic not in (None, self.static)

    def coefficient(self, speed: FloatArray) -> FloatArray:
        """μ at sliding speeds (n,) ≥ 0."""
        least = self.static if self.dynamic is None else self.dynamic
        return np.asarray(least + (self.static - least) * np.exp(-self.decay * speed))

    def slid(self, memory: FloatArray) -> FloatArray:
        """(n, 3) sliding distance since each point came in."""
        return memory[:, 3:6]

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Friction forces inside the cone, and their work as stored and dissipated energy."""
        return _in_blocks(self._respond, inp, self.n_memory)

    def _respond(self, inp: FrictionInput) -> FrictionOutput:
        memory = _columns(inp.memory)
        before, kept = memory[:3], memory[6]
        stiffness = np.maximum(kept, self._given(inp))
        self._check_stiffness(stiffness, inp.force)
        normal = _columns(inp.normal)
        carry = _Carry(_columns(inp.normal_before), normal)
        carried, path = carry(before), carry.along(_columns(inp.path))
        pulled = np.where(kept > 0.0, 0.5 * (kept + stiffness), stiffness)
        trial = carried - pulled * path
        limit = self._coefficient(inp.velocity, normal) * inp.force
        traction = _returned_to_cone(trial, limit)
        slid = path - _shared(carried - traction, pulled)
        stored = _energy(traction, stiffness)
        lost = np.maximum(-0.5 * _dot(carried + traction, slid), 0.0)
        lost += np.maximum(_energy(before, kept) - _energy(before, pulled), 0.0)
        lost += np.maximum(_energy(traction, pulled) - stored, 0.0)
        left = np.vstack([traction, carry(memory[3:6]) + path, stiffness])
        return FrictionOutput(_columns(traction), stiffness, stored, lost, _columns(left))

    def _coefficient(self, velocity: FloatArray, normal: FloatArray) -> FloatArray | float:
        if self.decay == 0.0:
            return self.static
        return self.coefficient(_length(_tangential(_columns(velocity), normal)))

    def _given(self, inp: FrictionInput) -> FloatArray:
        """(n,) k_t as this step has it."""
        if self.stiffness == 0.0:
            return np.maximum(inp.stiffness, 0.0)
        return self.stiffness * (inp.area if self.per_area else np.ones(len(inp.area)))

    def _check_stiffness(self, stiffness: FloatArray, force: FloatArray) -> None:
        loose = np.count_nonzero((force > 0.0) & ~(stiffness > 0.0))
        if loose:
            raise InputError(
                f"{loose} points have a normal force and no stiffness to stick by: the law of "
                "normal force has none there, and friction was given none",
                where="friction.stiffness",
                found=self.stiffness,
                allowed="above zero",
                remedy="Give one, such as Coulomb(0.4, stiffness=100.0)",
            )


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
        put(self, "speed", above_zero(self.speed, "speed"))

    n_memory = 3
    has_rate = True

    def slid(self, memory: FloatArray) -> FloatArray:
        """(n, 3) zeros: it has no memory."""
        return np.zeros((len(memory), 3))

    def viscosity(self, force: FloatArray, speed: FloatArray) -> FloatArray:
        """(n,) friction over sliding speed (n,) at normal forces (n,): μ F tanh(v/v₀)/v.

        >>> ViscousFriction(0.3, speed=0.01).viscosity(np.array([10.0]), np.zeros(1)).round(9)
        array([300.])
        """
        part = np.maximum(speed / self.speed, 1e-9)
        return np.asarray(self.coefficient * force / self.speed * (np.tanh(part) / part))

    def respond(self, inp: FrictionInput) -> FrictionOutput:
        """Forces against the sliding velocity."""
        return _in_blocks(self._respond, inp, self.n_memory)

    def _respond(self, inp: FrictionInput) -> FrictionOutput:
        normal = _columns(inp.normal)
        velocity = _tangential(_columns(inp.velocity), normal)
        speed = _length(velocity)
        size = self.coefficient * inp.force * np.tanh(speed / self.speed)
        force = -size * _shared(velocity, speed)
        carry = _Carry(_columns(inp.normal_before), normal)
        before, path = carry(_columns(inp.memory)), carry.along(_columns(inp.path))
        lost = np.maximum(-0.5 * _dot(before + force, path), 0.0)
        none, rows = np.zeros(len(size)), _columns(force)
        return FrictionOutput(rows, none, none, lost, rows)


# Points at a time: what is worked on stays in the cache, 1.3 times as fast with 100,000 points.
_BLOCK = 4096


def _in_blocks(
    respond: Callable[[FrictionInput], FrictionOutput], inp: FrictionInput, columns: int
) -> FrictionOutput:
    """The answers to some points at a time, one after the other."""
    n = len(inp.force)
    if inp.memory.shape != (n, columns):
        raise InputError(
            "the memory is of another friction",
            where="memory",
            found=inp.memory.shape,
            allowed=str((n, columns)),
        )
    parts = []
    for k in range(0, max(n, 1), _BLOCK):
        rows = slice(k, k + _BLOCK)
        part = (v[rows] if isinstance(v, np.ndarray) else v for v in inp)
        parts.append(respond(FrictionInput._make(part)))
    return FrictionOutput(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))


class _Carry:
    """The smallest rotation that takes each normal of the last step to the present one.

    For vectors across the old normal that is the reflection in the plane across the sum of both,
    which keeps lengths to rounding. Where the normals are opposite there is no smallest rotation:
    the vectors lie in the new plane already.
    """

    def __init__(self, before: FloatArray, now: FloatArray) -> None:
        self._now, self._both = now, before + now
        square = _dot(self._both, self._both)
        self._twice = np.zeros(len(square))
        np.divide(2.0, square, out=self._twice, where=square > 0.0)

    def __call__(self, vectors: FloatArray) -> FloatArray:
        turned = vectors - self._twice * _dot(self._both, vectors) * self._both
        # Rounding must not leave the plane step by step.
        return _tangential(turned, self._now)

    def along(self, path: FloatArray) -> FloatArray:
        """The tangential part of a step's path: the mean of what the planes at its two ends see.

        One plane alone would see a way back as another than the way there where the normal turns
        while the point goes deeper: sticking points would creep, and the work be of first order.
        """
        return 0.5 * (self(path) + _tangential(path, self._now))


# From here on vectors are columns, (3, n): 1.4 times as fast in all as rows of three.
def _columns(rows: FloatArray) -> FloatArray:
    return np.ascontiguousarray(rows.T)


def _tangential(vectors: FloatArray, normal: FloatArray) -> FloatArray:
    """What of `vectors` lies in the planes across the unit `normal`."""
    return vectors - _dot(vectors, normal) * normal


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(one[0] * other[0] + one[1] * other[1] + one[2] * other[2])


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(_dot(vectors, vectors)))


def _returned_to_cone(vectors: FloatArray, limit: FloatArray) -> FloatArray:
    """Tractions no longer than `limit`, in their own directions."""
    length = _length(vectors)
    factor = np.ones(len(length))
    np.divide(limit, length, out=factor, where=length > limit)
    return vectors * factor


def _shared(vectors: FloatArray, by: FloatArray) -> FloatArray:
    """Vectors divided by a number each, zero where that is zero."""
    out = np.zeros(vectors.shape)
    np.divide(vectors, by, out=out, where=by > 0.0)
    return out


def _energy(traction: FloatArray, stiffness: FloatArray) -> FloatArray:
    """t²/(2 k), zero without a spring."""
    out = np.zeros(len(stiffness))
    np.divide(0.5 * _dot(traction, traction), stiffness, out=out, where=stiffness > 0.0)
    return out
