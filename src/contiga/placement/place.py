"""Putting a part at a gap from another."""

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
    """`thing` moved along `direction` until its smallest gap to `on` is `gap`.

    A start that is free, with no point nearer than `gap`, is moved forward to the first place that
    is not nearer; one that is nearer or overlaps is moved back to the last such place behind it.
    Nothing but the way along the line changes. Behind the faces of an open body counts as inside.
    If it meets a closed one and there is no such place, it is a sheet, which is free on both sides.

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
        Two slaves, a gap that is negative, a direction that is zero; or `thing` never comes so
        near to `on` on this way, comes round a border of it, or the gap is not settled.

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
    way, least = unit_axis(direction, "direction"), _checked_gap(gap)
    shift = _shift(thing, on, way, least)
    if shift is None:
        raise InputError(
            f"{thing.name} never has a gap of {least:g} from {on.name} on its path",
            where="direction",
            found=[float(f"{x:.6g}") for x in way],
            remedy=f"Turn the direction towards it, or align the two first{_open_side(thing, on)}",
        )
    return thing.transformed(translation(shift * way))


def _shift(
    thing: Master | Slave, on: Master | Slave, way: FloatArray, least: float
) -> float | None:
    """Return how far `thing` is to be moved; None if there is no place for it."""
    span, on_span = _along(thing, way), _along(on, way)
    most = (on_span[1] - span[0] + least, span[1] - on_span[0] + least)
    try:
        shift = shift_to_gap(Pair(thing, on, way), least, most)
    except InputError:
        if not _is_sheet(thing, on):
            raise
        shift = None
    if shift is None and _is_sheet(thing, on):
        return shift_to_gap(Pair(thing, on, way, both=True), least, most)
    return shift


def _is_sheet(thing: Master | Slave, on: Master | Slave) -> bool:
    """Return whether an open body is to stand by a closed one."""
    bodies = [part.closed for part in (thing, on) if not isinstance(part, Slave)]
    return sorted(bodies) == [False, True]


def _open_side(thing: Master | Slave, on: Master | Slave) -> str:
    """Return the end of a sentence: which side of open bodies may be in the way."""
    names = [part.name for part in (thing, on) if not isinstance(part, Slave) and not part.closed]
    if not names:
        return ""
    are = "is" if len(names) == 1 else "are"
    return (
        f", or swap the free side of {names[-1]} (flip = true): {' and '.join(names)} {are} open, "
        "and what is behind an open face counts as inside"
    )


def check_part(value: object, where: str) -> None:
    """Refuse what is neither a body nor a slave."""
    if not isinstance(value, Slave) and not is_master(value):
        raise InputError(
            "must be a body or a slave",
            where=where,
            found=type(value).__name__,
            allowed="a Body, a TriMesh or a Slave",
        )


def _checked_gap(gap: float) -> float:
    if isinstance(gap, bool) or not isinstance(gap, int | float | np.number):
        raise InputError("must be a number", where="gap", found=gap, allowed=">= 0")
    if not 0.0 <= gap < np.inf:
        raise InputError("must be a finite number, not below zero", where="gap", found=float(gap))
    return float(gap)


def _along(part: Master | Slave, way: FloatArray) -> tuple[float, float]:
    """Between what numbers a part lies along `way`, at most."""
    corners = np.array(list(choices(*part.bounds().T)))
    reach = product(corners, way)
    return float(reach.min()), float(reach.max())
