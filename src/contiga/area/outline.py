"""Outlines of the regions of contact: closed lines where contact ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.area.cuts import Cut, Parts, cut_parts, parts_of
from contiga.area.kernels import chain_nb, components_nb, touch_nb
from contiga.area.method import AreaInput, Outlines
from contiga.area.regions import Topology
from contiga.records import FloatArray, IntArray, empty_projection

Pairs = NDArray[np.int64]


class _Cuts(NamedTuple):
    """The edges on which contact ends, each once."""

    inner: IntArray
    """(c,) the end in contact, among the points in contact."""
    free: IntArray
    """(c,) the other end, among all points."""
    fraction: FloatArray
    """(c,) place of the cut, as a fraction of the edge from its inner end."""


def facet_outlines(inp: AreaInput, topology: Topology, on: str) -> Outlines:
    """Return where the parts of facets in contact end, on the slave or on the master.

    A side of an odd number of parts is on an outline. Cuts are taken from the cache of `inp` if an
    area was measured before. On the master cuts lie at their own feet, or without one at the foot
    of their end in contact.
    """
    n_c = len(inp.rows)
    if n_c == 0:
        return no_outlines()
    place = np.full(len(inp.points), -1, np.int32)
    whole, part = touch_nb.touched(topology, inp.rows, place)
    label = components_nb.facet_components(whole, place[topology.facets[part]], n_c)
    sides = np.concatenate([whole[:, [0, 1]], whole[:, [1, 2]], whole[:, [2, 0]]])
    segments = sides.astype(np.int64)
    cuts = _Cuts(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0))
    if len(part):
        if inp.kept is not None and "parts" in inp.kept:  # left there by measuring the area
            parts, cut = inp.kept["parts"]
        else:
            parts = parts_of(inp, topology, part, place)
            cut = cut_parts(inp, parts)
        part_segments, cuts = _cut_segments(parts, cut, n_c)
        segments = np.concatenate([segments, part_segments])
    # The segments that bound the region are sides of an odd number of parts.
    low, high = segments.min(axis=1), segments.max(axis=1)
    n = int(high.max(initial=0)) + 1
    keys, count = np.unique((low * n + high)[low != high], return_counts=True)
    keys = keys[count % 2 == 1]
    order, first = chained(np.stack([keys // n, keys % n], axis=1))

    p_inner, p_free = inp.points[inp.rows[cuts.inner]], inp.points[cuts.free]
    corners = inp.points[inp.rows]
    cut_points: FloatArray = p_inner + cuts.fraction[:, None] * (p_free - p_inner)
    if on == "master":
        corners = inp.feet.point
        if len(cut_points):
            feet = empty_projection(len(cut_points))
            patch, uv = inp.feet.patch[cuts.inner], inp.feet.uv[cuts.inner]
            inp.body.surface.track(np.ascontiguousarray(cut_points), patch, uv, feet)
            inner_foot = inp.feet.point[cuts.inner]
            cut_points = np.where(np.isfinite(feet.point), feet.point, inner_foot)
    points = np.concatenate([corners, cut_points])
    cluster = np.concatenate([label, label[cuts.inner]])
    return Outlines(points[order], first, cluster[order[first[:-1]]].astype(np.int32))


def no_outlines() -> Outlines:
    """Return the outlines of no contact."""
    return Outlines(np.zeros((0, 3)), np.zeros(1, np.int64), np.zeros(0, np.int32))


def joined(lines: list[FloatArray], clusters: list[int]) -> Outlines:
    """Return outlines from closed lines (k, 3), with the cluster of each."""
    if not lines:
        return no_outlines()
    first = np.concatenate(([0], np.cumsum([len(line) for line in lines])))
    return Outlines(
        np.concatenate(lines), first.astype(np.int64), np.asarray(clusters, dtype=np.int32)
    )


def chained(ends: Pairs) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Chain segments (m, 2), an even number at each node, to closed lines.

    Returns their nodes, line after line, and where each line starts in them and the last one ends.
    """
    m, nodes = len(ends), ends.ravel()
    around = np.argsort(nodes, kind="stable") // 2
    first = np.concatenate(([0], np.cumsum(np.bincount(nodes))))
    order, starts = np.empty(2 * m, np.int64), np.empty(m + 1, np.int64)
    n = chain_nb.chain(ends, first, around, order, starts)
    return order[: starts[n]], starts[: n + 1]


def _cut_segments(parts: Parts, cut: Cut, n_c: int) -> tuple[Pairs, _Cuts]:
    """Return the sides (s, 2) of the parts in contact of cut facets, and the cuts, each once.

    Ends of sides are indices among the points in contact, or n_c plus the number of a cut. An edge
    of two facets is one cut, with the fraction of the first.
    """
    touches = parts.corner < len(parts.inner)
    next_touches = np.roll(touches, -1, axis=1)
    facet, k = np.nonzero(touches != next_touches)
    l = (k + 1) % 3
    corner = np.where(touches[facet, k], parts.corner[facet, k], parts.corner[facet, l])
    free = np.where(touches[facet, k], parts.nodes[facet, l], parts.nodes[facet, k])
    inner = parts.inner[corner]
    keys = inner.astype(np.int64) * (int(parts.nodes.max()) + 1) + free
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    number = n_c + number.ravel()
    # A facet has two cuts: the line between them, and from each to its end in contact.
    between_cuts = np.stack([number[0::2], number[1::2]], axis=1)
    to_inner = np.stack([number, inner], axis=1)
    fraction = cut.fraction[facet, k]
    facet, k = np.nonzero(touches & next_touches)
    sides = np.stack([parts.corner[facet, k], parts.corner[facet, (k + 1) % 3]], axis=1)
    return (
        np.concatenate([between_cuts, to_inner, parts.inner[sides]]).astype(np.int64),
        _Cuts(inner[first], free[first].astype(np.int32), fraction[first]),
    )
