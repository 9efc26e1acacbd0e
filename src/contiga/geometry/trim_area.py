"""Area of a body with its trims: Green's theorem over exact p-curves.

The area of a trimmed patch is ``∮ F dv`` along its loops, ``F(u, v) = ∫ |S_u × S_v| du`` up to the
curve. Both integrals are cut at the borders of elements and at turning points, between which the
integrand is smooth, so Gauss rules converge at their full order; parts are halved until two
results agree.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contiga.geometry._trim_area_nb import loop_area
from contiga.geometry._trim_nb import TrimTables
from contiga.geometry.bezier import extract
from contiga.geometry.quadrature import gauss, surface_area
from contiga.geometry.surface import NurbsSurface

if TYPE_CHECKING:
    from contiga.geometry.body import Body

MOST_PARTS = 64
_EXTRA = 5


def body_area(body: Body, rtol: float = 1e-9) -> float:
    """Area of `body`, trims obeyed, to about the relative tolerance `rtol`; length²."""
    return float(sum(patch_areas(body, rtol)))


def patch_areas(body: Body, rtol: float = 1e-9) -> np.ndarray:
    """(m,) area of every patch of `body`, trims obeyed."""
    tables = body.trim_tables
    areas = np.empty(len(body.patches))
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        if loops is None:
            areas[k] = surface_area(patch, max(rtol, 1e-13))
        else:
            areas[k] = _trimmed_area(tables, k, patch, rtol)
    return areas


def _trimmed_area(tables: TrimTables, k: int, patch: NurbsSurface, rtol: float) -> float:
    centre = patch.bounds().mean(axis=0)
    grid = tuple(extract(patch.translated(-centre)))
    nodes, weights = gauss(max(patch.degrees) + _EXTRA)
    first, last = tables.patch_start[k], tables.patch_start[k + 1]
    pieces = np.arange(first, last)
    loops = tables.piece_loop[first:last, 0]
    groups = [pieces[loops == number] for number in np.unique(loops)]
    before = np.inf
    parts = 1
    while True:
        rule = (nodes, weights, parts)
        area = float(sum(loop_area(tables, group, grid, rule) for group in groups))
        if abs(area - before) <= 10.0 * rtol * abs(area) or parts >= MOST_PARTS:
            return area
        before, parts = area, 2 * parts
