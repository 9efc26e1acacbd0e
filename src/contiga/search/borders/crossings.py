"""Faces that go through themselves or through one another, and where.

Two parts of a surface that cross have leaves of the hierarchy that come near each other and are no
neighbours. From places on both, Newton's method leads to a point that both pass through. That they
cross must be proved there: both go on along the line of intersection, over a length, and to both
sides of each other. Faces that touch in a point, along an edge or tangentially do not. A crossing
over less than `ASIDE` of the size is not found, nor one between leaves that adjoin in one face:
these are nearly flat.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import GENERAL, RATIONAL_CUBIC
from contiga.arrays.layout import as_contiguous
from contiga.elements.element_arrays import Records
from contiga.geometry.faces import Faces
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of

ASIDE = 1e-5
"""How far to either side of a crossing faces go on at least, in the body's size."""
STEEP = 1e-2
"""Sine of the angle under which faces cross at least: what is flatter may be rounding."""
MET = 1e-11
"""Distance of two places that are one, in the body's size."""
STARTS, HOPS = 1, 10
"""Pairs of places of two leaves that Newton's method starts from at least, those that are nearest,
and its steps."""
FEW = 20_000
"""Starts in all while these are more than so many of each pair."""
NEARER = 0.35
"""Share of their distance that Newton's method leaves of it at each step at most."""
ALIKE = 0.5
"""Cosine between normals that face about the same way."""
SINGULAR = 1e-7
"""Ratio of derivatives beneath which a place is a pole."""
RANK = 1e-14
"""Share of a matrix that is added to one that may be singular."""
GRID = np.array([[0.0, 0.0], [-0.6, -0.6], [-0.6, 0.6], [0.6, -0.6], [0.6, 0.6]])
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


def crossing_of(body: Faces, group: IntArray, slit: float) -> Crossing | None:
    """A place where a face goes through itself or another of its group; None if there is none.

    Parameters
    ----------
    group : (patches,) number of the group that each is of
    slit : how far faces may be off an edge they share, length
    """
    tables = tables_of(body)
    pairs = near_leaves(tables)
    uv = leaf_boxes(tables)
    patch = tables.leaves["patch"][pairs]
    same = patch[:, 0] == patch[:, 1]
    together = group[patch[:, 0]] == group[patch[:, 1]]
    pairs = pairs[np.where(same, ~_beside(tables, pairs, uv), together)]
    if len(pairs) == 0:
        return None
    first, second = _led_together(body, tables, pairs, uv)
    margin = max(ASIDE * body.size, 4.0 * slit)
    crossed = np.flatnonzero(_pierce(body, first, second, margin))
    if len(crossed) == 0:
        return None
    k = int(crossed[0])
    x, y, z = first.point[k].tolist()
    return Crossing((int(first.patch[k]), int(second.patch[k])), (x, y, z))


def _beside(tables: Tables, pairs: IndexArray, uv: FloatArray) -> NDArray[np.bool_]:
    """Whether leaves of one face adjoin in it, or are of a part that faces about the same way.

    Leaves are nearly flat, and so are such parts: there is no room for the face to turn back. A
    part is an element, or two leaves with no more than a third between.
    """
    (a, a_high), (b, b_high) = (np.moveaxis(uv[side], 1, 0) for side in pairs.T)
    gap = np.maximum(a - b_high, b - a_high)
    one, two = tables.plates["normal"][pairs].transpose(1, 0, 2)
    alike = (one * two).sum(axis=1) > ALIKE
    third = (gap <= np.minimum(a_high - a, b_high - b)).all(axis=1)
    element = tables.leaves["element"][pairs]
    part = (element[:, 0] == element[:, 1]) & _face_one_way(tables)[element[:, 0]]
    return (gap <= 0.0).all(axis=1) | (alike & third) | part


