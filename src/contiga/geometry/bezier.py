"""Bézier extraction: a spline as one Bernstein polynomial for each element."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.geometry import refine
from contiga.geometry.spline_like import CurveLike, SurfaceLike
from contiga.records import FloatArray, IndexArray


class BezierGrid(NamedTuple):
    """The elements of a surface."""

    coefs: FloatArray
    """(nu, nv, p + 1, q + 1, 4) homogeneous Bernstein coefficients (wx, wy, wz, w)."""
    u_breaks: FloatArray
    """(nu + 1,) borders of the elements in u."""
    v_breaks: FloatArray
    """(nv + 1,) borders of the elements in v."""

    def boxes(self) -> FloatArray:
        """Return (nu · nv, 4) u0, u1, v0, v1 of each element."""
        u, v = self.u_breaks, self.v_breaks
        boxes = np.empty((len(u) - 1, len(v) - 1, 4))
        boxes[..., 0], boxes[..., 1] = u[:-1, None], u[1:, None]
        boxes[..., 2], boxes[..., 3] = v[:-1], v[1:]
        return boxes.reshape(-1, 4)


class BezierCurve(NamedTuple):
    """The elements of a curve."""

    coefs: FloatArray
    """(ns, p + 1, 4) homogeneous Bernstein coefficients (wx, wy, wz, w)."""
    breaks: FloatArray
    """(ns + 1,) borders of the elements."""


class Extraction(NamedTuple):
    """The map from the control points of a surface to the coefficients of its elements."""

    rows: tuple[refine.Rows, refine.Rows]
    """Rows of the maps in u and in v."""
    windows: tuple[IndexArray, IndexArray]
    """(nu, p + 1) and (nv, q + 1) mapped control points of each element; neighbours share one."""
    breaks: tuple[FloatArray, FloatArray]
    """(nu + 1,) and (nv + 1,) borders of the elements."""

    def of(self, homogeneous: FloatArray) -> BezierGrid:
        """Return the elements of the control points (n, m, 4)."""
        points = homogeneous
        for axis, rows in enumerate(self.rows):
            points = refine.mapped(rows, points, axis)
        i, j = self.windows
        coefs = points[i[:, None, :, None], j[None, :, None, :]]
        return BezierGrid(np.ascontiguousarray(coefs), *self.breaks)


def extract(
    surface: SurfaceLike, u: FloatArray | None = None, v: FloatArray | None = None
) -> BezierGrid:
    """Return Bernstein coefficients of every element (knot span) of `surface`.

    Every interior knot is raised to the multiplicity of the degree by knot insertion (The NURBS
    Book, 5.3), which does not change the shape.

    Parameters
    ----------
    surface : the patch
    u, v : further borders at which to cut elements, strictly inside the domain
    """
    return extraction_of(surface, u, v).of(surface.homogeneous)


def extraction_of(
    surface: SurfaceLike, u: FloatArray | None = None, v: FloatArray | None = None
) -> Extraction:
    """Return the map of `surface`, which depends on its degrees and knots alone; see `extract`."""
    counts = surface.homogeneous.shape
    rows, windows, breaks = [], [], []
    for axis, extra in enumerate((u, v)):
        knots, degree = surface.knots[axis], surface.degrees[axis]
        refined, borders = _cut(knots, degree, extra)
        rows.append(refine.rows_to(knots, degree, counts[axis], refined))
        windows.append(_windows(len(borders) - 1, degree))
        breaks.append(borders)
    return Extraction((rows[0], rows[1]), (windows[0], windows[1]), (breaks[0], breaks[1]))


def extract_curve(curve: CurveLike) -> BezierCurve:
    """Return Bernstein coefficients of every element (knot span) of `curve`."""
    knots, borders = _cut(curve.knots, curve.degree, None)
    points = refine.refine_points(curve.knots, curve.degree, curve.homogeneous, knots)
    coefs = points[_windows(len(borders) - 1, curve.degree)]
    return BezierCurve(np.ascontiguousarray(coefs), borders)


def _cut(knots: FloatArray, degree: int, extra: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Return knots with every border `degree` times (once more at the ends), and the borders."""
    borders = np.unique(knots if extra is None else np.concatenate([knots, extra]))
    times = np.full(borders.size, degree)
    times[[0, -1]] += 1
    return np.repeat(borders, times), borders


def _windows(elements: int, degree: int) -> IndexArray:
    """Return (elements, degree + 1) indices of the points of each element; neighbours share one."""
    starts = np.arange(elements, dtype=np.int64) * degree
    return starts[:, None] + np.arange(degree + 1, dtype=np.int64)
