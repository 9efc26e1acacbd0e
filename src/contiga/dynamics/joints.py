"""Joints between two bodies: kinds, markers, and the relative motions that they allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, checked_choice, read_only
from contiga.arrays.ordered import length, product
from contiga.dynamics.joint_laws import JointLaw
from contiga.dynamics.joint_records import (
    ANGLE,
    AXES,
    CONE,
    OFFSET_A,
    OFFSET_W,
    SECOND_ANGLE,
    TRAVEL,
    TWIST,
)
from contiga.dynamics.springs import GROUND
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import cross


class Constraint(NamedTuple):
    """One scalar constraint of a joint; see `contiga.dynamics.joint_records`."""

    kind: int
    """OFFSET_W, OFFSET_A or AXES."""
    i: int
    """Number of a world axis, or of an axis of the first marker."""
    j: int = 0
    """Number of an axis of the second marker; AXES alone uses it."""


_SAME_POINT = tuple(Constraint(OFFSET_W, k) for k in range(3))
_SAME_LINE = (Constraint(OFFSET_A, 0), Constraint(OFFSET_A, 1))
_PARALLEL = (Constraint(AXES, 0, 2), Constraint(AXES, 1, 2))
_NO_ROTATION = (*_PARALLEL, Constraint(AXES, 0, 1))


class JointKind(NamedTuple):
    """The constraints of a kind of joint, and the coordinates that it leaves free."""

    constraints: tuple[Constraint, ...]
    coordinates: Mapping[str, int]
    """Kind of each free coordinate that results report, by name."""
    axes: int
    """Axes that it needs: 0 none, 1 one on both bodies or one on each, 2 one on each."""


KINDS: Mapping[str, JointKind] = {
    "spherical": JointKind(_SAME_POINT, {"cone": CONE, "twist": TWIST}, 0),
    "revolute": JointKind((*_SAME_POINT, *_PARALLEL), {"angle": ANGLE}, 1),
    "universal": JointKind(
        (*_SAME_POINT, Constraint(AXES, 2, 0)), {"angle_1": ANGLE, "angle_2": SECOND_ANGLE}, 2
    ),
    "cylindrical": JointKind((*_SAME_LINE, *_PARALLEL), {"angle": ANGLE, "travel": TRAVEL}, 1),
    "translational": JointKind((*_SAME_LINE, *_NO_ROTATION), {"travel": TRAVEL}, 1),
    "weld": JointKind((*_SAME_POINT, *_NO_ROTATION), {}, 0),
}
"""All kinds of joints, by name."""

_MIN_SINE = 1e-3
"""Least sine of the angle between the two axes of a universal joint."""


class Marker(NamedTuple):
    """The frame of a joint on one of its bodies at the start."""

    point: FloatArray
    """(3,) world coordinates, length."""
    axes: FloatArray
    """(3, 3) unit axes, one a row, world axes."""


@dataclass(frozen=True, init=False, eq=False)
class Joint:
    """A joint between two bodies, or a body and the ground.

    Parameters
    ----------
    kind : "spherical" (both bodies share a point), "revolute" (rotation about an axis),
        "universal" (rotation about an axis of the first body and one of the second, at right
        angles to each other), "cylindrical" (rotation about an axis and translation along it),
        "translational" (translation along an axis) or "weld" (no relative motion)
    first, second : names of the bodies; one of them may be "ground"
    at : (3,) point of the joint, length, world coordinates at the start; (2, 3) one point on each
        body if the bodies do not yet meet there
    axis : (3,) direction of the joint's axis, world axes at the start; (2, 3) one direction on
        each body, which a universal joint needs. A spherical joint measures its cone from it, z
        if omitted
    name : name in the results; "<first>-<second>" if empty
    angle, travel, angle_1, angle_2, cone, twist : `JointLaw` of a coordinate that the kind has:
        angle for revolute and cylindrical joints, travel for translational and cylindrical ones,
        angle_1 and angle_2 about the two axes of a universal joint, cone (angle between the axes
        on the two bodies) and twist (about them) of a spherical joint. Angles in radians, travels
        in length

    Notes
    -----
    Coordinates describe the second body relative to the first, positive by the right-hand rule
    about the axis. Each begins with the `start` of its law, 0 without one.

    Raises
    ------
    InputError
        An unknown kind, two ends on the same body, points or axes that are not finite, an axis
        without length, axes more than 90° apart, a law of a coordinate that the kind does not have.

    Examples
    --------
    >>> knee = Joint("revolute", "thigh", "shin", at=[0, 0, 40], axis=[0, 1, 0])
    >>> knee.name, list(knee.laws)
    ('thigh-shin', [])
    """

    kind: str
    between: tuple[str, str]
    at: FloatArray
    axis: FloatArray
    name: str
    laws: Mapping[str, JointLaw]
    """Laws by the name of their coordinate."""

    def __init__(
        self,
        kind: str,
        first: str,
        second: str,
        *,
        at: ArrayLike,
        axis: ArrayLike | None = None,
        name: str = "",
        angle: JointLaw | None = None,
        travel: JointLaw | None = None,
        angle_1: JointLaw | None = None,
        angle_2: JointLaw | None = None,
        cone: JointLaw | None = None,
        twist: JointLaw | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "kind", checked_choice("kind", kind, tuple(KINDS)))
        for key, end in (("first", first), ("second", second)):
            if not isinstance(end, str) or not end:
                raise InputError("must be the name of a body", where=key, found=end)
        if first == second:
            raise InputError(
                "both ends are of one body: the joint would constrain nothing",
                where="second",
                found=second,
                allowed=f'two bodies, or one and "{GROUND}"',
            )
        put(self, "between", (first, second))
        put(self, "at", _pair_of("at", at))
        put(self, "axis", _axes_of(self.kind, axis))
        put(self, "name", name or f"{first}-{second}")
        options = {
            "angle": angle,
            "travel": travel,
            "angle_1": angle_1,
            "angle_2": angle_2,
            "cone": cone,
            "twist": twist,
        }
        coordinates = KINDS[self.kind].coordinates
        laws = {key: law for key, law in options.items() if law is not None}
        for key, law in laws.items():
            if key not in coordinates:
                raise InputError(
                    f"a {self.kind} joint does not have this coordinate",
                    where=key,
                    allowed=", ".join(coordinates) or "none",
                )
            if not isinstance(law, JointLaw):
                raise InputError(
                    "must be a JointLaw", where=key, found=type(law).__name__, allowed="JointLaw(…)"
                )
        if "cone" in laws and laws["cone"].start != 0.0:
            raise InputError(
                "the axes on both bodies already set the cone at the start",
                where="cone: start",
                found=laws["cone"].start,
                allowed="0; give the start by axis = (2, 3)",
            )
        put(self, "laws", laws)

    def markers(self) -> tuple[Marker, Marker]:
        """Return the frames of the joint on the first and on the second body, axes a and b.

        The axes a_3 and b_3 are the joint's axis. The axes a_1 and b_1 are one direction
        perpendicular to it, rotated apart by the angle at the start. On a spherical joint b differs
        from a by the shortest rotation of a_3 to b_3, and by the twist at the start. On a universal
        joint a_3 is the axis on the first body and b_1 the axis on the second; a_1 is nearest to
        b_1, and b_3 nearest to a_3.
        """
        axis_1, axis_2 = self.axis
        if self.kind == "universal":
            angle = self._start("angle_1")
            a = _axes_with(axis_1, axis_2)
            first, _, third = _axes_with(axis_2, axis_1)
            b = np.array([third, cross(first, third), first])
            b = _rotate(b, b[0], self._start("angle_2"))
        else:
            angle = self._start("angle") + self._start("twist")
            a = _axes_with(axis_1, np.eye(3)[int(np.argmin(np.abs(axis_1)))])
            if self.kind == "spherical":
                normal = cross(a[2], axis_2)
                sine, cosine = length(normal), float(product(a[2], axis_2))
                normal = normal / sine if sine > 0.0 else a[1]
                b = _rotate(a, normal, math.atan2(sine, cosine))
            else:
                b = _axes_with(axis_2, a[0])
        a = _rotate(a, a[2], -angle)
        return Marker(self.at[0] - self._start("travel") * axis_1, a), Marker(self.at[1], b)

    def _start(self, coordinate: str) -> float:
        """Return a coordinate at the start: radians, or length."""
        law = self.laws.get(coordinate)
        return 0.0 if law is None else law.start


def _pair_of(where: str, vectors: ArrayLike) -> FloatArray:
    """Return (2, 3) from one vector for both bodies, or one for each, read-only.

    An `InputError` is raised for another shape, or numbers that are not finite.
    """
    allowed = "(3,) for both bodies, or (2, 3) one each"
    pair = as_numbers(vectors, where, "must be three numbers, or three for each body", allowed)
    if pair.shape not in ((3,), (2, 3)) or not np.isfinite(pair).all():
        raise InputError(
            "must be three finite numbers, or three for each body",
            where=where,
            found=np.asarray(vectors).tolist(),
            allowed=allowed,
        )
    return read_only(np.broadcast_to(pair, (2, 3)).copy())


def _axes_of(kind: str, axis: ArrayLike | None) -> FloatArray:
    """Return the unit axes (2, 3) of a joint on both bodies; z if it needs none and has none.

    An `InputError` is raised for a missing axis, one without length, axes of a universal joint
    with a sine below `_MIN_SINE`, and axes at 90° or more where the kind aligns them.
    """
    axes_needed = KINDS[kind].axes
    if axis is None and axes_needed:
        raise InputError(
            f"is missing: a {kind} joint needs it",
            where="axis",
            allowed="(3,) for both bodies, or (2, 3) one each",
        )
    pair = _pair_of("axis", (0.0, 0.0, 1.0) if axis is None else axis)
    lengths = np.array([length(vector) for vector in pair])
    if not (lengths > 0.0).all():
        raise InputError(
            "has no length",
            where="axis",
            found=np.asarray(axis).tolist(),
            allowed="a direction: not all components zero",
        )
    units = pair / lengths[:, None]
    cosine = float(product(units[0], units[1]))
    if axes_needed == 2 and length(cross(units[0], units[1])) < _MIN_SINE:
        raise InputError(
            "the two axes of a universal joint must differ, and these are parallel",
            where="axis",
            found=pair.tolist(),
            allowed="(2, 3) the axis on the first body and the one on the second, at a right angle",
        )
    if axes_needed == 1 and cosine <= 0.0:
        raise InputError(
            f"the axes on the two bodies are {math.degrees(math.acos(max(cosine, -1.0))):.0f}° "
            "apart: the direction in which they are to be aligned is ambiguous",
            where="axis",
            found=pair.tolist(),
            allowed="two axes less than 90° apart",
        )
    return read_only(units)


def _axes_with(third: FloatArray, towards: FloatArray) -> FloatArray:
    """Return right-handed axes, one a row, with a given third and the first nearest a direction.

    They are NaN if the direction is parallel to the third.
    """
    first = towards - float(product(towards, third)) * third
    first = first / length(first)
    return np.array([first, cross(third, first), third])


def _rotate(axes: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
    """Return axes, one a row, rotated about a unit axis by an angle (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    parallel = product(axes, axis)[:, None] * axis
    return np.asarray(parallel + c * (axes - parallel) + s * cross(np.tile(axis, (3, 1)), axes))
