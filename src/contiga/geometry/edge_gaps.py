"""Measure how well faces meet along the edges of a body, on their own images of each edge.

A face ends at its p-curves. What they are in space, on the face's surface, may miss the curve of
the edge, and so the next face, by as much as the file's tolerance allows or more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge
from contiga.geometry.kernels.edge_gap_nb import image_gap
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import Loop

BELIEVED = 1e-6
"""Misses up to this share of an edge's box are not looked at twice."""
CHORDS = 256
"""Of an image whose length is measured: whole circles come out 3e-5 short."""
MORE = 1.02
"""Between samples an image may be a little farther off."""

Trims = Sequence[tuple[Loop, ...] | None]


class Image(NamedTuple):
    """A face's own image of an edge."""

    gap: float
    """Largest distance to the edge's curve, length."""
    point: tuple[float, float, float]
    """Point of the image where it is so far off."""


def image_of(edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims) -> Image:
    """The image of `edge` by its use `k`, measured at samples refined around the worst."""
    patch = patches[edge.uses[k].patch]
    (u0, u1), (v0, v1) = patch.domain
    near = BELIEVED * float(np.ptp(edge.curve.bounds(), axis=0).max())
    out = np.empty(4)
    image_gap(
        patch.arrays,
        image_curve(edge, k, patches, trims).arrays,
        edge.curve.arrays,
        np.array([u0, u1, v0, v1]),
        near,
        out,
    )
    gap, x, y, z = out.tolist()
    return Image(gap, (x, y, z))


def image_length(edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims) -> float:
    """Length of the image of `edge` by its use `k`, by chords."""
    patch = patches[edge.uses[k].patch]
    curve = image_curve(edge, k, patches, trims)
    low, high = np.transpose(patch.domain)
    uv = curve.evaluate(np.linspace(*curve.domain, CHORDS + 1))[:, :2]
    points = patch.evaluate(np.clip(uv, low, high))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def image_curve(
    edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims
) -> NurbsCurve:
    """The p-curve of use `k`; of a natural side the line between the ends of its span."""
    use = edge.uses[k]
    loops, domain = trims[use.patch], patches[use.patch].domain
    if loops is not None:
        return loops[use.loop][use.index]
    across, along = use.index // 2, 1 - use.index // 2
    low, high = edge.span(k) or domain[along]
    points = np.empty((2, 2))
    points[:, across] = domain[across][use.index % 2]
    points[:, along] = low, high
    return NurbsCurve(1, [low, low, high, high], points)


def measured(
    edges: Sequence[BodyEdge], patches: Sequence[NurbsSurface], trims: Trims
) -> tuple[BodyEdge, ...]:
    """`edges` with their gap measured where it was not, and no tolerance below it."""
    result = []
    for edge in edges:
        if np.isnan(edge.gap):
            images = [image_of(edge, k, patches, trims) for k in range(len(edge.uses))]
            gap = max((image.gap for image in images), default=0.0)
            edge = edge._replace(
                gap=gap,
                tolerance=max(MORE * gap, edge.tolerance),
                stated=max(edge.stated, edge.tolerance),
            )
        result.append(edge)
    return tuple(result)
