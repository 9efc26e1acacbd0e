"""Select nodes of a slave: single ones, in a box, on a plane, a side, a curve or an edge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import real
from contiga.arrays.ordered import length
from contiga.errors import InputError
from contiga.patches.pieces import EDGES
from contiga.records import FloatArray, IntArray
from contiga.slaves.selection import Surface, faces_to, facets_of, on_curve
from contiga.slaves.slave import Slave

PLACES = ("nodes", "box", "plane", "side", "layer", "curve", "edge")
ON_PLANE = 1e-6
"""Part of the size of a slave that its nodes may be off a plane or a curve and still lie on it."""
Rows = NDArray[np.bool_]


def place_of(table: Mapping[str, Any], others: tuple[str, ...], where: str) -> str | None:
    """The key by which a table says where nodes are; None where it says it of all.

    Raises
    ------
    InputError
        Several, or keys that are none of a place nor of `others`.
    """
    places = [key for key in table if key in PLACES]
    unknown = [str(key) for key in table if key not in (*PLACES, *others)]
    if unknown:
        raise InputError(
            "a key is not known",
            where=where,
            found=", ".join(unknown),
            allowed=", ".join((*PLACES, *others)),
        )
    if len(places) > 1:
        raise InputError(
            "says more than once which nodes",
            where=where,
            found=", ".join(places),
            allowed="one of " + ", ".join(PLACES),
        )
    return places[0] if places else None


def nodes_at(key: str | None, value: Any, slave: Slave, where: str) -> Rows:
    """Return the nodes (n,) of a slave at a place; all nodes if `key` is None.

    Parameters
    ----------
    key, value : "nodes" (n,) bool or numbers; "box" (2, 3) lowest and highest corner; "plane"
        (2, 3) a point and the normal; "side" a direction and an angle in degrees, of the normals of
        facets; "layer" a direction, with the depth below the outermost node along it; "curve" a
        `NurbsCurve` that they lie on; "edge" of a slave of splines "u0", "u1", "v0" or "v1", or
        one of these with the number of the patch, from 0
    where : for messages
    slave : slave with the nodes

    Raises
    ------
    InputError
        It is no such place, or no node is there.
    """
    points, where = slave.points, f"{where}: {key}"
    if key is None:
        return np.ones(len(points), np.bool_)
    if key == "nodes":
        rows = nodes_given(np.asarray(value), len(points), where)
    elif key == "side":
        rows = np.zeros(len(points), np.bool_)
        facing = _facets_facing(value, slave, where)
        assert slave.facets is not None
        rows[slave.facets[facing]] = True
    elif key == "layer":
        rows = _in_layer(points, *_direction(value, where))
    elif key == "edge":
        rows = np.zeros(len(points), np.bool_)
        rows[_nodes_of_edge(value, slave, where)] = True
    elif key == "curve":
        if not callable(getattr(value, "derivatives", None)):
            raise InputError("must be a NurbsCurve", where=where, found=type(value).__name__)
        rows = on_curve(points, value, ON_PLANE * length(np.ptp(points, axis=0)))
    else:
        rows = (_in_box if key == "box" else _on_plane)(points, _two_rows(value, where))
    if not rows.any():
        raise InputError(
            "no node of the slave is there",
            where=where,
            found=value,
            allowed=f"nodes {box_told(points)}",
        )
    return rows


def box_told(points: FloatArray) -> str:
    """Return the bounding box of points (n, 3) in words."""
    low, high = np.round([points.min(axis=0), points.max(axis=0)], 6).tolist()
    return f"from {low} to {high}"


def facets_at(key: str | None, value: Any, slave: Slave, where: str) -> Rows:
    """Return the facets (m,) all of whose corners are at a place; all facets if `key` is None.

    Halves of a quadrilateral are there with all of its four corners.
    """
    if slave.facets is None:
        raise InputError("a slave without facets has no surface", where=where, found="a cloud")
    if key is None:
        return np.ones(len(slave.facets), np.bool_)
    if key == "side":
        return _facets_facing(value, slave, f"{where}: side")
    rows = nodes_at(key, value, slave, where)
    return facets_of(rows, slave.facets, slave.quads)


def nodes_given(given: NDArray[Any], count: int, where: str) -> Rows:
    """Return a mask (n,) from a mask or numbers of nodes."""
    rows = np.zeros(count, np.bool_)
    if given.dtype == np.bool_ and given.shape == (count,):
        return given.copy()
    if given.dtype.kind not in "iu" or given.ndim != 1 or not given.size:
        raise InputError(
            "must say which nodes",
            where=where,
            found=f"shape {given.shape} of {given.dtype}",
            allowed=f"({count},) or ({count}, 3) of bool, numbers of nodes, or a table",
        )
    if not ((given >= 0) & (given < count)).all():
        raise InputError(
            "names a node that is not there",
            where=where,
            found=int(given[np.argmax((given < 0) | (given >= count))]),
            allowed=f"0 to {count - 1}",
        )
    rows[given] = True
    return rows


def _facets_facing(value: Any, slave: Slave, where: str) -> Rows:
    way, angle = _direction(value, where)
    if slave.facets is None:
        raise InputError("a slave without facets has no side", where=where, found="a cloud")
    surface = Surface(slave.points, slave.facets, slave.quads)
    return faces_to(surface, (way, angle), where)


def _nodes_of_edge(value: Any, slave: Slave, where: str) -> IntArray:
    """Nodes on an edge of a patch."""
    if slave.surfaces is None:
        raise InputError(
            "only a slave of splines has edges of patches",
            where=where,
            found=value,
            allowed="a slave made of surfaces; or another place",
        )
    count = len(slave.surfaces.patches)
    given = (value, 0) if isinstance(value, str) and count == 1 else value
    fits = isinstance(given, Sequence) and len(given) == 2 and given[0] in EDGES
    if isinstance(given, str) or not fits or given[1] not in range(count):
        raise InputError(
            "does not say which edge of which patch",
            where=where,
            found=value,
            allowed=f"(name, patch): {', '.join(EDGES)} and 0 to {count - 1}",
        )
    return slave.surfaces.edge(given[0], given[1])


def _direction(value: Any, where: str) -> tuple[FloatArray, float]:
    """A direction and a number."""
    try:
        way, number = np.asarray(real(value[0]), dtype=np.float64), float(value[1])
        fits = way.shape == (3,) and bool(np.isfinite(way).all()) and length(way) > 0.0
    except (TypeError, ValueError, IndexError, KeyError):
        fits = False
    if not (fits and 0.0 <= number < np.inf):
        raise InputError(
            "must be a direction and a number",
            where=where,
            found=value,
            allowed="([x, y, z], degrees) of a side, ([x, y, z], depth) of a layer",
        )
    return way, number


def _two_rows(value: Any, where: str) -> FloatArray:
    real(value, where)
    try:
        corners = np.asarray(value, dtype=np.float64)
        fits = corners.shape == (2, 3) and bool(np.isfinite(corners).all())
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise InputError(
            "must be two rows of three numbers",
            where=where,
            found=value,
            allowed="lowest and highest corner of a box; a point and the normal of a plane",
        )
    return corners


def _in_layer(points: FloatArray, way: FloatArray, depth: float) -> Rows:
    along = (points * (way / length(way))).sum(axis=1)
    near = ON_PLANE * length(np.ptp(points, axis=0))
    return np.asarray(along >= along.max() - depth - near)


def _in_box(points: FloatArray, box: FloatArray) -> Rows:
    near = ON_PLANE * length(np.ptp(points, axis=0))
    inside: Rows = ((points >= box[0] - near) & (points <= box[1] + near)).all(axis=1)
    return inside


def _on_plane(points: FloatArray, plane: FloatArray) -> Rows:
    size = length(plane[1])
    if size == 0.0:
        return np.zeros(len(points), np.bool_)
    off = ((points - plane[0]) * (plane[1] / size)).sum(axis=1)
    near: Rows = np.abs(off) <= ON_PLANE * length(np.ptp(points, axis=0))
    return near
