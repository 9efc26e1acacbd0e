"""Faces that cross themselves or one another, and where.

Two parts of a surface that cross have leaves of the hierarchy that come near each other and are no
neighbours. From places on both, Newton's method leads to a common point. It is a crossing if both
parts continue from there along the line of intersection, over a length, and to both sides of each
other. Faces that touch in a point, along an edge or tangentially do not. Crossings shorter than
`MIN_EXTENT` of the size are not found, nor crossings between leaves that adjoin in one face: these
are nearly flat.
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

MIN_EXTENT = 1e-5
"""Least extent of both faces on either side of a crossing, as a share of the body's size."""
MIN_SINE = 1e-2
"""Least sine of the angle between crossing faces: a flatter crossing may be rounding."""
MEETING_TOL = 1e-11
"""Largest distance of two places that are one point, as a share of the body's size."""
MIN_STARTS = 1
"""Least number of starts of Newton's method on a pair of leaves: its nearest pairs of places."""
MAX_TOTAL_STARTS = 20_000
"""Largest number of starts on all pairs of leaves, as long as that leaves `MIN_STARTS` for each."""
PAIRS_PER_LEAF = 8
"""First estimate of the pairs of near leaves per leaf; most bodies have five."""
MIN_THREAD_STARTS = 1024
"""Number of starts below which a second thread does not pay."""
MIN_COSINE = 0.5
"""Least cosine between normals that face about the same direction."""
SINGULAR_TOL = 1e-7
"""Ratio of derivatives below which a place is a pole."""


class Crossing(NamedTuple):
    """A place where faces cross each other, or one crosses itself."""

    patches: tuple[int, int]
    point: tuple[float, float, float]
    """Body frame."""

    def __str__(self) -> str:
        (a, b), (x, y, z) = self.patches, self.point
        subject = f"patch {a} goes" if a == b else f"patches {a} and {b} go"
        target = "itself" if a == b else "each other"
        return f"{subject} through {target} at ({x:.6g}, {y:.6g}, {z:.6g})"


class _Places(NamedTuple):
    """Places (n,) on a body."""

    patch: IndexArray
    uv: FloatArray
    point: FloatArray
    tangents: FloatArray
    """(n, 2, 3) derivatives along u and v."""

    def of(self, rows: IndexArray) -> _Places:
        """Return the places `rows`."""
        return _Places(self.patch[rows], self.uv[rows], self.point[rows], self.tangents[rows])