def _face_one_way(tables: Tables) -> NDArray[np.bool_]:
    """(elements,) whether the normals of all leaves of an element are about the same."""
    face = tables.leaves["element"] >= 0
    element, normal = tables.leaves["element"][face], tables.plates["normal"][face]
    axis = np.zeros((len(tables.elements.table), 3))
    np.add.at(axis, element, normal)
    axis /= np.maximum(np.linalg.norm(axis, axis=1), 1e-300)[:, None]
    least = np.ones(len(axis))
    np.minimum.at(least, element, (axis[element] * normal).sum(axis=1))
    return np.asarray(least > ALIKE)


def leaf_boxes(tables: Tables) -> FloatArray:
    """(leaves, 2, 2) low and high (u, v) of each leaf of a face; of curves no matter what."""
    leaves, table = tables.leaves, tables.elements.table
    box = table["box"][np.maximum(leaves["element"], 0)].reshape(-1, 2, 2)
    share = leaves["box"].reshape(-1, 2, 2) + 0.5
    return np.swapaxes(box[:, :, :1] + share * np.ptp(box, axis=2)[:, :, None], 1, 2)


def near_leaves(tables: Tables, within: float = 0.0) -> IndexArray:
    """(n, 2) pairs of leaves of faces that may come nearer than `within`."""
    tree, leaves, plates = tables.tree, tables.leaves, tables.plates
    nodes: IndexArray = np.zeros((1, 2), np.int64)
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
    """Whether the plates of leaves do: thick rectangles, by their separating axes."""
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
    starts = max(STARTS, min(FEW // len(pairs), len(GRID) ** 2))
    nearest = np.argsort(off, axis=1, kind="stable")[:, :starts]
    rows = np.repeat(np.arange(len(pairs)), nearest.shape[1])
    sides = np.divmod(nearest.ravel(), len(GRID))
    low, high = (
        np.concatenate([uv[pairs[rows, k], end] for k in (0, 1)], axis=1) for end in (0, 1)
    )
    share = 0.5 + 0.5 * np.concatenate([GRID[side] for side in sides], axis=1)
    place = low + share * (high - low)
    elements = element[pairs[rows]]
    reach = np.take_along_axis(off, nearest, axis=1).ravel()
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
        go = ~there & (off <= reach * NEARER ** (hop - 1))
        place, low, high = place[go], low[go], high[go]
        elements, reach, miss = elements[go], reach[go], miss[go]
        slope = np.concatenate([one.along[go], -two.along[go]], axis=1)
        step = _shortest(slope, miss)
        for _ in range(2):  # what is at an end of its leaf and would leave it stays
            slope[((step < 0.0) & (place <= low)) | ((step > 0.0) & (place >= high))] = 0.0
            step = _shortest(slope, miss)
        place = np.clip(place + step, low, high)
    return _all_of([pair[0] for pair in met]), _all_of([pair[1] for pair in met])


def _taken(at: _Places, rows: NDArray[np.bool_] | IndexArray) -> _Places:
    return _Places(at.patch[rows], at.uv[rows], at.point[rows], at.along[rows])


def _all_of(some: Sequence[_Places]) -> _Places:
    patch, uv, point, along = (np.concatenate(field) for field in zip(*some, strict=True))
    return _Places(patch, uv, point, along)


def _shortest(slope: FloatArray, miss: FloatArray) -> FloatArray:
    """(n, 4) shortest steps x with x · slope = miss (n, 3), least squares where it has no rank."""
    square = slope.transpose(0, 2, 1) @ slope
    square += RANK * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    square[(square == 0.0).all(axis=(1, 2))] = np.eye(3)
    return np.asarray((slope @ np.linalg.solve(square, miss[:, :, None]))[:, :, 0])


def _evaluated(body: Faces, tables: Tables, element: IndexArray, uv: FloatArray) -> _Places:
    """Points and first derivatives at places of elements."""
    table = tables.elements.table
    patch, form = table["patch"][element], table["form"][element]
    point, along = np.empty((len(uv), 3)), np.empty((len(uv), 2, 3))
    rows = np.flatnonzero(form != GENERAL)
    box = table["box"][element[rows]].reshape(-1, 2, 2)
    width = np.ptp(box, axis=2)
    net = table["cubic"][element[rows]].reshape(-1, 4, 4, 4)
    about = table["about"][element[rows]] + 0.5
    (s, ds), (t, dt) = (
        _powers((uv[rows, k] - box[:, k, 0]) / width[:, k] - about[:, k]) for k in (0, 1)
    )
    by_t, by_dt = (np.einsum("nckl,nl->nck", net, powers) for powers in (t, dt))
    at, du, dv = (
        np.einsum("nck,nk->nc", half, powers)
        for half, powers in ((by_t, s), (by_t, ds), (by_dt, s))
    )
    weight = np.where(form[rows] == RATIONAL_CUBIC, at[:, 3], 1.0)[:, None]
    place = at[:, :3] / weight
    for k, d in enumerate((du, dv)):
        bent = np.where(form[rows] == RATIONAL_CUBIC, d[:, 3], 0.0)[:, None]
        along[rows, k] = (d[:, :3] - bent * place) / weight / width[:, k : k + 1]
    point[rows] = place + table["origin"][element[rows]]
    for k in np.unique(patch[form == GENERAL]).tolist():
        rows = np.flatnonzero((form == GENERAL) & (patch == k))
        d = body.patches[k].derivatives(uv[rows], 1)
        point[rows] = d[:, 0, 0]
        along[rows] = np.stack([d[:, 1, 0], d[:, 0, 1]], axis=1)
    return _Places(patch, uv, point, along)


def _powers(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, 4) powers 0 to 3 of x, and their derivatives."""
    one = np.ones_like(x)
    return np.stack([one, x, x * x, x**3], 1), np.stack([0.0 * x, one, 2.0 * x, 3.0 * x * x], 1)


def _pierce(body: Faces, one: _Places, two: _Places, margin: float) -> NDArray[np.bool_]:
    """Whether faces pierce each other at places that are one point, or begin to do so there.

    They do where the planes that touch them there meet at an angle, and both faces go on in their
    planes along the line of intersection, by `margin`, length, and there to both sides of the
    other face, by as much.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = [np.cross(side.along[:, 0], side.along[:, 1]) for side in (one, two)]
        normals = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals]
        line = np.cross(normals[0], normals[1])
        sine = np.linalg.norm(line, axis=1)
        line /= sine[:, None]
        across = [np.cross(line, normal) / sine[:, None] for normal in normals]
    steep = (sine > STEEP) & ((one.patch != two.patch) | (_apart(one, two) > 4.0 * margin))
    proved = np.zeros(len(sine), bool)
    for along in (1.0, -1.0):
        rows = np.flatnonzero(steep & ~proved)
        for aside in (0.0, 1.0, -1.0):
            for side, way in zip((one, two), across, strict=True):
                to = margin * (along * line[rows] + aside * way[rows])
                rows = rows[_goes_on(body, _taken(side, rows), to, 0.5 * margin)]
        proved[rows] = True
    return proved


def _goes_on(body: Faces, side: _Places, way: FloatArray, tol: float) -> NDArray[np.bool_]:
    """Whether faces contain the points that lie `way` (n, 3) from places on them, within `tol`."""
    slope = side.along.transpose(0, 2, 1)
    uv = side.uv + (np.linalg.pinv(slope, rcond=SINGULAR) @ way[:, :, None])[:, :, 0]
    target = side.point + way
    there = np.zeros(len(uv), bool)
    for k in np.unique(side.patch).tolist():
        rows = np.flatnonzero(side.patch == k)
        low, high = np.array(body.patches[k].domain).T
        rows = rows[((low <= uv[rows]) & (uv[rows] <= high)).all(axis=1)]
        miss = np.linalg.norm(body.patches[k].evaluate(uv[rows]) - target[rows], axis=1)
        rows = rows[miss <= tol]
        if body.trims[k] is not None:
            inside = points_in_trim(body.trim_tables, k, as_contiguous(uv[rows], np.float64))
            rows = rows[inside.astype(bool)]
        there[rows] = True
    return there


def _apart(one: _Places, two: _Places) -> FloatArray:
    """How far apart places of one face are, along it: by its derivatives at the first."""
    way = (two.uv - one.uv)[:, None] @ one.along
    return np.asarray(np.linalg.norm(way[:, 0], axis=1))
