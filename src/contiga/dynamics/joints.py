"""Joints between two bodies: which of their motions against each other they allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, one_of, read_only
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

_POINT = tuple((OFFSET_W, k, 0) for k in range(3))
_LINE = ((OFFSET_A, 0, 0), (OFFSET_A, 1, 0))
_PARALLEL = ((AXES, 0, 2), (AXES, 1, 2))
_NO_TURN = (*_PARALLEL, (AXES, 0, 1))


class JointKind(NamedTuple):
    """What a kind of joint holds, and what it leaves free."""

    rows: tuple[tuple[int, int, int], ...]
    """Constraint rows: kind, i, j."""
    coordinates: Mapping[str, int]
    """Coordinates that it leaves free and tells, and their kinds."""
    axes: int
    """Axes that it needs: 0 none, 1 one for both bodies or one each, 2 one each."""


KINDS: Mapping[str, JointKind] = {
    "spherical": JointKind(_POINT, {"cone": CONE, "twist": TWIST}, 0),
    "revolute": JointKind((*_POINT, *_PARALLEL), {"angle": ANGLE}, 1),
    "universal": JointKind((*_POINT, (AXES, 2, 0)), {"angle_1": ANGLE, "angle_2": SECOND_ANGLE}, 2),
    "cylindrical": JointKind((*_LINE, *_PARALLEL), {"angle": ANGLE, "travel": TRAVEL}, 1),
    "translational": JointKind((*_LINE, *_NO_TURN), {"travel": TRAVEL}, 1),
    "weld": JointKind((*_POINT, *_NO_TURN), {}, 0),
}
"""The joints there are, by name."""

_ALONG = 1e-3
"""Sine of the angle between the axes of a universal joint below which it has one axis."""


class Marker(NamedTuple):
    """The frame of a joint on one of its bodies, world axes at the start."""

    point: FloatArray
    """(3,)."""
    axes: FloatArray
    """(3, 3) one a row."""


@dataclass(frozen=True, init=False, eq=False)
class Joint:
    """A joint between two bodies, or a body and the ground.

    Parameters
    ----------
    kind : "spherical" (one point in common), "revolute" (turns about an axis), "universal" (turns
        about an axis of the first body and one of the second, which are at right angles),
        "cylindrical" (turns about an axis and slides along it), "translational" (slides along an
        axis) or "weld"
    first, second : names of the bodies; one may be "ground"
    at : (3,) point of the joint, world coordinates at the start; (2, 3) where it is on either
        body, if these do not yet stand where the joint has them
    axis : (3,) direction of its axis, world axes at the start; (2, 3) that on either body, as a
        universal joint needs; a spherical one measures its cone from it, z if omitted
    name : how results call it; "<first>-<second>" if empty
    angle, travel, angle_1, angle_2, cone, twist : `JointLaw` of the coordinates that the kind has:
        an angle of a revolute and a cylindrical joint, the travel of a translational and a
        cylindrical one, the angles about both axes of a universal one, the cone of a spherical one
        (angle between the axes on both bodies) and its twist about them

    Notes
    -----
    Coordinates are of the second body against the first, by the right hand about the axis, and
    begin with the `start` of their law.

    Raises
    ------
    InputError
        No such kind, both ends on one body, points or axes that are not finite, an axis of no
        length, axes that point apart, a law of a coordinate that the kind does not have.

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
    """By coordinate."""

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
        put(self, "kind", one_of("kind", kind, tuple(KINDS)))
        for key, end in (("first", first), ("second", second)):
            if not isinstance(end, str) or not end:
                raise InputError("must be the name of a body", where=key, found=end)
        if first == second:
            raise InputError(
                "both ends are of one body: the joint would hold nothing",
                where="second",
                found=second,
                allowed=f'two bodies, or one and "{GROUND}"',
            )
        put(self, "between", (first, second))
        put(self, "at", _pair_of("at", at))
        put(self, "axis", _axes_of(self.kind, axis))
        put(self, "name", name or f"{first}-{second}")
        given = {"angle": angle, "travel": travel, "angle_1": angle_1, "angle_2": angle_2}
        given |= {"cone": cone, "twist": twist}
        own = KINDS[self.kind].coordinates
        laws = {key: law for key, law in given.items() if law is not None}
        for key, law in laws.items():
            if key not in own:
                raise InputError(
                    f"a {self.kind} joint does not have it",
                    where=key,
                    allowed=", ".join(own) or "none",
                )
            if not isinstance(law, JointLaw):
                raise InputError(
                    "must be a JointLaw", where=key, found=type(law).__name__, allowed="JointLaw(…)"
                )
        if "cone" in laws and laws["cone"].start != 0.0:
            raise InputError(
                "a cone starts as the axes on both bodies do",
                where="cone: start",
                found=laws["cone"].start,
                allowed="0; axis = (2, 3) says where it starts",
            )
        put(self, "laws", laws)

    def markers(self) -> tuple[Marker, Marker]:
        """Return the frames of the joint on both bodies.

        The axes a_3 and b_3 are that of the joint; a_1 and b_1 are one direction at a right angle
        to it, turned apart by the `start` of an angle. Of a universal joint a_3 is the first axis,
        b_1 the second one, and a_1 and b_3 are nearest to the respective other.
        """
        one, two = self.axis
        first = "angle_1" if self.kind == "universal" else "angle"
        turned = self._start(first) + self._start("twist")
        if self.kind == "universal":
            a = _axes_with(one, two)
            near = _axes_with(two, one)
            b = np.array([near[2], cross(near[0], near[2]), near[0]])
            b = _turned(b, b[0], self._start("angle_2"))
        else:
            a = _axes_with(one, _across(one))
            b = _axes_with(two, a[0])
        a = _turned(a, a[2], -turned)
        return Marker(self.at[0] - self._start("travel") * one, a), Marker(self.at[1], b)

    def _start(self, coordinate: str) -> float:
        law = self.laws.get(coordinate)
        return 0.0 if law is None else law.start


