"""Faces that go through themselves or through one another, and where.

Two parts of a surface that cross have leaves of the hierarchy that come near each other and are no
neighbours. From places on both, Newton's method leads to a point that both pass through, and there
it is looked a little to either side: faces cross where both go on beyond the other. Such that end
there, as at a common edge, or only touch do not. What is crossed over less than `ASIDE` of the size
is not found, nor what lies wholly between leaves that adjoin in one face: these are nearly flat.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.elements.element_arrays import Records
from contiga.geometry.faces import Faces
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.num.arrays import laid_out
from contiga.records import FloatArray, IndexArray
from contiga.search.tables import Tables, tables_of

ASIDE = 1e-5
"""How far to either side of a crossing faces go on at least, in the body's size."""
STEEP = 1e-2
"""Sine of the angle under which faces cross at least: what is flatter may be rounding."""
MET = 1e-11
"""Distance of two places that are one, in the body's size."""
STARTS, HOPS = 3, 10
"""Pairs of places of two leaves that Newton's method starts from, those that are nearest; steps."""
RANK = 1e-14
"""Share of a matrix that is added to one that may be singular."""
GRID = np.stack(np.meshgrid([-0.7, 0.0, 0.7], [-0.7, 0.0, 0.7]), axis=-1).reshape(-1, 2)
"""Places of a leaf, in halves of its sides from its middle."""


class Crossing(NamedTuple):
    """A place where faces go through each other, or one through itself."""

    patches: tuple[int, int]
    point: tuple[float, float, float]
    """Body frame."""

    def __str__(self) -> str:
        (a, b), (x, y, z) = self.patches, self.point
        who = f"patch {a} goes" if a == b else f"patches {a} and {b} go"
        other = "itself" if a == b else "each other"
        return f"{who} through {other} at ({x:.6g}, {y:.6g}, {z:.6g})"


class _Places(NamedTuple):
    """Places on a body, each with the leaf whose element it is evaluated on."""

    patch: IndexArray
    uv: FloatArray
    point: FloatArray
    along: FloatArray
    """(n, 2, 3) derivatives along u and v."""


def crossing_of(body: Faces, slit: float, *, between: bool) -> Crossing | None:
    """A place where a face goes through itself, or with `between` through another; None if none.

    `slit` is how far faces may be off an edge they share.
    """
    tables = tables_of(body)
    pairs = near_leaves(tables)
    patch = tables.leaves["patch"]
    same = patch[pairs[:, 0]] == patch[pairs[:, 1]]
    uv = leaf_boxes(tables)
    a, b = uv[pairs[:, 0]], uv[pairs[:, 1]]
    adjoin = same & ((a[:, 0] <= b[:, 1]) & (b[:, 0] <= a[:, 1])).all(axis=1)
    pairs = pairs[~adjoin & (same | between)]
    if len(pairs) == 0:
        return None
    first, second = _led_together(body, tables, pairs, uv)
    margin = max(ASIDE * body.size, 4.0 * slit)
    found = np.flatnonzero(_cross(body, first, second, margin))
    if len(found) == 0:
        return None
    k = int(found[0])
    x, y, z = first.point[k].tolist()
    return Crossing((int(first.patch[k]), int(second.patch[k])), (x, y, z))


def leaf_boxes(tables: Tables) -> FloatArray:
    """(leaves, 2, 2) low and high (u, v) of each leaf of a face; of curves no matter what."""
    leaves, table = tables.leaves, tables.elements.table
    box = table["box"][np.maximum(leaves["element"], 0)].reshape(-1, 2, 2)
    share = leaves["box"].reshape(-1, 2, 2) + 0.5
    return np.swapaxes(box[:, :, :1] + share * np.ptp(box, axis=2)[:, :, None], 1, 2)


