"""Choosing part of a slave: the facets that take part, and with them the nodes."""

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
ROUNDING = 1e-9
"""Points this share of the slave's extent outside a box count as on its border."""


def on_curve(points: FloatArray, curve: NurbsCurve, within: float) -> BoolArray:
    """Return which points (n, 3) are no further from a curve than `within`, length (n,)."""
    _, distances = CurveFeet(curve)(points)
    return np.asarray(distances <= within)


class Surface(NamedTuple):
    """The points, facets and normals to choose from."""

    points: FloatArray
    """(n, 3)."""
    facets: IntArray | None
    """(m, 3) rows of `points`, None for a cloud."""
    quads: IntArray
    """(q, 2) rows of `facets` that are the halves of quadrilaterals: chosen together."""


class Selected(NamedTuple):
    """The facets and active points that are left of a slave."""

    facets: IntArray | None
    """(k, 3) those with all corners chosen; None for a cloud."""
    active: BoolArray
    """(n,) their corners; of what no facet has, the points chosen."""


class Criteria(NamedTuple):
    """The conditions on a point or a facet; None asks nothing."""

    nodes: ArrayLike | None = None
    """(n,) bool or rows of the points."""
    box: ArrayLike | None = None
    """(2, 3) lowest and highest corner, borders included."""
    side: tuple[ArrayLike, float] | None = None
    """Direction (3,), and how many degrees normals may be off it."""


def select(surface: Surface, active: BoolArray, criteria: Criteria, where: str) -> Selected:
    """Facets whose corners are all chosen and whose normal points the way asked for.

    Parameters
    ----------
    surface : points and facets
    active : (n,) points that take part so far; others are never chosen
    criteria : sets of nodes and directions of normals
    where : whose points they are, for messages

    Raises
    ------
    MeshError
        A criterion that is none, or one that leaves nothing.
    """
    points, facets, quads = surface
    chosen = active.copy()
    if criteria.nodes is not None:
        chosen &= _as_mask(criteria.nodes, len(points), where)
    if criteria.box is not None and active.any():
        chosen &= _in_box(points, criteria.box, points[active], where)
    if facets is None:
        if criteria.side is not None:
            raise MeshError("a cloud has no sides: it has no facets", where=f"{where}, side")
        return _checked(Selected(None, chosen), where)
    kept = facets_of(chosen, facets, quads)
    if criteria.side is not None:
        kept &= faces_to(surface, criteria.side, where)
    on_facets = np.zeros(len(points), dtype=bool)
    on_facets[facets] = True
    result = chosen & ~on_facets if criteria.side is None else np.zeros(len(points), dtype=bool)
    result[facets[kept]] = True
    return _checked(Selected(np.ascontiguousarray(facets[kept]), result), where)


def facets_of(chosen: BoolArray, facets: IntArray, quads: IntArray) -> BoolArray:
    """Return (m,) facets all of whose corners are among chosen points, quadrilaterals whole."""
    kept: BoolArray = np.asarray(chosen[facets].all(axis=1))
    kept[quads] = kept[quads].all(axis=1, keepdims=True)
    return kept


def _checked(selected: Selected, where: str) -> Selected:
    if not selected.active.any():
        what = "points" if selected.facets is None else "whole facet"
        raise MeshError(
            f"no {what} of it is chosen",
            where=where,
            remedy="Choose more: contiga info shows the bounds of a mesh and its parts",
        )
    return selected


def _as_mask(nodes: ArrayLike, count: int, where: str) -> BoolArray:
    given = np.asarray(real(nodes, where))
    if given.dtype == np.bool_ and given.shape == (count,):
        return given
    if given.dtype.kind in "iu" and given.ndim == 1 and ((given >= 0) & (given < count)).all():
        mask = np.zeros(count, dtype=bool)
        mask[given] = True
        return mask
    raise MeshError(
        "expected one boolean for each point, or the numbers of points",
        where=where,
        found=f"shape {given.shape} of {given.dtype}",
        allowed=f"({count},) of bool, or whole numbers from 0 to {count - 1}",
    )


def _in_box(points: FloatArray, box: ArrayLike, active: FloatArray, where: str) -> BoolArray:
    corners = _numbers(box)
    if corners is None or corners.shape != (2, 3) or not (corners[0] <= corners[1]).all():
        raise MeshError(
            "a box needs its lowest and its highest corner",
            where=f"{where}, box",
            found=box,
            allowed="[[x, y, z], [x, y, z]], the first at most the second",
        )
    near = ROUNDING * float(np.ptp(active, axis=0).max(initial=0.0))
    low, high = corners[0] - near, corners[1] + near
    if not ((active >= low) & (active <= high)).all(axis=1).any():
        raise MeshError(
            "no point lies in the box",
            where=f"{where}, box",
            found=corners.tolist(),
            allowed=f"a box about some of {_rounded(active.min(axis=0))} to "
            f"{_rounded(active.max(axis=0))}",
        )
    inside: BoolArray = ((points >= low) & (points <= high)).all(axis=1)
    return inside


def _rounded(corner: FloatArray) -> list[float]:
    return [float(f"{x:.6g}") for x in corner]


def faces_to(surface: Surface, side: tuple[ArrayLike, float], where: str) -> BoolArray:
    """Return facets (m,) with a normal within an angle of a direction; a quadrilateral's mean."""
    way, angle = _numbers(side[0]), float(side[1])
    length = 0.0 if way is None or way.shape != (3,) else float(np.sqrt((way * way).sum()))
    if way is None or not (0.0 < length < np.inf):
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
    along = (normals * (way / length)).sum(axis=1)
    kept: BoolArray = (lengths > 0.0) & (along >= np.cos(np.radians(angle)) * lengths)
    if not kept.any():
        raise MeshError(
            f"no facet faces that way to {angle:g} degrees",
            where=f"{where}, side",
            found=way.tolist(),
            remedy="Normals are those of the facets: of shells as the file turns them",
        )
    return kept


def _numbers(values: Any) -> FloatArray | None:
    real(values)
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return None if np.isnan(array).any() else array
