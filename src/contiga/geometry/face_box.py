"""Exact bounding box of faces, trims obeyed.

In each of the six directions the faces are searched in the order of their Bézier points' reach.
Within a face elements are halved, and parts whose Bézier points lie below a point of the surface
are dropped (as in Farouki & Rajan, Algorithms for polynomials in Bernstein form, 1988); the Bézier
points converge to the surface with the square of a part's size. The highest point of a trimmed
face is a critical point inside or a point of a trimming curve; the curves are sampled, and refined
around their tops.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import OUT
from contiga.arrays.layout import as_contiguous
from contiga.geometry.bezier import extract
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.kernels.trim_nb import box_states, points_in_trim
from contiga.geometry.slopes import numerator
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import Loop, TrimTables, build_trim_tables, parameter_box
from contiga.records import FloatArray

_BOX_TOL = 1e-14
"""Share of the size up to which a face is searched."""
_MAX_LEVELS = 80
_MAX_PARTS = 20_000
"""Largest number of parts of a face. Beyond it the face has no distinct top, such as a ridge that
follows no parameter line, and the box is the one of the Bézier points of these parts."""
_N_SAMPLES = 32
"""Samples of each span of a trimming curve."""
_N_REFINED = 9
_MAX_ROUNDS = 14
"""Rounds of nine samples in a quarter of the interval: they find a top to 1e-8 of the first one,
and its height to the square of that."""


class _Parts(NamedTuple):
    """Parts of the elements of a face, and how far they reach in one direction."""

    coefs: FloatArray
    """(m, p + 1, q + 1, 2) homogeneous Bernstein coefficients (w h, w) of the height h."""
    box: FloatArray
    """(m, 4) u0, u1, v0, v1 of each."""

    def heights(self) -> FloatArray:
        """Return (m, p + 1, q + 1) heights of the Bézier points."""
        return np.asarray(self.coefs[..., 0] / self.coefs[..., 1])

    def of(self, rows: NDArray[np.bool_]) -> _Parts:
        """Return the parts that the mask `rows` (m,) selects."""
        return _Parts(self.coefs[rows], self.box[rows])


class _Face:
    """A patch and its trims, with the points that bound it.

    Parameters
    ----------
    patch, loops : the patch, and its loops of p-curves or None
    tables : returns trim tables, the patch being number `number` there
    """

    def __init__(
        self,
        patch: NurbsSurface,
        loops: tuple[Loop, ...] | None,
        tables: Callable[[], TrimTables],
        number: int,
    ) -> None:
        self.patch = patch
        self.loops = loops
        self.tables = tables
        self.number = number
        (u0, v0), (u1, v1) = (corner.tolist() for corner in parameter_box(patch, loops))
        if loops is not None and u0 < u1 and v0 < v1:
            patch = patch.restricted((u0, u1), (v0, v1))
        grid = extract(patch)
        self.coefs = grid.coefs.reshape(-1, *grid.coefs.shape[2:])
        self.box = grid.boxes()
        points = (self.coefs[..., :3] / self.coefs[..., 3:]).reshape(-1, 3)
        self.hull = np.array([points.min(axis=0), points.max(axis=0)])
        """(2, 3) box of the Bézier points."""

    def sample(self) -> FloatArray:
        """Return (n, 3) points of the face: corners of its elements, or starts of its p-curves."""
        if self.loops is None:
            corners = self.coefs[:, [0, 0, -1, -1], [0, -1, 0, -1]].reshape(-1, 4)
            return np.asarray(corners[:, :3] / corners[:, 3:])
        curves = [curve for loop in self.loops for curve in loop]
        return self.at(np.array([curve.control_points[0, :2] for curve in curves]))

    def at(self, uv: FloatArray) -> FloatArray:
        """Return (n, 3) points at parameters (n, 2), clipped to the patch's rectangle."""
        low, high = np.array(self.patch.domain).T
        return self.patch.evaluate(np.clip(uv, low, high))

    def top(self, axis: int, sign: float, best: float, tol: float) -> float:
        """Return the larger of `best` and the face's largest height `sign` · x_axis, to `tol`.

        If more than `_MAX_PARTS` parts remain, it is the largest height of their Bézier points.
        """
        for curve in (curve for loop in self.loops or () for curve in loop):
            best = self._curve_top(curve, axis, sign, best)
        parts = _Parts(self.coefs[..., [axis, 3]] * [sign, 1.0], self.box)
        for _ in range(_MAX_LEVELS):
            heights = parts.heights()
            reach = heights.max(axis=(1, 2), initial=-np.inf)
            corners = heights[:, [0, 0, -1, -1], [0, -1, 0, -1]]
            if self.loops is not None:  # only corners on the face count
                part, corner = np.nonzero(corners > best)
                box, rows = parts.box[part], np.arange(len(part))
                uv = np.stack([box[rows, corner // 2], box[rows, 2 + corner % 2]], axis=1)
                uv = as_contiguous(uv, np.float64)
                corners = corners[part, corner][points_in_trim(self.tables(), self.number, uv)]
            best = max(best, float(corners.max(initial=-np.inf)))
            parts = parts.of(reach > best + tol)
            if self.loops is not None and len(parts.box):
                parts = self._with_critical_point(parts)
            if not len(parts.box):
                return best
            if len(parts.box) > _MAX_PARTS:
                break
            parts = _halved(parts)
        return max(best, float(parts.heights().max()))

    def _with_critical_point(self, parts: _Parts) -> _Parts:
        """Return the parts of a trimmed face that may have a critical point, and are not outside.

        A part has none if the Bernstein coefficients of a first derivative are of one sign.
        """
        A, w = parts.coefs[None, ..., :1], parts.coefs[None, ..., 1:]
        may_be_flat = np.ones(len(parts.box), dtype=bool)
        for axis in (2, 3):
            slope = numerator(A, w, axis)[0].reshape(len(may_be_flat), -1)
            may_be_flat &= (slope.min(axis=1) <= 0.0) & (slope.max(axis=1) >= 0.0)
        parts = parts.of(may_be_flat)
        patch = np.full(len(parts.box), self.number, np.int32)
        box = as_contiguous(parts.box, np.float64)
        return parts.of(box_states(self.tables(), patch, box) != OUT)

    def _curve_top(self, curve: NurbsCurve, axis: int, sign: float, best: float) -> float:
        """Return the larger of `best` and the largest height of a trimming curve.

        Spans between samples that may exceed `best`, by their second differences, are sampled
        finer.
        """
        breaks = np.unique(curve.knots)
        shares = np.arange(_N_SAMPLES) / _N_SAMPLES
        t = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel(), breaks[-1])
        heights = sign * self.at(curve.evaluate(t)[:, :2])[:, axis]
        best = max(best, float(heights.max()))
        # A top between samples exceeds them by less than their second differences.
        bend = np.abs(np.diff(np.pad(heights, 1, mode="reflect"), 2))
        bound = np.maximum(heights[:-1], heights[1:]) + bend[:-1] + bend[1:]
        low, high = t[:-1][bound > best], t[1:][bound > best]
        for _ in range(_MAX_ROUNDS if len(low) else 0):
            finer = np.linspace(low, high, _N_REFINED, axis=1)
            uv = curve.evaluate(finer.ravel())[:, :2]
            heights = sign * self.at(uv)[:, axis].reshape(finer.shape)
            rows, highest = np.arange(len(low)), heights.argmax(axis=1)
            best = max(best, float(heights.max()))
            low = finer[rows, np.maximum(highest - 1, 0)]
            high = finer[rows, np.minimum(highest + 1, _N_REFINED - 1)]
        return best


def bounds_of(
    patches: Sequence[NurbsSurface],
    trims: Sequence[tuple[Loop, ...] | None],
    tables: Callable[[], TrimTables] | None = None,
) -> FloatArray:
    """Return (2, 3) lower and upper corner of the box of faces, to about 1e-14 of its size.

    A face without a distinct top, such as an oblique ridge, may make it a little larger.

    Parameters
    ----------
    patches : of the faces
    trims : for each face None, or its loops of p-curves
    tables : returns their trim tables; built if omitted
    """
    tables = tables or cache(lambda: build_trim_tables(patches, trims))
    faces = [
        _Face(patch, loops, tables, k)
        for k, (patch, loops) in enumerate(zip(patches, trims, strict=True))
    ]
    samples = np.concatenate([face.sample() for face in faces])
    hulls = np.array([face.hull for face in faces])
    box = np.array([samples.min(axis=0), samples.max(axis=0)])
    tol = _BOX_TOL * float(np.linalg.norm(np.ptp(hulls.reshape(-1, 3), axis=0)))
    tol = max(tol, 8.0 * float(np.spacing(np.abs(hulls).max())))
    for side, sign in ((0, -1.0), (1, 1.0)):
        for axis in range(3):
            reach = sign * hulls[:, side, axis]
            best = sign * float(box[side, axis])
            for k in np.argsort(-reach, kind="stable"):
                if reach[k] <= best + tol:
                    break
                best = faces[k].top(axis, sign, best, tol)
            box[side, axis] = sign * best
    return box


def _halved(parts: _Parts) -> _Parts:
    """Return all parts halved, each in the direction in which its Bézier points vary more."""
    heights = parts.heights()
    range_u = np.abs(np.diff(heights, axis=1)).max(axis=(1, 2), initial=0.0)
    range_v = np.abs(np.diff(heights, axis=2)).max(axis=(1, 2), initial=0.0)
    in_u = range_u >= range_v
    halves = [_split(parts.of(in_u), 1), _split(parts.of(~in_u), 2)]
    return _Parts(
        np.concatenate([half.coefs for half in halves]), np.concatenate([h.box for h in halves])
    )


def _split(parts: _Parts, axis: int) -> _Parts:
    """Return parts halved along u (`axis` 1) or v (2), by de Casteljau: all first halves first."""
    row = np.moveaxis(parts.coefs, axis, 0)
    left, right = [row[0]], [row[-1]]
    for _ in range(len(row) - 1):
        row = 0.5 * (row[:-1] + row[1:])
        left.append(row[0])
        right.append(row[-1])
    coefs = [np.moveaxis(np.stack(half), 0, axis) for half in (left, right[::-1])]
    first, last = 2 * axis - 2, 2 * axis - 1
    low, high = parts.box.copy(), parts.box.copy()
    low[:, last] = high[:, first] = 0.5 * (parts.box[:, first] + parts.box[:, last])
    return _Parts(np.concatenate(coefs), np.concatenate([low, high]))
