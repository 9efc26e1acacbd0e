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

POINT = 1e-9
"""What stays this close to its start, as a share of the body's size, is a point."""
ROUNDING = 1e-4
"""Faces that share an edge meet to this share of the size, whatever a file says; gaps above it
are told of."""
LARGEST = 1e-2
"""Gaps above this share of the size are openings, whatever a file says."""
SLACK = 2.0
"""A stated tolerance holds for each face's distance to the edge: between faces it counts twice."""
ALONG = 5
"""Points of a trimming piece that are looked at."""


def widest_slit(body: Faces) -> float:
    """Faces that share an edge and are farther off it than this do not meet there, length."""
    size = body.size
    return min(max(SLACK * stated_tolerance(body), ROUNDING * size), LARGEST * size)


def stated_tolerance(body: Faces) -> float:
    """The largest tolerance a file states of the edges and corners of its faces, length."""
    return max((max(edge.stated, edge.corner) for edge in body.edges), default=0.0)


@once
def gaping_edges(body: Faces) -> NDArray[np.bool_]:
    """Return (edges,) shared edges whose faces are too far off them to meet."""
    widest = widest_slit(body)
    return locked(np.array([len(e.uses) > 1 and e.gap > widest for e in body.edges], dtype=bool))


@once
def stitches(body: Faces) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Extents (pieces,) in space of trimming pieces that are of no edge, and which are open.

    Such pieces run along a pole, or close a loop whose p-curves do not quite meet: there the
    surface does not end. How far p-curves may be apart the tolerances of their edges say.
    """
    trims = body.trim_tables
    extent = np.zeros(len(trims.piece_edge))
    is_open = np.zeros(len(extent), dtype=bool)
    loose = np.flatnonzero(trims.piece_edge < 0)
    if len(loose) == 0:
        return locked(extent), locked(is_open)
    reach = reach_of_loops(body)
    last = np.take_along_axis(trims.piece_coefs, trims.piece_degree[:, None, None], axis=1)[:, 0]
    first = trims.piece_coefs[:, 0]
    a, b = first[:, None, :2] / first[:, None, 2:], last[:, None, :2] / last[:, None, 2:]
    share = np.linspace(0.0, 1.0, ALONG)[:, None]
    for patch in np.unique(trims.piece_patch[loose]):
        pieces = loose[trims.piece_patch[loose] == patch]
        # p-curves of CAD files stick out by their tolerance.
        low, high = np.transpose(body.patches[patch].domain)
        uv = np.clip(a[pieces] + share * (b[pieces] - a[pieces]), low, high)
        points = body.patches[patch].evaluate(uv.reshape(-1, 2)).reshape(len(pieces), ALONG, 3)
        extent[pieces] = np.linalg.norm(points - points[:, :1], axis=2).max(axis=1)
        allowed = [reach[int(patch), int(loop)] for loop in trims.piece_loop[pieces, 0]]
        is_open[pieces] = extent[pieces] > np.array(allowed)
    return locked(extent), locked(is_open)


def reach_of_points(body: Faces) -> float:
    """Length that no tolerance of the body tells from a point."""
    size = body.size
    return min(SLACK * stated_tolerance(body) + POINT * size, LARGEST * size)


def reach_of_loops(body: Faces) -> defaultdict[tuple[int, int], float]:
    """By patch and loop (`UNTRIMMED` round its rectangle) what counts as a point there, length."""
    size = body.size
    reach: defaultdict[tuple[int, int], float] = defaultdict(lambda: POINT * size)
    for edge in body.edges:
        nearest = min(
            SLACK * max(edge.tolerance, edge.stated, edge.corner) + POINT * size, LARGEST * size
        )
        for use in edge.uses:
            key = (use.patch, use.loop)
            reach[key] = max(reach[key], nearest)
    return reach
