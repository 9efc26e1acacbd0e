"""The box of faces: how far they reach along x, y and z, trims obeyed.

Along each of the six directions the faces whose Bézier points reach farthest are looked at. Within
a face elements are halved, and parts whose Bézier points lie below a point that is known are left
out (as in Farouki & Rajan, Algorithms for polynomials in Bernstein form, 1988); the points close in
on the surface with the square of a part's size. Of a trimmed face the highest point is a critical
one inside, or one of a trimming curve, which are sampled and looked at closer about their tops.
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

_CLOSE = 1e-14
"""Share of the size to which a face is followed."""
_LEVELS = 80
_MAX_PARTS = 20_000
"""Parts of a face that are kept at once: beyond that it has no top that stands out, such as a
ridge that is no line of parameters, and the box is that of the Bézier points of these parts."""
_SAMPLES = 32
"""Of each span of a trimming curve."""
_NEARER = 9
_ROUNDS = 14
"""Nine points in a fourth of the way, so many times: to 1e-8 of it, and of a top its square."""


class _Parts(NamedTuple):
    """Parts of the elements of a face, and how far they reach in one direction."""

    coefs: FloatArray
    """(m, p + 1, q + 1, 2) homogeneous Bernstein coefficients (w h, w) of the height h."""
    box: FloatArray
    """(m, 4) u0, u1, v0, v1 of each."""

    def heights(self) -> FloatArray:
        """Return (m, p + 1, q + 1) of the Bézier points."""
        return np.asarray(self.coefs[..., 0] / self.coefs[..., 1])

    def of(self, rows: NDArray[np.bool_]) -> _Parts:
        """Return some of the parts."""
        return _Parts(self.coefs[rows], self.box[rows])


class _Inside(NamedTuple):
    """Tables that tell inside from outside of a patch."""

    tables: Callable[[], TrimTables]
    patch: int
    """Its number in the tables."""


class _Face:
    """A patch and what its loops leave of it."""

    def __init__(
        self, patch: NurbsSurface, loops: tuple[Loop, ...] | None, inside: _Inside
    ) -> None:
        self.patch = patch
        self.loops = loops
        self.inside = inside
        grid = extract(_within_reach(patch, loops))
        self.coefs = grid.coefs.reshape(-1, *grid.coefs.shape[2:])
        self.box = grid.boxes()
        points = (self.coefs[..., :3] / self.coefs[..., 3:]).reshape(-1, 3)
        self.hull = np.array([points.min(axis=0), points.max(axis=0)])
        """(2, 3) box of the Bézier points."""

    def known(self) -> FloatArray:
        """Return (n, 3) some points of the face: corners of its elements, or of its loops."""
        if self.loops is None:
            corners = self.coefs[:, [0, 0, -1, -1], [0, -1, 0, -1]].reshape(-1, 4)
            return np.asarray(corners[:, :3] / corners[:, 3:])
        curves = [curve for loop in self.loops for curve in loop]
        return self.at(np.array([curve.control_points[0, :2] for curve in curves]))

    def at(self, uv: FloatArray) -> FloatArray:
        """Return (n, 3) points at parameters (n, 2), which are moved into the patch's rectangle."""
        low, high = np.array(self.patch.domain).T
        return self.patch.evaluate(np.clip(uv, low, high))

    def top(self, axis: int, sign: float, known: float, close: float) -> float:
        """Return how far the face reaches beyond `known` along an axis times `sign`.

        What is less than `close` beyond it is left out.
        """
        for curve in (curve for loop in self.loops or () for curve in loop):
            known = self._top_of_curve(curve, axis, sign, known)
        parts = _Parts(self.coefs[..., [axis, 3]] * [sign, 1.0], self.box)
        for _ in range(_LEVELS):
            heights = parts.heights()
            reach = heights.max(axis=(1, 2), initial=-np.inf)
            known = max(known, self._highest_corner(parts, heights, known))
            high = reach > known + close
            parts = self._with_a_top(parts.of(high))
            if not len(parts.box):
                return known
            if len(parts.box) > _MAX_PARTS:
                break
            parts = _halved(parts)
        return max(known, float(parts.heights().max()))

    def _highest_corner(self, parts: _Parts, heights: FloatArray, known: float) -> float:
        """The highest corner of parts that is on the face."""
        corners = heights[:, [0, 0, -1, -1], [0, -1, 0, -1]]
        if self.loops is not None:
            part, corner = np.nonzero(corners > known)
            box = parts.box[part]
            rows = np.arange(len(box))
            uv = np.stack([box[rows, corner // 2], box[rows, 2 + corner % 2]], axis=1)
            tables, patch = self.inside.tables(), self.inside.patch
            inside = points_in_trim(tables, patch, as_contiguous(uv, np.float64))
            corners = corners[part, corner][inside]
        return float(corners.max(initial=-np.inf))

    def _with_a_top(self, parts: _Parts) -> _Parts:
        """Return the parts of a trimmed face that are not outside and may have a critical point."""
        if self.loops is None or not len(parts.box):
            return parts
        A, w = parts.coefs[None, ..., :1], parts.coefs[None, ..., 1:]
        flat = np.ones(len(parts.box), dtype=bool)
        for way in (2, 3):
            slope = numerator(A, w, way)[0].reshape(len(flat), -1)
            flat &= (slope.min(axis=1) <= 0.0) & (slope.max(axis=1) >= 0.0)
        parts = parts.of(flat)
        patch = np.full(len(parts.box), self.inside.patch, np.int32)
        box = as_contiguous(parts.box, np.float64)
        return parts.of(box_states(self.inside.tables(), patch, box) != OUT)

    def _top_of_curve(self, curve: NurbsCurve, axis: int, sign: float, known: float) -> float:
        """The highest point of a trimming curve."""
        breaks = np.unique(curve.knots)
        shares = np.arange(_SAMPLES) / _SAMPLES
        t = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel(), breaks[-1])
        heights = sign * self.at(curve.evaluate(t)[:, :2])[:, axis]
        known = max(known, float(heights.max()))
        # A top between samples is higher than they are by less than these bend.
        bend = np.abs(np.diff(np.pad(heights, 1, mode="reflect"), 2))
        around = np.maximum(heights[:-1], heights[1:]) + bend[:-1] + bend[1:]
        low, high = t[:-1][around > known], t[1:][around > known]
        for _ in range(_ROUNDS if len(low) else 0):
            nearer = np.linspace(low, high, _NEARER, axis=1)
            uv = curve.evaluate(nearer.ravel())[:, :2]
            heights = sign * self.at(uv)[:, axis].reshape(nearer.shape)
            rows, best = np.arange(len(low)), heights.argmax(axis=1)
            known = max(known, float(heights.max()))
            low = nearer[rows, np.maximum(best - 1, 0)]
            high = nearer[rows, np.minimum(best + 1, _NEARER - 1)]
        return known


def bounds_of(
    patches: Sequence[NurbsSurface],
    trims: Sequence[tuple[Loop, ...] | None],
    tables: Callable[[], TrimTables] | None = None,
) -> FloatArray:
    """Return (2, 3) low and high corner of the box of faces, to about 1e-14 of its size.

    Parameters
    ----------
    patches : of the faces
    trims : for each None, or its loops of p-curves
    tables : answers their trim tables where these are known
    """
    tables = tables or cache(lambda: build_trim_tables(patches, trims))
    faces = [
        _Face(patch, loops, _Inside(tables, k))
        for k, (patch, loops) in enumerate(zip(patches, trims, strict=True))
    ]
    known = np.concatenate([face.known() for face in faces])
    hulls = np.array([face.hull for face in faces])
    box = np.array([known.min(axis=0), known.max(axis=0)])
    close = _CLOSE * float(np.linalg.norm(np.ptp(hulls.reshape(-1, 3), axis=0)))
    close = max(close, 8.0 * float(np.spacing(np.abs(hulls).max())))
    for side, sign in ((0, -1.0), (1, 1.0)):
        for axis in range(3):
            reach = sign * hulls[:, side, axis]
            best = sign * float(box[side, axis])
            for k in np.argsort(-reach, kind="stable"):
                if reach[k] <= best + close:
                    break
                best = faces[k].top(axis, sign, best, close)
            box[side, axis] = sign * best
    return box


def _within_reach(patch: NurbsSurface, loops: tuple[Loop, ...] | None) -> NurbsSurface:
    """The part of a patch that its loops reach."""
    (u0, v0), (u1, v1) = (corner.tolist() for corner in parameter_box(patch, loops))
    if loops is None or not (u0 < u1 and v0 < v1):
        return patch
    return patch.restricted((u0, u1), (v0, v1))


def _halved(parts: _Parts) -> _Parts:
    """All parts cut in two, each where its Bézier points vary more."""
    heights = parts.heights()
    along_u = np.abs(np.diff(heights, axis=1)).max(axis=(1, 2), initial=0.0)
    along_v = np.abs(np.diff(heights, axis=2)).max(axis=(1, 2), initial=0.0)
    by_u = along_u >= along_v
    halves = [_cut(parts.of(by_u), 1), _cut(parts.of(~by_u), 2)]
    return _Parts(
        np.concatenate([half.coefs for half in halves]), np.concatenate([h.box for h in halves])
    )


def _cut(parts: _Parts, axis: int) -> _Parts:
    """Parts cut in the middle along u (`axis` 1) or v (2), by de Casteljau's algorithm."""
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
