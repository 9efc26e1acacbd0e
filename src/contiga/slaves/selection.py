"""Selection of a part of a slave: its active facets and nodes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import real
from contiga.errors import MeshError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.curve_foot import CurveFeet
from contiga.records import FloatArray, IntArray
from contiga.slaves.quads import triangle_normals

BoolArray = NDArray[np.bool_]
BOX_TOL = 1e-9
"""Distance outside a box, over the extent of the slave, at which points count as on its border."""


def on_curve(points: FloatArray, curve: NurbsCurve, within: float) -> BoolArray:
    """Return (n,) which points (n, 3) are no further from a curve than the length `within`."""
    _, distances = CurveFeet(curve)(points)
    return np.asarray(distances <= within)


class Surface(NamedTuple):
    """The points and facets of a slave."""

    points: FloatArray
    """(n, 3)."""
    facets: IntArray | None
    """(m, 3) rows of `points`, None for a cloud."""
    quads: IntArray
    """(q, 2) rows of `facets` that are halves of quadrilaterals: selected together."""


class Selected(NamedTuple):
    """The selected facets and active points of a slave."""

    facets: IntArray | None
    """(k, 3) facets with all corners selected; None for a cloud."""
    active: BoolArray
    """(n,) their corners, and selected points that are on no facet."""


class Criteria(NamedTuple):
    """The conditions on a point or a facet; None for no condition."""

    nodes: ArrayLike | None = None
    """(n,) bool or rows of the points."""
    box: ArrayLike | None = None
    """(2, 3) lowest and highest corner, borders included."""
    side: tuple[ArrayLike, float] | None = None
    """Direction (3,), and the largest angle between it and normals, degrees."""


def select(surface: Surface, active: BoolArray, criteria: Criteria, where: str) -> Selected:
    """Return the facets that meet all criteria, and the mask of active points.

    Facets of a cloud are None. A facet is selected if all its corners are, and its normal is within
    the angle of `side`; of a quadrilateral both halves or none. Points on facets are active at
    selected facets only; points on no facet if they are selected, and there is no `side`.

    Parameters
    ----------
    surface : points and facets
    active : (n,) active points; others are never selected
    criteria : nodes, box and side
    where : name of the slave, for messages

    Raises
    ------
    MeshError
        An invalid criterion, a side of a cloud, or criteria that select nothing.
    """
    points, facets, quads = surface
    is_selected = active.copy()
    if criteria.nodes is not None:
        is_selected &= _as_mask(criteria.nodes, len(points), where)
    if criteria.box is not None and active.any():
        is_selected &= _in_box(points, criteria.box, points[active], where)
    if facets is None:
        if criteria.side is not None:
            raise MeshError("a cloud has no sides: it has no facets", where=f"{where}, side")
        return _checked(Selected(None, is_selected), where)
    facet_mask = facets_of(is_selected, facets, quads)
    if criteria.side is not None:
        facet_mask &= faces_to(surface, criteria.side, where)
        is_selected[:] = False  # points on no facet have no side
    is_selected[facets] = False
    is_selected[facets[facet_mask]] = True
    return _checked(Selected(np.ascontiguousarray(facets[facet_mask]), is_selected), where)


def facets_of(is_selected: BoolArray, facets: IntArray, quads: IntArray) -> BoolArray:
    """Return (m,) whether all corners of a facet are selected, and those of its other half."""
    mask: BoolArray = np.asarray(is_selected[facets].all(axis=1))
    mask[quads] = mask[quads].all(axis=1, keepdims=True)
    return mask


def _checked(selected: Selected, where: str) -> Selected:
    """Return the selection; raise MeshError if no point of it is active."""
    if not selected.active.any():
        kind = "points" if selected.facets is None else "whole facet"
        raise MeshError(
            f"no {kind} of it is chosen",
            where=where,
            remedy="Choose more: contiga info shows the bounds of a mesh and its parts",
        )
    return selected


def _as_mask(nodes: ArrayLike, count: int, where: str) -> BoolArray:
    """Return booleans (n,) or rows of points as a mask (n,); raise MeshError for other values."""
    array = np.asarray(real(nodes, where))
    if array.dtype == np.bool_ and array.shape == (count,):
        return array
    if array.dtype.kind in "iu" and array.ndim == 1 and ((array >= 0) & (array < count)).all():
        mask = np.zeros(count, dtype=bool)
        mask[array] = True
        return mask
    raise MeshError(
        "expected one boolean for each point, or the numbers of points",
        where=where,
        found=f"shape {array.shape} of {array.dtype}",
        allowed=f"({count},) of bool, or whole numbers from 0 to {count - 1}",
    )


def _in_box(points: FloatArray, box: ArrayLike, active: FloatArray, where: str) -> BoolArray:
    """Return (n,) which points are in a box, widened by `BOX_TOL` of the extent of active ones.

    Raises MeshError for an invalid box, and for one without active points.
    """
    corners = _numbers(box)
    if corners is None or corners.shape != (2, 3) or not (corners[0] <= corners[1]).all():
        raise MeshError(
            "a box needs its lowest and its highest corner",
            where=f"{where}, box",
            found=box,
            allowed="[[x, y, z], [x, y, z]], the first at most the second",
        )
    tol = BOX_TOL * float(np.ptp(active, axis=0).max(initial=0.0))
    low, high = corners[0] - tol, corners[1] + tol
    if not ((active >= low) & (active <= high)).all(axis=1).any():
        raise MeshError(
            "no point lies in the box",
            where=f"{where}, box",
            found=corners.tolist(),
            allowed=f"a box about some of {_rounded(active.min(axis=0))} to "
            f"{_rounded(active.max(axis=0))}",
        )
    mask: BoolArray = ((points >= low) & (points <= high)).all(axis=1)
    return mask


def _rounded(corner: FloatArray) -> list[float]:
    """Return coordinates with six digits, for messages."""
    return [float(f"{x:.6g}") for x in corner]


def faces_to(surface: Surface, side: tuple[ArrayLike, float], where: str) -> BoolArray:
    """Return (m,) which facets have a normal within an angle of a direction, the angle included.

    Both halves of a quadrilateral have its mean normal; facets without area are left out. Raises
    MeshError for an invalid direction or angle, and if no facet remains.
    """
    direction, angle = _numbers(side[0]), float(side[1])
    length = 0.0
    if direction is not None and direction.shape == (3,):
        length = float(np.sqrt((direction * direction).sum()))
    if direction is None or not (0.0 < length < np.inf):
        raise MeshError(
            "a direction is three numbers that are not all 0",
            where=f"{where}, side",
            found=side[0],
        )
    if not 0.0 < angle <= 180.0:
        raise MeshError(
            "an angle off a direction is in degrees",
            where=f"{where}, side",
            found=angle,
            allowed="above 0, up to 180",
        )
    points, facets, quads = surface
    assert facets is not None
    normals = triangle_normals(points, facets)
    normals[quads] = normals[quads].sum(axis=1)[:, None]
    lengths = np.sqrt((normals * normals).sum(axis=1))
    projections = (normals * (direction / length)).sum(axis=1)
    mask: BoolArray = (lengths > 0.0) & (projections >= np.cos(np.radians(angle)) * lengths)
    if not mask.any():
        raise MeshError(
            f"no facet faces that way to {angle:g} degrees",
            where=f"{where}, side",
            found=direction.tolist(),
            remedy="Normals are those of the facets: of shells as the file turns them",
        )
    return mask


def _numbers(values: Any) -> FloatArray | None:
    """Return `values` as a float64 array; None if they are not numbers or any is NaN."""
    real(values)
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return None if np.isnan(array).any() else array
