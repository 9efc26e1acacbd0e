"""Shared edges of untrimmed patches, found from coinciding sides if a file names none."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import Edge
from contiga.io.cad.loops import Loop, PCurve, Sides
from contiga.records import FloatArray

COINCIDENT = 1e-9
"""Largest distance of coinciding sides, as a share of the whole size."""
SAMPLES = 9


def side_curve(surface: NurbsSurface, side: int) -> NurbsCurve:
    """Return the natural side 0 … 3 = u0, u1, v0, v1 by its growing parameter."""
    (u0, u1), (v0, v1) = surface.domain
    if side < 2:
        return surface.isocurve(u=(u0, u1)[side])
    return surface.isocurve(v=(v0, v1)[side - 2])


def coincident_sides(
    surfaces: list[NurbsSurface],
) -> tuple[list[tuple[Loop, Sides]], dict[int, Edge]]:
    """Number the sides of `surfaces` so that coinciding ones share a number.

    Two sides coincide if they are the same curve with the same parameters, forwards or backwards.
    Sides that are one point have no number.

    Returns
    -------
    sides : per surface its four sides as a loop, ready for `Assembly.add_whole`
    edges : the edges by number
    """
    sampled = _samples(surfaces)
    size = float(np.ptp(sampled.reshape(-1, 3), axis=0).max()) if surfaces else 0.0
    near = COINCIDENT * size
    keys: dict[tuple[int, ...], list[int]] = {}
    number = np.arange(len(sampled))
    against = np.zeros(len(sampled), dtype=bool)
    collapsed = np.abs(sampled - sampled[:, :1]).max(axis=(1, 2)) <= near
    for k in np.flatnonzero(~collapsed):
        # The mean of both ends and the middle is the same from either end.
        middle = (sampled[k, 0] + sampled[k, -1] + sampled[k, SAMPLES // 2]) / 3.0
        cell = np.floor(middle / max(1e3 * near, 1e-300)).astype(np.int64)
        for step in np.ndindex(3, 3, 3):
            keys.setdefault(tuple(cell + np.array(step) - 1), []).append(int(k))
    for group in keys.values():
        for a, b in combinations(sorted(set(group)), 2):
            turned = _match(sampled[a], sampled[b], near)
            if turned is not None and number[b] == b:
                number[b] = number[a]
                against[b] = against[a] != turned
    number[collapsed] = -1
    return _as_loops(surfaces, number, against)


def _match(a: FloatArray, b: FloatArray, near: float) -> bool | None:
    """Compare two sampled sides: False if equal, True if reversed, None if different."""
    if np.abs(a - b).max() <= near:
        return False
    if np.abs(a - b[::-1]).max() <= near:
        return True
    return None


def _samples(surfaces: list[NurbsSurface]) -> FloatArray:
    rows = []
    for surface in surfaces:
        for side in range(4):
            curve = side_curve(surface, side)
            rows.append(curve.evaluate(np.linspace(*curve.domain, SAMPLES)))
    return np.array(rows).reshape(-1, SAMPLES, 3)


def _as_loops(
    surfaces: list[NurbsSurface], number: np.ndarray, against: np.ndarray
) -> tuple[list[tuple[Loop, Sides]], dict[int, Edge]]:
    edges: dict[int, Edge] = {}
    result = []
    for k, surface in enumerate(surfaces):
        loop: Loop = []
        spans = []
        for side in range(4):
            which = int(number[4 * k + side])
            curve = side_curve(surface, side)
            if which == 4 * k + side:
                edges[which] = Edge(curve, 0.0)
            loop.append(PCurve(curve, which, bool(against[4 * k + side]), 0.0))
            spans.append(curve.domain)
        result.append((loop, Sides([0, 1, 2, 3], [False] * 4, spans)))
    return result, edges
