"""Align a part with the box of another, or its principal axes with x, y and z."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from contiga.arrays.ordered import principal_axes, product
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.placement.place import Part, check_part
from contiga.placement.sample import extent, points_of
from contiga.records import FloatArray
from contiga.rigid import transform
from contiga.slaves.slave import Slave

AXES = ("x", "y", "z")
_ALIKE_TOL = 1e-6
"""Share of the largest second moment within which two are equal: their axes are undefined."""
_HALF_TURNS = np.array(
    [np.diag(d) for d in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))], float
)


def align(
    thing: Part,
    *,
    to: Master | Slave | None = None,
    centres: Iterable[str] = (),
    lows: Iterable[str] = (),
    highs: Iterable[str] = (),
    axes: str | None = None,
) -> Part:
    """Return `thing` turned to its principal axes if `axes` is given, then moved box to box.

    The box of a slave is that of its active points; that of a body is the exact one. Coordinates
    that `centres`, `lows` and `highs` do not name do not change in the second step.

    Parameters
    ----------
    thing : a body or slave, which stays as it is
    to : the body or slave whose box counts; the origin if omitted
    centres : of "x", "y", "z": along these axes the middles of both boxes meet
    lows, highs : axes along which the low, or the high, ends of both boxes meet
    axes : "principal": turns the longest of the principal axes to x and the shortest to z, by the
        smallest rotation about the centre, which stays. The axes are those of the inertia of a
        closed body, of the area of an open one, of the active points of a slave. Axes whose
        moments differ by less than a millionth of the largest are not distinguished: a rod only
        has its long axis turned, a ball is not turned at all.

    Returns
    -------
    of the kind of `thing`

    Raises
    ------
    InputError
        Nothing to align is named, an axis is none of x, y, z or named twice, `axes` is no known
        kind, a slave has no active points.

    Examples
    --------
    >>> import contiga as cg
    >>> rod = cg.Body(cg.shapes.cylinder(radius=1.0, height=8.0))
    >>> pad = cg.Slave([[0.0, 0.0, 1.0], [10.0, 4.0, 3.0]])
    >>> laid = cg.align(rod, to=pad, centres="xy", lows="z", axes="principal")
    >>> laid.bounds().round(9).tolist()
    [[1.0, 1.0, 1.0], [9.0, 3.0, 3.0]]
    """
    check_part(thing, "thing")
    if to is not None:
        check_part(to, "to")
    ends = check_alignment(centres, lows, highs, axes)
    if axes is not None:
        thing = thing.transformed(_principal_rotation(thing))
    if not ends:
        return thing
    box = extent(thing)
    target_box = np.zeros((2, 3)) if to is None else extent(to)
    shift = np.zeros(3)
    for axis, weight in ends.items():
        shift[axis] = product(weight, target_box[:, axis] - box[:, axis])
    return thing.transformed(transform.translation(shift))


def check_alignment(
    centres: Iterable[str], lows: Iterable[str], highs: Iterable[str], axes: str | None
) -> dict[int, tuple[float, float]]:
    """Return the weights of the low and high ends of boxes, by the axes (0 to 2) that are aligned.

    The weighted means of both ends are what meets: (0.5, 0.5) for centres, (1, 0) for lows, (0, 1)
    for highs. Empty if only `axes` is given.

    Raises
    ------
    InputError
        `axes` is neither None nor "principal", a name is no axis, an axis is named twice, or
        nothing is to be aligned.
    """
    if axes not in (None, "principal"):
        raise InputError("unknown axes", where="axes", found=axes, allowed='"principal"')
    ends: dict[int, tuple[float, float]] = {}
    choices = (
        ("centres", centres, (0.5, 0.5)),
        ("lows", lows, (1.0, 0.0)),
        ("highs", highs, (0.0, 1.0)),
    )
    for key, names, weight in choices:
        for name in names:
            if name not in AXES:
                raise InputError("not an axis", where=key, found=name, allowed='"x", "y", "z"')
            if AXES.index(name) in ends:
                raise InputError(
                    "an axis is aligned twice", where=key, found=name, allowed="each axis once"
                )
            ends[AXES.index(name)] = weight
    if not ends and axes is None:
        raise InputError(
            "says nothing to align",
            allowed='centres, lows or highs of "x", "y", "z", or axes = "principal"',
        )
    return ends


def _principal_rotation(part: Master | Slave) -> FloatArray:
    """Return a rotation (4, 4) about the centre: longest principal axis to x, shortest to z.

    Long means a large second moment. The senses of the axes are those of the smallest rotation. If
    two axes have equal moments, only the third is turned, to x or z; if all three have, it is the
    identity.
    """
    centre, second = _second_moments(part)
    moments, axes = principal_axes(second)
    alike = moments[:2] - moments[1:] <= _ALIKE_TOL * moments[0]
    if alike.all():
        return np.eye(4)
    if alike.any():
        single = 0 if alike[1] else 2
        rotation = _smallest_rotation(axes[single], np.eye(3)[single])
    else:
        axes[2] = np.cross(axes[0], axes[1])
        rotations = [product(half, axes) for half in _HALF_TURNS]
        rotation = rotations[int(np.argmax([np.trace(r) for r in rotations]))]
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = centre - product(rotation, centre)
    return matrix


def _smallest_rotation(axis: FloatArray, target: FloatArray) -> FloatArray:
    """Return (3, 3) the smallest rotation of unit vector `axis` to `target` or its opposite."""
    direction = axis if float((axis * target).sum()) >= 0.0 else -axis
    normal = np.cross(direction, target)
    sine = float(np.sqrt(np.square(normal).sum()))
    if sine == 0.0:
        return np.eye(3)
    angle = float(np.arctan2(sine, (direction * target).sum()))
    return transform.rotation(normal, angle)[:3, :3]


def _second_moments(part: Master | Slave) -> tuple[FloatArray, FloatArray]:
    """Return the centre (3,) of a part and its second moments ∫ x xᵀ (3, 3) about it.

    The integral is over the volume of a closed body, over the area of an open one, tessellated to
    1e-4 of its size, and a sum over the active points of a slave.
    """
    if isinstance(part, Slave):
        points = points_of(part)
        centre = points.mean(axis=0)
        return centre, np.einsum("ni,nj->ij", points - centre, points - centre)
    if part.closed:
        solid = part.mass_properties(1.0)
        return solid.centre, 0.5 * np.trace(solid.inertia) * np.eye(3) - solid.inertia
    mesh = part.tessellate(1e-4 * part.size)
    corners, area = mesh.corners(), mesh.areas()
    centre = np.einsum("m,mi->i", area, corners.mean(axis=1)) / area.sum()
    arms = corners - centre
    arm_sum = arms.sum(axis=1)
    # Exact for a triangle: A/12 (Σ a aᵀ + s sᵀ), with the arms a of its corners and their sum s.
    second = np.einsum("m,mci,mcj->ij", area, arms, arms)
    second += np.einsum("m,mi,mj->ij", area, arm_sum, arm_sum)
    return centre, second / 12.0
