"""Which degrees of freedom of nodes are held: of single nodes, in a box, on a plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length
from contiga.errors import InputError
from contiga.records import FloatArray

WAYS = ("x", "y", "z")
PLACES = ("nodes", "box", "plane")
ON_PLANE = 1e-6
"""Part of the size of a slave that its nodes may be off a plane and still lie on it."""


def held_ways(fixed: Any, points: FloatArray, where: str) -> NDArray[np.bool_]:
    """(n, 3) which ways of points (n, 3) are held.

    Parameters
    ----------
    fixed : (n,) bool, (n, 3) bool, or numbers of nodes; a table ``{"nodes": …}``,
        ``{"box": (2, 3)}`` or ``{"plane": (2, 3) a point and the normal}``, with the ways as
        ``"hold": ["x", …]``, all if omitted; several of them in a list; None holds nothing
    where : for messages

    Raises
    ------
    InputError
        It is none of these, or no node is there.
    """
    held = np.zeros(points.shape, np.bool_)
    if fixed is None:
        return held
    tables = isinstance(fixed, Sequence) and len(fixed) > 0
    if tables and all(isinstance(one, Mapping) for one in fixed):
        for k, one in enumerate(fixed):
            held |= _of_table(one, points, f"{where}[{k}]")
        return held
    if isinstance(fixed, Mapping):
        return _of_table(fixed, points, where)
    given = np.asarray(fixed)
    if given.dtype == np.bool_ and given.shape == points.shape:
        return given.copy()
    held[_of_nodes(given, len(points), where)] = True
    return held


def _of_table(table: Mapping[str, Any], points: FloatArray, where: str) -> NDArray[np.bool_]:
    """(n, 3) of one table."""
    places = [key for key in table if key in PLACES]
    if len(places) != 1 or set(table) - {*PLACES, "hold"}:
        raise InputError(
            "says which nodes by one key, and beside it their ways by `hold`",
            where=where,
            found=", ".join(map(str, table)),
            allowed=", ".join(PLACES),
        )
    key = places[0]
    if key == "nodes":
        rows = _of_nodes(np.asarray(table[key]), len(points), f"{where}: nodes")
    else:
        corners = np.asarray(table[key], dtype=np.float64)
        if corners.shape != (2, 3) or not np.isfinite(corners).all():
            raise InputError(
                "must be two rows of three numbers",
                where=f"{where}: {key}",
                found=table[key],
                allowed="lowest and highest corner of a box; a point and the normal of a plane",
            )
        rows = (_in_box if key == "box" else _on_plane)(points, corners)
    if not rows.any():
        raise InputError(
            "no node of the slave is there",
            where=f"{where}: {key}",
            found=table[key],
            allowed=f"nodes from {np.round(points.min(axis=0), 6).tolist()} to "
            f"{np.round(points.max(axis=0), 6).tolist()}",
        )
    return rows[:, None] & _ways(table.get("hold", WAYS), f"{where}: hold")


def _of_nodes(given: NDArray[Any], count: int, where: str) -> NDArray[np.bool_]:
    """(n,) of a mask or numbers of nodes."""
    rows = np.zeros(count, np.bool_)
    if given.dtype == np.bool_ and given.shape == (count,):
        return given.copy()
    if given.dtype.kind not in "iu" or given.ndim != 1 or not given.size:
        raise InputError(
            "must say which nodes are held",
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


def _in_box(points: FloatArray, box: FloatArray) -> NDArray[np.bool_]:
    near = ON_PLANE * length(np.ptp(points, axis=0))
    inside: NDArray[np.bool_] = ((points >= box[0] - near) & (points <= box[1] + near)).all(axis=1)
    return inside


def _on_plane(points: FloatArray, plane: FloatArray) -> NDArray[np.bool_]:
    size = length(plane[1])
    if size == 0.0:
        return np.zeros(len(points), np.bool_)
    off = ((points - plane[0]) * (plane[1] / size)).sum(axis=1)
    near: NDArray[np.bool_] = np.abs(off) <= ON_PLANE * length(np.ptp(points, axis=0))
    return near


def _ways(hold: Any, where: str) -> NDArray[np.bool_]:
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    for name in names:
        if name not in WAYS:
            raise InputError(
                "nothing of this name can be held",
                where=where,
                found=name,
                allowed=", ".join(WAYS),
            )
    return np.array([way in names for way in WAYS])
