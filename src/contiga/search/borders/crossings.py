"""Faces that go through themselves or through one another, and where.

Two parts of a surface that cross have leaves of the hierarchy that come near each other and are no
neighbours. From places on both, Newton's method leads to a point that both pass through. That they
cross must be proved there: both go on along the line of intersection, over a length, and to both
sides of each other. Faces that touch in a point, along an edge or tangentially do not. A crossing
over less than `ASIDE` of the size is not found, nor one between leaves that adjoin in one face:
these are nearly flat.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import as_contiguous
from contiga.arrays.threads import run_ranges
from contiga.geometry.faces import Faces
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.search.borders.crossing_records import CommonPoints, Starts
from contiga.search.borders.kernels import common_point_nb, near_leaves_nb
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of

ASIDE = 1e-5
"""How far to either side of a crossing faces go on at least, in the body's size."""
STEEP = 1e-2
"""Sine of the angle under which faces cross at least: what is flatter may be rounding."""
MET = 1e-11
"""Distance of two places that are one, in the body's size."""
STARTS = 1
"""Pairs of places of two leaves that Newton's method starts from at least: the nearest ones."""
STARTS_IN_ALL = 20_000
"""Starts in all while these are more than so many of each pair."""
PAIRS = 8
"""Pairs of near leaves a leaf for which there is room at first; most bodies have five."""
POINTS = 1024
"""Starts below which a second thread does not pay."""
ALIKE = 0.5
"""Cosine between normals that face about the same way."""
SINGULAR = 1e-7
"""Ratio of derivatives beneath which a place is a pole."""


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

    def of(self, rows: IndexArray) -> _Places:
        """Return some of the places."""
        return _Places(self.patch[rows], self.uv[rows], self.point[rows], self.along[rows])


def crossing_of(body: Faces, group: IntArray, slit: float) -> Crossing | None:
    """A place where a face goes through itself or another of its group; None if there is none.

    Parameters
    ----------
    body : the faces
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
    first, second = _led_together(body, tables, pairs)
    margin = max(ASIDE * body.size, 4.0 * slit)
    crossed = np.flatnonzero(_pierce(body, first, second, margin))
    if len(crossed) == 0:
        return None
    k = int(crossed[0])
    x, y, z = first.point[k].tolist()
    return Crossing((int(first.patch[k]), int(second.patch[k])), (x, y, z))


def _beside(tables: Tables, pairs: IndexArray, uv: FloatArray) -> NDArray[np.bool_]:
    """Return whether leaves of one face adjoin in it, or lie in a part that faces one way.

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
    """Return whether the normals of all leaves of an element are about the same (elements,)."""
    face = tables.leaves["element"] >= 0
    element, normal = tables.leaves["element"][face], tables.plates["normal"][face]
    axis = np.zeros((len(tables.elements.table), 3))
    np.add.at(axis, element, normal)
    axis /= np.maximum(np.linalg.norm(axis, axis=1), 1e-300)[:, None]
    least = np.ones(len(axis))
    np.minimum.at(least, element, (axis[element] * normal).sum(axis=1))
    return np.asarray(least > ALIKE)


def leaf_boxes(tables: Tables) -> FloatArray:
    """Return the box (leaves, 2, 2) in (u, v) of each leaf of a face; of curves any values."""
    leaves, table = tables.leaves, tables.elements.table
    box = table["box"][np.maximum(leaves["element"], 0)].reshape(-1, 2, 2)
    share = leaves["box"].reshape(-1, 2, 2) + 0.5
    return np.swapaxes(box[:, :, :1] + share * np.ptp(box, axis=2)[:, :, None], 1, 2)


def near_leaves(tables: Tables, within: float = 0.0) -> IndexArray:
    """Return (n, 2) pairs of leaves of faces that may come nearer than `within`."""
    count = PAIRS * len(tables.leaves)
    while True:
        pairs: IndexArray = np.empty((count, 2), np.int64)
        given = tables.tree, tables.leaves, tables.plates, within
        count = near_leaves_nb.list_near_leaves(*given, pairs)
        if count <= len(pairs):
            return pairs[:count]


def _led_together(body: Faces, tables: Tables, pairs: IndexArray) -> tuple[_Places, _Places]:
    """Places of two leaves each that are one point."""
    count = max(STARTS, min(STARTS_IN_ALL // len(pairs), common_point_nb.N_STARTS))
    starts = Starts(pairs, np.empty((len(pairs), count, 2, 2)), np.empty((len(pairs), count)))
    common_point_nb.nearest_starts(tables.plates, starts)
    common = CommonPoints.of(len(pairs), count)
    given = tables.elements, tables.leaves, starts, MET * body.size, common
    run_ranges(common_point_nb.lead_together, len(pairs), POINTS // count + 1, *given)
    patch = tables.leaves["patch"][pairs[np.nonzero(common.met)[0]]]
    uv, point, along = (field[common.met] for field in common[1:])
    one, two = (_Places(patch[:, k], uv[:, k], point[:, k], along[:, k]) for k in (0, 1))
    return one, two


def _pierce(body: Faces, one: _Places, two: _Places, margin: float) -> NDArray[np.bool_]:
    """Return whether faces pierce each other at places that are one point, or begin to do so there.

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
    apart = np.linalg.norm(((two.uv - one.uv)[:, None] @ one.along)[:, 0], axis=1)
    steep = (sine > STEEP) & ((one.patch != two.patch) | (apart > 4.0 * margin))
    some = np.flatnonzero(steep)
    one, two = one.of(some), two.of(some)
    to_uv = [np.linalg.pinv(side.along.transpose(0, 2, 1), rcond=SINGULAR) for side in (one, two)]
    proved = np.zeros(len(some), bool)
    for along in (1.0, -1.0):
        rows = np.flatnonzero(~proved)
        for aside in (0.0, 1.0, -1.0):
            for side, inverse, way in zip((one, two), to_uv, across, strict=True):
                to = margin * (along * line[some[rows]] + aside * way[some[rows]])
                uv = side.uv[rows] + (inverse[rows] @ to[:, :, None])[:, :, 0]
                rows = rows[_on_face(body, side.patch[rows], uv, side.point[rows] + to, margin)]
        proved[rows] = True
    steep[some] = proved
    return steep


def _on_face(
    body: Faces, patch: IndexArray, uv: FloatArray, target: FloatArray, margin: float
) -> NDArray[np.bool_]:
    """Return whether faces contain `target` (n, 3) at about (u, v), within half of `margin`."""
    there = np.zeros(len(uv), bool)
    for k in np.unique(patch).tolist():
        rows = np.flatnonzero(patch == k)
        low, high = np.array(body.patches[k].domain).T
        rows = rows[((low <= uv[rows]) & (uv[rows] <= high)).all(axis=1)]
        miss = np.linalg.norm(body.patches[k].evaluate(uv[rows]) - target[rows], axis=1)
        rows = rows[miss <= 0.5 * margin]
        if body.trims[k] is not None:
            inside = points_in_trim(body.trim_tables, k, as_contiguous(uv[rows], np.float64))
            rows = rows[inside]
        there[rows] = True
    return there
