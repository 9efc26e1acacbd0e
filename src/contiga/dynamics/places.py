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
PLACE_TOL = 1e-6
"""Distance, over the size of a slave, within which a node lies on a plane, a curve or a box."""
Mask = NDArray[np.bool_]


def place_of(table: Mapping[str, Any], other_keys: tuple[str, ...], where: str) -> str | None:
    """Return the key of a table that selects nodes; None if it has none.

    Raises
    ------
    InputError
        Several such keys, or a key that is neither one of a place nor one of `other_keys`.
    """
    places = [key for key in table if key in PLACES]
    unknown = [str(key) for key in table if key not in (*PLACES, *other_keys)]
    if unknown:
        raise InputError(
            "a key is not known",
            where=where,
            found=", ".join(unknown),
            allowed=", ".join((*PLACES, *other_keys)),
        )
    if len(places) > 1:
        raise InputError(
            "says more than once which nodes",
            where=where,
            found=", ".join(places),
            allowed="one of " + ", ".join(PLACES),
        )
    return places[0] if places else None


def nodes_at(key: str | None, value: Any, slave: Slave, where: str) -> Mask:
    """Return the mask (n,) of the nodes of a slave at a place; all nodes if `key` is None.

    Parameters
    ----------
    key, value : "nodes" (n,) bool or numbers; "box" (2, 3) lowest and highest corner; "plane"
        (2, 3) a point and the normal; "side" a direction and an angle in degrees, of the normals of
        facets; "layer" a direction, with the depth below the outermost node along it; "curve" a
        `NurbsCurve` that they lie on; "edge" of a slave of splines "u0", "u1", "v0" or "v1", or
        one of these with the number of the patch, from 0. Boxes, planes, layers and curves have a
        tolerance of `PLACE_TOL` times the diagonal of the slave's box
    where : for messages
    slave : slave with the nodes

    Raises
    ------
    InputError
        The value is no such place, or no node is there.
    """
    points, where = slave.points, f"{where}: {key}"
    mask = np.zeros(len(points), np.bool_)
    tol = PLACE_TOL * length(np.ptp(points, axis=0))
    if key is None:
        return ~mask
    if key == "nodes":
        mask = mask_of(np.asarray(value), len(points), where)
    elif key == "side":
        is_facing = _facets_facing(value, slave, where)
        assert slave.facets is not None
        mask[slave.facets[is_facing]] = True
    elif key == "layer":
        direction, depth = _direction_and_number(value, where)
        heights = (points * (direction / length(direction))).sum(axis=1)
        mask = np.asarray(heights >= heights.max() - depth - tol)
    elif key == "edge":
        mask[_nodes_of_edge(value, slave, where)] = True
    elif key == "curve":
        if not callable(getattr(value, "derivatives", None)):
            raise InputError("must be a NurbsCurve", where=where, found=type(value).__name__)
        mask = on_curve(points, value, tol)
    elif key == "box":
        low, high = _two_rows(value, where)
        mask = ((points >= low - tol) & (points <= high + tol)).all(axis=1)
    else:
        point, normal = _two_rows(value, where)
        if (size := length(normal)) > 0.0:
            distances = ((points - point) * (normal / size)).sum(axis=1)
            mask = np.abs(distances) <= tol
    if not mask.any():
        raise InputError(
            "no node of the slave is there",
            where=where,
            found=value,
            allowed=f"nodes {box_text(points)}",
        )
    return mask


def box_text(points: FloatArray) -> str:
    """Return the bounding box of points (n, 3) in words, "from [x, y, z] to [x, y, z]"."""
    low, high = np.round([points.min(axis=0), points.max(axis=0)], 6).tolist()
    return f"from {low} to {high}"


def facets_at(key: str | None, value: Any, slave: Slave, where: str) -> Mask:
    """Return the mask (m,) of facets all of whose corners are at a place; all if `key` is None.

    For the halves of a quadrilateral all four corners count. At a "side" are the facets that face
    its direction themselves.

    Raises
    ------
    InputError
        A slave without facets; see `nodes_at`. A place with nodes but no whole facet is no error.
    """
    if slave.facets is None:
        raise InputError("a slave without facets has no surface", where=where, found="a cloud")
    if key is None:
        return np.ones(len(slave.facets), np.bool_)
    if key == "side":
        return _facets_facing(value, slave, f"{where}: side")
    mask = nodes_at(key, value, slave, where)
    return facets_of(mask, slave.facets, slave.quads)