def crossing_of(body: Faces, group: IntArray, slit: float) -> Crossing | None:
    """Find a place where a face crosses itself or another of its group; None if none is found.

    The first of the places found is returned.

    Parameters
    ----------
    body : the faces
    group : (patches,) number of the group of each patch
    slit : largest distance of faces from an edge they share, length
    """
    tables = tables_of(body)
    pairs = near_leaves(tables)
    patch = tables.leaves["patch"][pairs]
    is_same_patch = patch[:, 0] == patch[:, 1]
    is_same_group = group[patch[:, 0]] == group[patch[:, 1]]
    pairs = pairs[np.where(is_same_patch, ~_in_flat_part(tables, pairs), is_same_group)]
    if len(pairs) == 0:
        return None
    # The common points of the pairs, as places on the first leaf and on the second.
    n = len(pairs)
    count = max(MIN_STARTS, min(MAX_TOTAL_STARTS // n, common_point_nb.N_STARTS))
    starts = Starts(pairs, np.empty((n, count, 2, 2)), np.empty((n, count)))
    common_point_nb.nearest_starts(tables.plates, starts)
    common = CommonPoints.of(n, count)
    args = tables.elements, tables.leaves, starts, MEETING_TOL * body.size, common
    run_ranges(common_point_nb.find_common_points, n, MIN_THREAD_STARTS // count + 1, *args)
    patch = tables.leaves["patch"][pairs[np.nonzero(common.is_common)[0]]]
    uv, point, tangents = (field[common.is_common] for field in common[1:])
    first, second = (_Places(patch[:, k], uv[:, k], point[:, k], tangents[:, k]) for k in (0, 1))
    margin = max(MIN_EXTENT * body.size, 4.0 * slit)
    rows = np.flatnonzero(_crosses(body, first, second, margin))
    if len(rows) == 0:
        return None
    k = int(rows[0])
    x, y, z = first.point[k].tolist()
    return Crossing((int(first.patch[k]), int(second.patch[k])), (x, y, z))


def _in_flat_part(tables: Tables, pairs: IndexArray) -> NDArray[np.bool_]:
    """Return a mask (n,) of pairs of leaves of a face that adjoin, or lie in a nearly flat part.

    In such a part the normals are similar: the face cannot turn back inside. A part is an element,
    or two leaves whose distance in (u, v) is at most the smaller leaf. Pairs (n, 2) of leaves of
    different faces get meaningless values.
    """
    boxes = leaf_boxes(tables)
    (a, a_high), (b, b_high) = (np.moveaxis(boxes[leaf], 1, 0) for leaf in pairs.T)
    gap = np.maximum(a - b_high, b - a_high)
    adjoins = (gap <= 0.0).all(axis=1)
    n_a, n_b = tables.plates["normal"][pairs].transpose(1, 0, 2)
    has_similar_normals = (n_a * n_b).sum(axis=1) > MIN_COSINE
    is_close = (gap <= np.minimum(a_high - a, b_high - b)).all(axis=1)

    # Elements in which the normals of all leaves are similar to their mean.
    on_face = tables.leaves["element"] >= 0
    element, normal = tables.leaves["element"][on_face], tables.plates["normal"][on_face]
    mean = np.zeros((len(tables.elements.table), 3))
    np.add.at(mean, element, normal)
    mean /= np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None]
    min_cosine = np.ones(len(mean))
    np.minimum.at(min_cosine, element, (mean[element] * normal).sum(axis=1))
    e, f = tables.leaves["element"][pairs].T
    in_flat_element = (e == f) & (min_cosine > MIN_COSINE)[e]
    return np.asarray(adjoins | (has_similar_normals & is_close) | in_flat_element)


def leaf_boxes(tables: Tables) -> FloatArray:
    """Return the box of each leaf of a face in (u, v): low, high (leaves, 2, 2).

    The rows of curve leaves are meaningless.
    """
    leaves, table = tables.leaves, tables.elements.table
    box = table["box"][np.maximum(leaves["element"], 0)].reshape(-1, 2, 2)
    share = leaves["box"].reshape(-1, 2, 2) + 0.5
    return np.swapaxes(box[:, :, :1] + share * np.ptp(box, axis=2)[:, :, None], 1, 2)


def near_leaves(tables: Tables, within: float = 0.0) -> IndexArray:
    """Return pairs (n, 2) of leaves of faces that may come nearer than `within`, a length.

    A leaf is given by its row in `tables.leaves`. Each pair is listed once; see `list_near_leaves`.
    """
    count = PAIRS_PER_LEAF * len(tables.leaves)
    while True:
        pairs: IndexArray = np.empty((count, 2), np.int64)
        count = near_leaves_nb.list_near_leaves(
            tables.tree, tables.leaves, tables.plates, within, pairs
        )
        if count <= len(pairs):
            return pairs[:count]


def _crosses(body: Faces, a: _Places, b: _Places, margin: float) -> NDArray[np.bool_]:
    """Return a mask (n,) of places at which faces cross, or begin to cross.

    Places a and b of a row are one point. Faces cross if their tangent planes meet at an angle, and
    both continue in these planes by `margin`, length, one way along the line of intersection, and
    from there as far to both sides of the other face. Places of one face within 4 `margin` of each
    other do not count.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = [np.cross(face.tangents[:, 0], face.tangents[:, 1]) for face in (a, b)]
        normals = [n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals]
        line = np.cross(normals[0], normals[1])
        sine = np.linalg.norm(line, axis=1)
        line /= sine[:, None]
        sideways = [np.cross(line, normal) / sine[:, None] for normal in normals]
    distance = np.linalg.norm(((b.uv - a.uv)[:, None] @ a.tangents)[:, 0], axis=1)
    crosses = (sine > MIN_SINE) & ((a.patch != b.patch) | (distance > 4.0 * margin))
    candidates = np.flatnonzero(crosses)
    faces = a.of(candidates), b.of(candidates)
    line, sideways = line[candidates], [side[candidates] for side in sideways]
    to_uv = [np.linalg.pinv(f.tangents.transpose(0, 2, 1), rcond=SINGULAR_TOL) for f in faces]
    is_proved = np.zeros(len(candidates), bool)
    for sign in (1.0, -1.0):
        rows = np.flatnonzero(~is_proved)
        for side_sign in (0.0, 1.0, -1.0):
            for face, inverse, side in zip(faces, to_uv, sideways, strict=True):
                step = margin * (sign * line[rows] + side_sign * side[rows])
                uv = face.uv[rows] + (inverse[rows] @ step[:, :, None])[:, :, 0]
                target = face.point[rows] + step
                rows = rows[_contains(body, face.patch[rows], uv, target, margin)]
        is_proved[rows] = True
    crosses[candidates] = is_proved
    return crosses


def _contains(
    body: Faces, patch: IndexArray, uv: FloatArray, target: FloatArray, margin: float
) -> NDArray[np.bool_]:
    """Return a mask (n,): the point of each patch at (u, v) is within half of `margin` of `target`.

    `patch` (n,), `uv` (n, 2) and `target` (n, 3) have one row a test; nothing is projected. False
    where (u, v) is outside the domain of the patch or its trims.
    """
    contains = np.zeros(len(uv), bool)
    for k in np.unique(patch).tolist():
        rows = np.flatnonzero(patch == k)
        low, high = np.array(body.patches[k].domain).T
        rows = rows[((low <= uv[rows]) & (uv[rows] <= high)).all(axis=1)]
        miss = np.linalg.norm(body.patches[k].evaluate(uv[rows]) - target[rows], axis=1)
        rows = rows[miss <= 0.5 * margin]
        if body.trims[k] is not None:
            rows = rows[points_in_trim(body.trim_tables, k, as_contiguous(uv[rows], np.float64))]
        contains[rows] = True
    return contains
