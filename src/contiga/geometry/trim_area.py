"""Area of a body with its trims: Green's theorem over exact p-curves.

The area of a trimmed patch is ``∮ F dv`` along its loops, ``F(u, v) = ∫ |S_u × S_v| du`` up to the
curve. Both integrals are cut at the borders of elements and at turning points, between which the
integrand is smooth, so Gauss rules converge at their full order; parts are halved until two
results agree.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contiga.geometry.bezier import extract
from contiga.geometry.kernels.trim_area_nb import loop_integral, rectangle_integral
from contiga.geometry.kernels.trim_nb import TrimTables
from contiga.geometry.quadrature import gauss, surface_area
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

AREA, VOLUME = 0, 1
MOST_PARTS = 64
_FEW, _MORE = 4, 3
"""Points beyond the degree of the first rule, and what the second has on top."""


def body_area(body: Faces, rtol: float = 1e-9) -> float:
    """Area of `body`, trims obeyed, to about the relative tolerance `rtol`; length²."""
    return float(patch_areas(body, rtol).sum())


def body_volume(body: Faces, rtol: float = 1e-9) -> float:
    """Volume that `body` encloses, length³: ⅓ ∮ S · n dA, positive if normals point outward.

    Positions count from the middle of the bounds, which leaves a closed body's volume as it is.
    """
    return float(patch_volumes(body, body.bounds().mean(axis=0), rtol).sum())


def patch_areas(body: Faces, rtol: float = 1e-9) -> FloatArray:
    """(m,) area of every patch of `body`, trims obeyed."""
    areas = np.empty(len(body.patches))
    for k, (patch, loops) in enumerate(zip(body.patches, body.trims, strict=True)):
        if loops is None:
            areas[k] = surface_area(patch, max(rtol, 1e-13))
        else:
            areas[k] = _integral(body, k, patch.bounds().mean(axis=0), (AREA, rtol))
    return areas


def patch_volumes(body: Faces, origin: FloatArray, rtol: float = 1e-9) -> FloatArray:
    """(m,) signed volume of the cone from `origin` over every patch, trims obeyed."""
    return np.array(
        [_integral(body, k, origin, (VOLUME, rtol)) / 3.0 for k in range(len(body.patches))]
    )


def _integral(body: Faces, k: int, origin: FloatArray, task: tuple[int, float]) -> float:
    """The area or flux integral over patch `k`, halving parts until two rules agree."""
    kind, rtol = task
    patch = body.patches[k]
    grid = tuple(extract(patch.translated(-origin)))
    groups = _loops_of(body.trim_tables, k) if body.trims[k] is not None else None

    def value(points: int, parts: int) -> float:
        rule = (*gauss(points), parts, kind)
        if groups is None:
            return float(rectangle_integral(grid, rule))
        tables = body.trim_tables
        return float(sum(loop_integral(tables, group, grid, rule) for group in groups))

    low, high = patch.bounds()
    floor = rtol * float(np.linalg.norm(high - low)) ** 3 if kind == VOLUME else 0.0
    points = max(patch.degrees) + _FEW
    parts = 1
    while True:
        # Two rules on the same parts cost half of what one rule on halved parts does.
        coarse, fine = value(points, parts), value(points + _MORE, parts)
        if abs(fine - coarse) <= max(10.0 * rtol * abs(fine), floor) or parts >= MOST_PARTS:
            return fine
        parts *= 2


def _loops_of(tables: TrimTables, k: int) -> list[np.ndarray]:
    """The pieces of each loop of patch `k`, in order."""
    first, last = tables.patch_start[k], tables.patch_start[k + 1]
    pieces = np.arange(first, last)
    loops = tables.piece_loop[first:last, 0]
    return [pieces[loops == number] for number in np.unique(loops)]