def mask_of(nodes: NDArray[Any], count: int, where: str) -> Mask:
    """Return the mask (n,) of nodes given by a mask or by their numbers, as a new array.

    Raises
    ------
    InputError
        Neither, no number at all, or one outside 0 … n − 1.
    """
    if nodes.dtype == np.bool_ and nodes.shape == (count,):
        return nodes.copy()
    if nodes.dtype.kind not in "iu" or nodes.ndim != 1 or not nodes.size:
        raise InputError(
            "must say which nodes",
            where=where,
            found=f"shape {nodes.shape} of {nodes.dtype}",
            allowed=f"({count},) or ({count}, 3) of bool, numbers of nodes, or a table",
        )
    is_outside = (nodes < 0) | (nodes >= count)
    if is_outside.any():
        raise InputError(
            "names a node that is not there",
            where=where,
            found=int(nodes[np.argmax(is_outside)]),
            allowed=f"0 to {count - 1}",
        )
    mask = np.zeros(count, np.bool_)
    mask[nodes] = True
    return mask


def _facets_facing(value: Any, slave: Slave, where: str) -> Mask:
    """Return the mask (m,) of facets whose normals are within an angle of a direction.

    `value` is a direction and degrees. An `InputError` is raised for a slave without facets; see
    `faces_to` for others.
    """
    direction, angle = _direction_and_number(value, where)
    if slave.facets is None:
        raise InputError("a slave without facets has no side", where=where, found="a cloud")
    surface = Surface(slave.points, slave.facets, slave.quads)
    return faces_to(surface, (direction, angle), where)


def _nodes_of_edge(value: Any, slave: Slave, where: str) -> IntArray:
    """Return the numbers (k,) of the nodes on an edge of a patch: its name, or name and patch.

    An `InputError` is raised for another value, a name alone if there are several patches, and a
    slave without splines.
    """
    if slave.surfaces is None:
        raise InputError(
            "only a slave of splines has edges of patches",
            where=where,
            found=value,
            allowed="a slave made of surfaces; or another place",
        )
    count = len(slave.surfaces.patches)
    edge = (value, 0) if isinstance(value, str) and count == 1 else value
    is_edge = isinstance(edge, Sequence) and len(edge) == 2 and edge[0] in EDGES
    if isinstance(edge, str) or not is_edge or edge[1] not in range(count):
        raise InputError(
            "does not say which edge of which patch",
            where=where,
            found=value,
            allowed=f"(name, patch): {', '.join(EDGES)} and 0 to {count - 1}",
        )
    return slave.surfaces.edge(edge[0], edge[1])


def _direction_and_number(value: Any, where: str) -> tuple[FloatArray, float]:
    """Return a direction (3,), as it is given, and an angle or a depth, ≥ 0.

    An `InputError` is raised for anything else, or a direction without length.
    """
    try:
        direction, number = np.asarray(real(value[0]), dtype=np.float64), float(value[1])
        is_vector = direction.shape == (3,) and bool(np.isfinite(direction).all())
        is_valid = is_vector and length(direction) > 0.0
    except (TypeError, ValueError, IndexError, KeyError):
        is_valid = False
    if not (is_valid and 0.0 <= number < np.inf):
        raise InputError(
            "must be a direction and a number",
            where=where,
            found=value,
            allowed="([x, y, z], degrees) of a side, ([x, y, z], depth) of a layer",
        )
    return direction, number


def _two_rows(value: Any, where: str) -> FloatArray:
    """Return two finite vectors (2, 3); an `InputError` is raised for anything else."""
    real(value, where)
    try:
        rows = np.asarray(value, dtype=np.float64)
        is_valid = rows.shape == (2, 3) and bool(np.isfinite(rows).all())
    except (TypeError, ValueError):
        is_valid = False
    if not is_valid:
        raise InputError(
            "must be two rows of three numbers",
            where=where,
            found=value,
            allowed="lowest and highest corner of a box; a point and the normal of a plane",
        )
    return rows