def _pair_of(where: str, given: ArrayLike) -> FloatArray:
    """(2, 3) of one vector for both bodies, or one each."""
    allowed = "(3,) for both bodies, or (2, 3) one each"
    values = as_numbers(given, where, "must be three numbers, or three for each body", allowed)
    if values.shape not in ((3,), (2, 3)) or not np.isfinite(values).all():
        raise InputError(
            "must be three finite numbers, or three for each body",
            where=where,
            found=np.asarray(given).tolist(),
            allowed=allowed,
        )
    return read_only(np.broadcast_to(values, (2, 3)).copy())


def _axes_of(kind: str, axis: ArrayLike | None) -> FloatArray:
    """(2, 3) unit axes of a joint on both bodies."""
    needed = KINDS[kind].axes
    if axis is None and needed:
        raise InputError(
            f"is missing: a {kind} joint needs it",
            where="axis",
            allowed="(3,) for both bodies, or (2, 3) one each",
        )
    pair = _pair_of("axis", (0.0, 0.0, 1.0) if axis is None else axis)
    sizes = np.array([length(one) for one in pair])
    if not (sizes > 0.0).all():
        raise InputError("has no length", where="axis", found=np.asarray(axis).tolist())
    units = pair / sizes[:, None]
    cosine = float(product(units[0], units[1]))
    if needed == 2 and length(cross(units[0], units[1])) < _ALONG:
        raise InputError(
            "a universal joint turns about two axes, and these are one",
            where="axis",
            found=pair.tolist(),
            allowed="(2, 3) the axis on the first body and the one on the second, at a right angle",
        )
    if needed == 1 and cosine <= 0.0:
        raise InputError(
            f"the axes on the two bodies are {math.degrees(math.acos(max(cosine, -1.0))):.0f}° "
            "apart: it is not known which way round they are to meet",
            where="axis",
            found=pair.tolist(),
            allowed="two axes less than 90° apart",
        )
    return read_only(units)


def _across(axis: FloatArray) -> FloatArray:
    """A direction at a right angle to a unit axis."""
    other = np.zeros(3)
    other[int(np.argmin(np.abs(axis)))] = 1.0
    return other


def _axes_with(third: FloatArray, towards: FloatArray) -> FloatArray:
    """Right-handed axes, one a row: the third is given, the first is nearest to a direction."""
    first = towards - float(product(towards, third)) * third
    first = first / length(first)
    return np.array([first, cross(third, first), third])


def _turned(axes: FloatArray, about: FloatArray, angle: float) -> FloatArray:
    """Axes, one a row, turned about a unit axis (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    along = product(axes, about)[:, None] * about
    return np.asarray(along + c * (axes - along) + s * cross(np.tile(about, (3, 1)), axes))