def near_leaves(tables: Tables, within: float = 0.0) -> IndexArray:
    """(n, 2) pairs of leaves of faces that may come nearer than `within`."""
    tree, leaves, plates = tables.tree, tables.leaves, tables.plates
    nodes = np.zeros((1, 2), np.int64)
    ends: list[IndexArray] = []
    while len(nodes):
        a, b = nodes.T
        meet = (tree["low"][a] <= tree["high"][b] + within).all(axis=1)
        meet &= (tree["low"][b] <= tree["high"][a] + within).all(axis=1)
        nodes = nodes[meet]
        inner = tree["count"][nodes] == 0
        ends.append(nodes[~inner.any(axis=1)])
        nodes = _opened(tree, nodes[inner.any(axis=1)])
    pairs = _members(tree, np.concatenate(ends))
    pairs = pairs[(leaves["element"][pairs] >= 0).all(axis=1)]
    one, two = plates[pairs[:, 0]], plates[pairs[:, 1]]
    off = np.linalg.norm(two["middle"] - one["middle"], axis=1)
    pairs = pairs[off <= one["radius"] + two["radius"] + within]
    return pairs[_plates_meet(plates, pairs, within)]


def _opened(tree: Records, nodes: IndexArray) -> IndexArray:
    """Pairs of children of pairs of nodes, each once; an end of the hierarchy stays itself."""
    inner = tree["count"][nodes] == 0
    first = np.where(inner, tree["first"][nodes], nodes)
    alike = nodes[:, 0] == nodes[:, 1]
    pairs = []
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        there = (inner | (np.array([i, j]) == 0)).all(axis=1) & ~(alike & (i > j))
        pairs.append(first[there] + [i, j])
    return np.concatenate(pairs)


def _members(tree: Records, nodes: IndexArray) -> IndexArray:
    """Pairs of leaves of pairs of nodes, each once."""
    most = int(tree["count"].max(initial=1))
    first, count = tree["first"][nodes], tree["count"][nodes]
    i, j = (axis.ravel() for axis in np.indices((most, most)))
    inside = (i < count[:, :1]) & (j < count[:, 1:])
    inside &= (i < j) | (nodes[:, :1] != nodes[:, 1:])
    pairs = np.stack([first[:, :1] + i, first[:, 1:] + j], axis=2)
    return np.asarray(pairs[inside], np.int64)


def _plates_meet(plates: Records, pairs: IndexArray, within: float) -> NDArray[np.bool_]:
    """Whether the plates of leaves do, by the axes of both (separating axes of thick rectangles)."""
    one, two = plates[pairs[:, 0]], plates[pairs[:, 1]]
    off = two["middle"] - one["middle"]
    meet = np.ones(len(pairs), bool)
    for axis in (one["normal"], two["normal"], one["x"], one["y"], two["x"], two["y"]):
        length = np.maximum(np.linalg.norm(axis, axis=1), 1e-300)
        way = axis / length[:, None]
        reach = within + one["departure"] + two["departure"]
        for plate in (one, two):
            reach = reach + np.abs((plate["x"] * way).sum(axis=1))
            reach += np.abs((plate["y"] * way).sum(axis=1))
        meet &= np.abs((off * way).sum(axis=1)) <= reach
    return meet


def _led_together(
    body: Faces, tables: Tables, pairs: IndexArray, uv: FloatArray
) -> tuple[_Places, _Places]:
    """Places of two leaves each that are one point."""
    plates, element = tables.plates, tables.leaves["element"]
    x, y = GRID.T[:, :, None]
    on = [
        plates["middle"][side][:, None]
        + x * plates["x"][side][:, None]
        + y * plates["y"][side][:, None]
        for side in pairs.T
    ]
    off = np.linalg.norm(on[0][:, :, None] - on[1][:, None], axis=3).reshape(len(pairs), -1)
    nearest = np.argsort(off, axis=1, kind="stable")[:, :STARTS]
    rows = np.repeat(np.arange(len(pairs)), nearest.shape[1])
    sides = np.divmod(nearest.ravel(), len(GRID))
    low, high = (
        np.concatenate([uv[pairs[rows, k], end] for k in (0, 1)], axis=1) for end in (0, 1)
    )
    share = 0.5 + 0.5 * np.concatenate([GRID[side] for side in sides], axis=1)
    place = low + share * (high - low)
    elements = element[pairs[rows]]
    reach = plates["radius"][pairs[rows]].sum(axis=1)
    near = MET * body.size
    met: list[tuple[_Places, _Places]] = []
    for hop in range(HOPS + 1):
        one, two = (
            _evaluated(body, tables, elements[:, k], place[:, 2 * k : 2 * k + 2]) for k in (0, 1)
        )
        miss = two.point - one.point
        off = np.linalg.norm(miss, axis=1)
        there = off <= near
        met.append((_taken(one, there), _taken(two, there)))
        go = ~there & (off <= reach * 0.5**hop)
        place, low, high = place[go], low[go], high[go]
        elements, reach, miss = elements[go], reach[go], miss[go]
        slope = np.concatenate([one.along[go], -two.along[go]], axis=1)
        place = np.clip(place + _shortest(slope, miss), low, high)
    return tuple(
        _Places(*(np.concatenate(field) for field in zip(*(pair[k] for pair in met), strict=True)))
        for k in (0, 1)
    )


