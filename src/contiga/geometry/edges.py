"""Edges of a body: curves in space with the sides of patches that meet there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

SIDES = ("u0", "u1", "v0", "v1")
"""Natural sides of an untrimmed patch, by their index in an `EdgeUse`."""
UNTRIMMED = -1
"""Loop index of an `EdgeUse` on a natural side."""


class EdgeUse(NamedTuple):
    """One side of an edge: where a patch uses it."""

    patch: int
    loop: int
    """Loop of the patch's trims, −1 for a natural side of an untrimmed patch."""
    index: int  # type: ignore[assignment]  # shadows tuple.index, which nobody needs here
    """p-curve in the loop, or the side 0 … 3 = u0, u1, v0, v1."""
    reversed: bool
    """Whether the p-curve (or the side's growing parameter) runs against the edge's curve."""


class BodyEdge(NamedTuple):
    """An edge of a body: its curve in space and the patches that meet there."""

    curve: NurbsCurve
    tolerance: float
    """Bound on the distance between the curve and the patches' own images of it, length.
    `Body.edges` raises it where the measured gap is larger."""
    uses: tuple[EdgeUse, ...]
    """One use: a free border. Two: the patches join (twice the same patch: a seam)."""
    spans: tuple[tuple[float, float], ...] = ()
    """Per use the parameter interval on the p-curve or side, low to high."""
    stated: float = 0.0
    """Tolerance that the file states for the distance, length; 0 if none."""
    corner: float = 0.0
    """Tolerance that the file states from ends of images to their corner, length; 0 if none."""
    gap: float = math.nan
    """Distance measured by `Body.edges`, length; NaN before."""

    def span(self, k: int) -> tuple[float, float] | None:
        """Return the interval of its use `k`; None for the full p-curve or side."""
        return self.spans[k] if self.spans else None


def moved_edge(edge: BodyEdge, matrix: FloatArray) -> BodyEdge:
    """Return `edge` moved by an affine (4, 4) matrix, its tolerances scaled by the largest stretch.

    If lengths do not scale evenly, the gap becomes NaN, for it to be measured anew.
    """
    factors = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    even = factors[0] - factors[-1] <= 1e-9 * factors[0]
    scale = float(factors[0])
    return edge._replace(
        curve=edge.curve.transformed(matrix),
        tolerance=edge.tolerance * scale,
        stated=edge.stated * scale,
        corner=edge.corner * scale,
        gap=edge.gap * scale if even else math.nan,
    )


def mirrored(curve: NurbsCurve, domain: tuple[float, float]) -> NurbsCurve:
    """Return a p-curve with u replaced by u0 + u1 − u, in the same direction."""
    reflection = np.diag([-1.0, 1.0, 1.0, 1.0])
    reflection[0, 3] = domain[0] + domain[1]
    return curve.transformed(reflection)


def flipped_edge(edge: BodyEdge, patches: Sequence[NurbsSurface]) -> BodyEdge:
    """Return `edge` for patches whose u direction is reversed.

    Sides u0 and u1 are exchanged; along v0 and v1 the parameter runs in the opposite direction.
    Uses of p-curves stay, for these are mirrored themselves.
    """
    uses: list[EdgeUse] = []
    spans: list[tuple[float, float]] = []
    for k, use in enumerate(edge.uses):
        span = edge.span(k)
        if use.loop != UNTRIMMED:
            uses.append(use)
        elif use.index < 2:
            uses.append(use._replace(index=1 - use.index))
        else:
            uses.append(use._replace(reversed=not use.reversed))
            if span is not None:
                total = sum(patches[use.patch].domain[0])
                span = (total - span[1], total - span[0])
        if span is not None:
            spans.append(span)
    return edge._replace(uses=tuple(uses), spans=tuple(spans))
