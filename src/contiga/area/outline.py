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
    """(c,) way from the one to the other."""


def facet_outlines(inp: AreaInput, topology: Topology, on: str) -> Outlines:
    """Return where the parts of facets in contact end, on the slave or on the master."""
    n_c = len(inp.rows)
    if n_c == 0:
        return no_outlines()
    place = np.full(len(inp.points), -1, np.int32)
    whole, part = touch_nb.touched(topology, inp.rows, place)
    label = components_nb.facet_components(whole, place[topology.facets[part]], n_c)
    segments = [_sides(whole)]
    cuts = _Cuts(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0))
    if len(part):
        lines, cuts = _of_parts(*_cut(inp, topology, part, place), n_c)
        segments.append(lines)
    places = np.concatenate([_vertices(inp, on), _cut_places(inp, cuts, on)])
    cluster = np.concatenate([label, label[cuts.inner]])
    order, first = chained(_ends_of(np.concatenate(segments)))
    return Outlines(places[order], first, cluster[order[first[:-1]]].astype(np.int32))


def _cut(inp: AreaInput, topology: Topology, part: IntArray, place: IntArray) -> tuple[Parts, Cut]:
    """The facets `part` and where they are cut, as measuring the area left them."""
    if inp.kept is not None and "parts" in inp.kept:
        kept: tuple[Parts, Cut] = inp.kept["parts"]
        return kept
    parts = parts_of(inp, topology, part, place)
    return parts, cut_parts(inp, parts)


def no_outlines() -> Outlines:
    """Return an outline without contact."""
    return Outlines(np.zeros((0, 3)), np.zeros(1, np.int64), np.zeros(0, np.int32))


def joined(lines: list[FloatArray], clusters: list[int]) -> Outlines:
    """Outlines from closed lines (k, 3), one a cluster."""
    if not lines:
        return no_outlines()
    first = np.concatenate(([0], np.cumsum([len(line) for line in lines])))
    return Outlines(
        np.concatenate(lines), first.astype(np.int64), np.asarray(clusters, dtype=np.int32)
    )


def chained(ends: Pairs) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Closed lines from segments (m, 2) of which every node has an even number.

    Returns their nodes, line after line, and where each line starts in them and the last one ends.
    """
    m, nodes = len(ends), ends.ravel()
    around = np.argsort(nodes, kind="stable") // 2
    first = np.concatenate(([0], np.cumsum(np.bincount(nodes))))
    order, starts = np.empty(2 * m, np.int64), np.empty(m + 1, np.int64)
    n = chain_nb.chain(ends, first, around, order, starts)
    return order[: starts[n]], starts[: n + 1]


def _sides(corner: IntArray) -> Pairs:
    pairs = [corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]]
    return np.concatenate(pairs).astype(np.int64)


def _ends_of(segments: Pairs) -> Pairs:
    """Segments that bound: those of an odd number of parts."""
    low, high = segments.min(axis=1), segments.max(axis=1)
    n = int(high.max(initial=0)) + 1
    keys, count = np.unique((low * n + high)[low != high], return_counts=True)
    odd = keys[count % 2 == 1]
    return np.stack([odd // n, odd % n], axis=1)


def _of_parts(parts: Parts, cut: Cut, n_c: int) -> tuple[Pairs, _Cuts]:
    """Sides of the parts of cut facets, cuts numbered from n_c; and the cuts."""
    inside = parts.corner < len(parts.inner)
    following = np.roll(inside, -1, axis=1)
    facet, k = np.nonzero(inside != following)
    l = (k + 1) % 3
    first_in = inside[facet, k]
    corner = np.where(first_in, parts.corner[facet, k], parts.corner[facet, l])
    other = np.where(first_in, parts.nodes[facet, l], parts.nodes[facet, k])
    inner = parts.inner[corner]
    keys = inner.astype(np.int64) * (int(parts.nodes.max()) + 1) + other
    _, once, number = np.unique(keys, return_index=True, return_inverse=True)
    number = n_c + number.ravel()
    # Two cuts a facet: the line between them, and from each to its end in contact.
    across = np.stack([number[0::2], number[1::2]], axis=1)
    along = np.stack([number, inner], axis=1)
    facet, k = np.nonzero(inside & following)
    sides = np.stack([parts.corner[facet, k], parts.corner[facet, (k + 1) % 3]], axis=1)
    fraction = cut.fraction[np.nonzero(inside != following)]
    return (
        np.concatenate([across, along, parts.inner[sides]]).astype(np.int64),
        _Cuts(inner[once], other[once].astype(np.int32), fraction[once]),
    )


def _vertices(inp: AreaInput, on: str) -> FloatArray:
    return inp.feet.point if on == "master" else inp.points[inp.rows]


def _cut_places(inp: AreaInput, cuts: _Cuts, on: str) -> FloatArray:
    a, b = inp.points[inp.rows[cuts.inner]], inp.points[cuts.free]
    places: FloatArray = a + cuts.fraction[:, None] * (b - a)
    if on == "slave" or len(places) == 0:
        return places
    out = empty_projection(len(places))
    patch, uv = inp.feet.patch[cuts.inner], inp.feet.uv[cuts.inner]
    inp.body.surface.track(np.ascontiguousarray(places), patch, uv, out)
    return np.where(np.isfinite(out.point), out.point, inp.feet.point[cuts.inner])
