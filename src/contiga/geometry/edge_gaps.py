"""Measure how well faces meet along the edges of a body, on their own images of each edge.

A face ends at its p-curves. Their images in space, on the face's surface, may miss the curve of the
edge, and so the next face, by as much as the file's tolerance allows or more.
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

RECHECK_SHARE = 1e-6
"""Gaps above this share of an edge's box are measured a second time, on finer samples."""
N_CHORDS = 256
"""Chords by which the length of an image is measured: full circles come out 3e-5 short."""
GAP_MARGIN = 1.02
"""Factor on the measured gap, which may be a little larger between samples."""

Trims = Sequence[tuple[Loop, ...] | None]


class Image(NamedTuple):
    """A face's own image of an edge."""

    gap: float
    """Largest distance to the edge's curve, length."""
    point: tuple[float, float, float]
    """Point of the image at that distance."""


def image_of(edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims) -> Image:
    """Return the `Image` of an edge by its use `k`: largest distance from its curve, and where.

    It is the distance of the farthest sample, refined around that one: see `image_gap`.
    """
    patch = patches[edge.uses[k].patch]
    (u0, u1), (v0, v1) = patch.domain
    recheck = RECHECK_SHARE * float(np.ptp(edge.curve.bounds(), axis=0).max())
    out = np.empty(4)
    image_gap(
        patch.arrays,
        image_curve(edge, k, patches, trims).arrays,
        edge.curve.arrays,
        np.array([u0, u1, v0, v1]),
        recheck,
        out,
    )
    gap, x, y, z = out.tolist()
    return Image(gap, (x, y, z))


def image_length(edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims) -> float:
    """Return the length of the image of `edge` by its use `k`, by `N_CHORDS` chords."""
    patch = patches[edge.uses[k].patch]
    curve = image_curve(edge, k, patches, trims)
    low, high = np.transpose(patch.domain)
    uv = curve.evaluate(np.linspace(*curve.domain, N_CHORDS + 1))[:, :2]
    points = patch.evaluate(np.clip(uv, low, high))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def image_curve(
    edge: BodyEdge, k: int, patches: Sequence[NurbsSurface], trims: Trims
) -> NurbsCurve:
    """Return the full p-curve of use `k`; for a natural side the line between its span's ends."""
    use = edge.uses[k]
    loops, domain = trims[use.patch], patches[use.patch].domain
    if loops is not None:
        return loops[use.loop][use.index]
    fixed, free = use.index // 2, 1 - use.index // 2
    low, high = edge.span(k) or domain[free]
    points = np.empty((2, 2))
    points[:, fixed] = domain[fixed][use.index % 2]
    points[:, free] = low, high
    return NurbsCurve(1, [low, low, high, high], points)


def with_measured_gaps(
    edges: Sequence[BodyEdge], patches: Sequence[NurbsSurface], trims: Trims
) -> tuple[BodyEdge, ...]:
    """Return `edges` with all gaps measured, and tolerances that cover them.

    Edges with a gap stay the same. Those with NaN get the largest gap of their images, a tolerance
    of at least `GAP_MARGIN` times that, and their former tolerance as `stated` if that is larger.
    """
    result = []
    for edge in edges:
        if np.isnan(edge.gap):
            images = [image_of(edge, k, patches, trims) for k in range(len(edge.uses))]
            gap = max((image.gap for image in images), default=0.0)
            edge = edge._replace(
                gap=gap,
                tolerance=max(GAP_MARGIN * gap, edge.tolerance),
                stated=max(edge.stated, edge.tolerance),
            )
        result.append(edge)
    return tuple(result)