def _taken(places: _Places, rows: NDArray[np.bool_]) -> _Places:
    return _Places(*(field[rows] for field in places))


def _shortest(slope: FloatArray, miss: FloatArray) -> FloatArray:
    """(n, 4) shortest steps x with x · slope = miss (n, 3), least squares where it has no rank."""
    square = slope.transpose(0, 2, 1) @ slope
    square += RANK * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    square[(square == 0.0).all(axis=(1, 2))] = np.eye(3)
    return np.asarray((slope @ np.linalg.solve(square, miss[:, :, None]))[:, :, 0])


def _evaluated(body: Faces, tables: Tables, element: IndexArray, uv: FloatArray) -> _Places:
    """Points and first derivatives at places of elements."""
    patch = tables.elements.table["patch"][element]
    d = np.empty((len(uv), 2, 2, 3))
    order = np.argsort(patch, kind="stable")
    starts = np.flatnonzero(np.diff(patch[order], prepend=-1))
    for rows in np.split(order, starts[1:]):
        if len(rows):
            d[rows] = body.patches[int(patch[rows[0]])].derivatives(uv[rows], 1)[:, :2, :2]
    return _Places(patch, uv, d[:, 0, 0], np.stack([d[:, 1, 0], d[:, 0, 1]], axis=1))


def _cross(body: Faces, one: _Places, two: _Places, margin: float) -> NDArray[np.bool_]:
    """Whether faces go on to both sides of each other at places that are one point."""
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = [np.cross(side.along[:, 0], side.along[:, 1]) for side in (one, two)]
        normals = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals]
        edge = np.cross(*normals)
        steep = np.linalg.norm(edge, axis=1)
        good = steep > STEEP
        edge /= steep[:, None]
    apart = _apart(one, two)
    good &= (one.patch != two.patch) | (apart > 4.0 * margin)
    for side, normal in zip((one, two), normals, strict=True):
        rows = np.flatnonzero(good)
        way = np.cross(edge[rows], normal[rows]) * (margin / steep[rows])[:, None]
        step = np.linalg.pinv(side.along[rows].transpose(0, 2, 1)) @ way[:, :, None]
        for sign in (1.0, -1.0):
            good[rows] &= _inside(body, side.patch[rows], side.uv[rows] + sign * step[:, :, 0])
    return good


def _apart(one: _Places, two: _Places) -> FloatArray:
    """How far apart places of one face are, along it: by its derivatives at the first."""
    way = (two.uv - one.uv)[:, None] @ one.along
    return np.asarray(np.linalg.norm(way[:, 0], axis=1))


def _inside(body: Faces, patch: IndexArray, uv: FloatArray) -> NDArray[np.bool_]:
    """Whether places lie in their faces."""
    inside = np.zeros(len(uv), bool)
    for k in np.unique(patch).tolist():
        rows = np.flatnonzero(patch == k)
        low, high = np.array(body.patches[k].domain).T
        inside[rows] = ((low <= uv[rows]) & (uv[rows] <= high)).all(axis=1)
        if body.trims[k] is not None:
            places = laid_out(np.clip(uv[rows], low, high), np.float64)
            inside[rows] &= points_in_trim(body.trim_tables, k, places)
    return inside
