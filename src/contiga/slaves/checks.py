"""Check the arrays of a slave: they must be finite and fit its points."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import read_only, real
from contiga.errors import MeshError
from contiga.records import FloatArray, IntArray
from contiga.slaves.cells import split_shells

NODE_TOL = 1e-9
"""Largest distance of points from the nodes of surfaces, in x, y or z, over the nodes' extent."""


def check_points(points: FloatArray, *, where: str, ids: NDArray[Any] | None = None) -> None:
    """Raise MeshError for no nodes, or for a coordinate that is not finite.

    `ids` are the node numbers of the file, for the message on the first bad node.
    """
    if len(points) == 0:
        raise MeshError("there are no nodes", where=where, allowed="at least one point")
    bad_rows = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad_rows):
        row = int(bad_rows[0])
        node = f"row {row} (counted from 0)" if ids is None else f"node {ids[row]} (row {row})"
        raise MeshError(
            f"the coordinates of {len(bad_rows)} node(s) are not finite, first {node}",
            where=where,
            found=points[row].tolist(),
            allowed="finite numbers",
        )


def check_nodes(nodes: FloatArray, points: FloatArray, name: str) -> None:
    """Raise MeshError unless points are the nodes of surfaces, to `NODE_TOL` of their extent."""
    size = float(np.ptp(nodes, axis=0).max())
    if nodes.shape != points.shape or not np.abs(nodes - points).max() <= NODE_TOL * size:
        raise MeshError(
            "the points of a slave of splines are the nodes of its surfaces",
            where=name,
            found=f"{len(points)} points",
            allowed=f"no points beside surfaces, which have {len(nodes)}",
        )


def as_facets(points: FloatArray, facets: ArrayLike, name: str) -> IntArray:
    """Return facets (m, 3) or (m, 4) as a copy of triangles (k, 3) int32, read-only.

    Quadrilaterals are split along the shorter diagonal; a quadrilateral with two equal points in
    turn becomes one triangle. Raises MeshError for other shapes, numbers that are not whole, and
    points that do not exist.
    """
    real(facets, name)
    try:
        array = np.asarray(facets)
    except ValueError as error:  # rows of different lengths
        raise MeshError("facets must be rows of one length", where=name) from error
    if array.ndim != 2 or array.shape[1] not in (3, 4) or array.dtype.kind not in "iu":
        raise MeshError(
            "facets must be whole numbers in rows of 3 or 4",
            where=name,
            found=f"shape {array.shape} of {array.dtype}",
            allowed="(m, 3) triangles or (m, 4) quadrilaterals",
        )
    bad_rows = np.flatnonzero(((array < 0) | (array >= len(points))).any(axis=1))
    if len(bad_rows):
        raise MeshError(
            f"facet {int(bad_rows[0])} names a point that is not there",
            where=name,
            found=array[bad_rows[0]].tolist(),
            allowed=f"0 to {len(points) - 1}",
        )
    if array.shape[1] == 4:
        array, _ = split_shells(points, "quad", array.astype(np.int32))
    corners = np.array(array, dtype=np.int32, order="C")
    corners.flags.writeable = False
    return corners


def as_nodal(values: ArrayLike | None, what: str, count: int, name: str) -> FloatArray | None:
    """Return one value for each point (n,) as a read-only copy; None without values.

    One number is repeated for all points. Raises MeshError, in which `what` is the quantity, for
    other shapes, and for values that are negative or not finite.
    """
    if values is None:
        return None
    real(values, name)
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError(f"{what} must be an array of numbers", where=name) from error
    if array.ndim == 0:
        array = np.full(count, array)
    if array.shape != (count,):
        raise MeshError(
            f"{what} must be one number, or one a point",
            where=name,
            found=array.shape,
            allowed=f"({count},)",
        )
    bad_rows = np.flatnonzero(~((array >= 0.0) & np.isfinite(array)))
    if len(bad_rows):
        raise MeshError(
            f"{what} of point {int(bad_rows[0])} is negative or not finite",
            where=name,
            found=float(array[bad_rows[0]]),
            allowed="0 or more",
        )
    return read_only(array)


def as_active(
    active: ArrayLike | None, facets: IntArray | None, count: int, name: str
) -> NDArray[np.bool_]:
    """Return the mask of active points (n,) as a read-only copy.

    By default it is the corners of the facets, or all points without facets. Raises MeshError
    unless `active` is one boolean for each point.
    """
    if active is None:
        mask = np.full(count, facets is None)
        if facets is not None:
            mask[facets] = True
    else:
        array = np.asarray(real(active, name))
        if array.shape != (count,) or array.dtype != np.bool_:
            raise MeshError(
                "expected one boolean for each point",
                where=name,
                found=f"shape {array.shape} of {array.dtype}",
                allowed=f"({count},) of bool",
            )
        mask = array.copy()
    mask.flags.writeable = False
    return mask
