"""Place a part at a gap from another."""

from __future__ import annotations

from itertools import product as choices
from typing import TypeVar

import numpy as np

from contiga.arrays.ordered import product
from contiga.errors import InputError
from contiga.masters.body import Body
from contiga.masters.protocol import Master, is_master
from contiga.placement.approach import shift_to_gap
from contiga.placement.pair import Pair
from contiga.records import FloatArray
from contiga.rigid.transform import Axis, translation, unit_axis
from contiga.slaves.slave import Slave
from contiga.triangles.trimesh import TriMesh

Part = TypeVar("Part", Body, TriMesh, Slave, Body | TriMesh | Slave)


def place(thing: Part, *, on: Master | Slave, direction: Axis, gap: float = 0.0) -> Part:
    """Return `thing` moved along `direction` until its smallest gap to `on` is `gap`.

    If no point of `thing` is nearer than `gap` at the start, it moves forward to the first place
    with this gap; if it is nearer or overlaps, it moves back to the last such place behind it. Only
    the position along the line changes. Points behind the faces of an open body count as inside. If
    an open body meets a closed one and there is no such place, the open body is taken as a sheet,
    which is free on both sides.

    Between a body and a slave the gap is that of the slave's active points, to 1e-10 of the body's
    size; past the border of an open body it is the distance, on both sides. Of two bodies samples
    find where they come closest, 1/25 of their sizes apart, and exact projections sharpen it to the
    same tolerance: only a feature smaller than that, at which alone they would touch first, can be
    missed.

    Parameters
    ----------
    thing : a body or slave, which stays as it is
    on : a body, or a slave if `thing` is a body
    direction : "x", "y", "z" or a vector of any length
    gap : at least 0, length

    Returns
    -------
    of the kind of `thing`

    Raises
    ------
    InputError
        Two slaves, a slave without active points, a gap that is negative or not finite, a direction
        that is zero; or `thing` has this gap nowhere on its path, comes round a border, or the gap
        is not settled.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body(cg.shapes.sphere(radius=20.0))
    >>> sheet = cg.Slave([[0.0, 0.0, -5.0], [12.0, 0.0, -90.0]])
    >>> above = cg.place(ball, on=sheet, direction=[0, 0, -1], gap=2.0)
    >>> above.bounds()[0].round(9).tolist()
    [-20.0, -20.0, -3.0]
    """
    for key, value in (("thing", thing), ("on", on)):
        check_part(value, key)
    axis = unit_axis(direction, "direction")
    if isinstance(gap, bool) or not isinstance(gap, int | float | np.number):
        raise InputError("must be a number", where="gap", found=gap, allowed=">= 0")
    gap = float(gap)
    if not 0.0 <= gap < np.inf:
        raise InputError("must be a finite number, not below zero", where="gap", found=gap)
    # Beyond these distances the parts are apart by more than the gap.
    (low, high), (on_low, on_high) = _span(thing, axis), _span(on, axis)
    limits = (on_high - low + gap, high - on_low + gap)
    may_be_sheet = sorted(body.closed for body in _bodies(thing, on)) == [False, True]
    shift: float | None = None
    try:
        shift = shift_to_gap(Pair(thing, on, axis), gap, limits)
    except InputError:
        if not may_be_sheet:
            raise
    if shift is None and may_be_sheet:
        shift = shift_to_gap(Pair(thing, on, axis, open_is_sheet=True), gap, limits)
    if shift is None:
        remedy = "Turn the direction towards it, or align the two first"
        open_bodies = [part.name for part in _bodies(thing, on) if not part.closed]
        if open_bodies:
            are = "is" if len(open_bodies) == 1 else "are"
            remedy += (
                f", or swap the free side of {open_bodies[-1]} (flip = true): "
                f"{' and '.join(open_bodies)} {are} open, "
                "and what is behind an open face counts as inside"
            )
        raise InputError(
            f"{thing.name} never has a gap of {gap:g} from {on.name} on its path",
            where="direction",
            found=[float(f"{x:.6g}") for x in axis],
            remedy=remedy,
        )
    return thing.transformed(translation(shift * axis))


def _bodies(*parts: Master | Slave) -> list[Master]:
    return [part for part in parts if not isinstance(part, Slave)]


def _span(part: Master | Slave, axis: FloatArray) -> tuple[float, float]:
    """Return the lowest and highest coordinate along `axis` of the corners of the part's box."""
    heights = product(np.array(list(choices(*part.bounds().T))), axis)
    return float(heights.min()), float(heights.max())


def check_part(value: object, where: str) -> None:
    """Raise InputError for a value that is neither a body nor a slave."""
    if not isinstance(value, Slave) and not is_master(value):
        raise InputError(
            "must be a body or a slave",
            where=where,
            found=type(value).__name__,
            allowed="a Body, a TriMesh or a Slave",
        )
