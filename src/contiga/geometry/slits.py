"""Tell slits within a body's tolerance from openings of its borders."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.once import once
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

POINT_TOL = 1e-9
"""A curve that stays this close to its start, as a share of the body's size, is a point."""
ROUNDING = 1e-4
"""Faces that share an edge meet to this share of the size, whatever a file states; larger gaps are
reported."""
MAX_SLIT = 1e-2
"""Gaps above this share of the size are openings, whatever a file states."""
TWO_FACES = 2.0
"""A stated tolerance bounds each face's distance to the edge, so twice that between faces."""
N_SAMPLES = 5
"""Samples of a trimming piece."""


def widest_slit(body: Faces) -> float:
    """Return the distance from a shared edge, length, beyond which a face does not meet it.

    Twice the largest tolerance of the file, at least `ROUNDING` and at most `MAX_SLIT` of the size.
    """
    size = body.size
    return min(max(TWO_FACES * stated_tolerance(body), ROUNDING * size), MAX_SLIT * size)


def stated_tolerance(body: Faces) -> float:
    """Return the largest tolerance that a file states for edges and corners, length."""
    return max((max(edge.stated, edge.corner) for edge in body.edges), default=0.0)


@once
def gaping_edges(body: Faces) -> NDArray[np.bool_]:
    """Return (edges,) which edges are shared by faces farther from them than `widest_slit`."""
    widest = widest_slit(body)
    return locked(np.array([len(e.uses) > 1 and e.gap > widest for e in body.edges], dtype=bool))


@once
def stitches(body: Faces) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the extents (pieces,) in space of trimming pieces without an edge, and which are open.

    Such pieces run along a pole, or close a loop whose p-curves do not quite meet: there the
    surface does not end, unless the extent exceeds `reach_of_loops`. The extent is the largest
    distance of `N_SAMPLES` points from the first; zero for pieces with an edge. Both are read-only.
    """
    trims = body.trim_tables
    extent = np.zeros(len(trims.piece_edge))
    is_open = np.zeros(len(extent), dtype=bool)
    without_edge = np.flatnonzero(trims.piece_edge < 0)
    if len(without_edge) == 0:
        return locked(extent), locked(is_open)
    reach = reach_of_loops(body)
    last = np.take_along_axis(trims.piece_coefs, trims.piece_degree[:, None, None], axis=1)[:, 0]
    first = trims.piece_coefs[:, 0]
    a, b = first[:, None, :2] / first[:, None, 2:], last[:, None, :2] / last[:, None, 2:]
    share = np.linspace(0.0, 1.0, N_SAMPLES)[:, None]
    for patch in np.unique(trims.piece_patch[without_edge]):
        pieces = without_edge[trims.piece_patch[without_edge] == patch]
        # p-curves of CAD files stick out by their tolerance.
        low, high = np.transpose(body.patches[patch].domain)
        uv = np.clip(a[pieces] + share * (b[pieces] - a[pieces]), low, high)
        points = body.patches[patch].evaluate(uv.reshape(-1, 2)).reshape(len(pieces), N_SAMPLES, 3)
        extent[pieces] = np.linalg.norm(points - points[:, :1], axis=2).max(axis=1)
        limits = [reach[int(patch), int(loop)] for loop in trims.piece_loop[pieces, 0]]
        is_open[pieces] = extent[pieces] > np.array(limits)
    return locked(extent), locked(is_open)


def reach_of_points(body: Faces) -> float:
    """Return the size, length, up to which a curve is a point within the body's tolerances.

    Twice the largest tolerance of the file and `POINT_TOL` of the size, at most `MAX_SLIT` of it.
    """
    size = body.size
    return min(TWO_FACES * stated_tolerance(body) + POINT_TOL * size, MAX_SLIT * size)


def reach_of_loops(body: Faces) -> defaultdict[tuple[int, int], float]:
    """Return by patch and loop the size, length, up to which a curve of the loop is a point.

    The loop round a rectangle is `UNTRIMMED`. As in `reach_of_points`, but by the tolerances of the
    loop's edges alone, measured gaps included. A loop without edges has `POINT_TOL` of the size.
    """
    size = body.size
    reach: defaultdict[tuple[int, int], float] = defaultdict(lambda: POINT_TOL * size)
    for edge in body.edges:
        limit = min(
            TWO_FACES * max(edge.tolerance, edge.stated, edge.corner) + POINT_TOL * size,
            MAX_SLIT * size,
        )
        for use in edge.uses:
            key = (use.patch, use.loop)
            reach[key] = max(reach[key], limit)
    return reach
