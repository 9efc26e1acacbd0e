"""The control points of a body in one array, those that patches have in common once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np

from contiga.arrays.groups import groups_of
from contiga.arrays.layout import as_points, locked, read_only
from contiga.arrays.near_pairs import near_pairs
from contiga.arrays.once import once
from contiga.arrays.threads import run_ranges
from contiga.errors import InputError
from contiga.geometry.faces import Faces
from contiga.geometry.kernels import net_nb
from contiga.geometry.kernels.net_nb import Influence, NetPatch
from contiga.jit import straight
from contiga.records import FloatArray, IndexArray, IntArray, SurfacePlaces

SAME = 1e-7
"""Control points on borders of patches that are closer than this share of the body's size are
one."""
Rows: TypeAlias = IndexArray | slice
NO_ROWS = np.zeros(0, np.int64)
POINTS = 1024
"""Number of points below which a second thread does not pay."""


class ControlNet(NamedTuple):
    """The places of the patches' control points in one array (m, 3).

    They are numbered patch after patch, along v first. A control point on the border of a patch
    that lies where an earlier one on a border does, of another patch, of a seam or of a pole, is
    that one.
    """

    points: FloatArray
    """(m, 3) where they are at rest, body axes; read-only."""
    control: tuple[IntArray, ...]
    """For each patch the row (n, m) of each of its control points; read-only."""

    def checked(self, control_points: object, where: str = "control_points") -> FloatArray:
        """Control points as an array of floats of this net's shape.

        Raises
        ------
        InputError
            Another shape, or numbers that are not finite.
        """
        points = as_points(control_points, where)  # type: ignore[arg-type]  # checked there
        if len(points) != len(self.points):
            raise InputError(
                "must have one row a control point of the body",
                where=where,
                found=points.shape,
                allowed=f"{self.points.shape}, in the order of body.net.points",
                remedy="Control points that patches share are one row: body.net.control[k] has "
                "the rows of patch k",
            )
        finite = np.isfinite(points).all(axis=1)
        if not finite.all():
            row = int(np.argmin(finite))
            raise InputError(
                "control points must be finite",
                where=f"{where}[{row}]",
                found=points[row].tolist(),
            )
        return points


@once
def net_of(body: Faces) -> ControlNet:
    """The control points of `body`, worked out at the first call."""
    nets = [patch.control_points for patch in body.patches]
    every = np.concatenate([net.reshape(-1, 3) for net in nets])
    on_border = np.concatenate([_border(*net.shape[:2]) for net in nets])
    rows = np.flatnonzero(on_border)
    pairs = near_pairs(every[rows], SAME * body.size)
    group = groups_of(rows[pairs[:, 0]], rows[pairs[:, 1]], len(every))
    _, first = np.unique(group, return_index=True)
    ends = np.cumsum([net[..., 0].size for net in nets])[:-1]
    group.flags.writeable = False
    control = tuple(
        part.reshape(net.shape[:2]) for part, net in zip(np.split(group, ends), nets, strict=True)
    )
    return ControlNet(read_only(every[first]), control)


def _border(n: int, m: int) -> np.ndarray:
    """Return which control points of a patch are on its border (n · m,)."""
    border = np.ones((n, m), bool)
    border[1:-1, 1:-1] = False
    return border.ravel()


@once
def _patches_of(body: Faces) -> tuple[NetPatch, ...]:
    control = net_of(body).control
    return tuple(
        NetPatch(patch.arrays, rows) for patch, rows in zip(body.patches, control, strict=True)
    )


class NetMotion(NamedTuple):
    """The motion of a body's control points from a shape."""

    body: Faces
    shape: FloatArray
    """(m, 3) control points, body axes."""
    change: FloatArray
    """(m, 3)."""

    def carry(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return the motion (k, 3) of points (k, 3) that the surface carries along at their feet.

        See `net_nb`.
        """
        out, net = np.zeros((len(points), 3)), (locked(self.shape), locked(self.change))
        for patch, rows in _on_patches(self.body, feet):
            moved = np.empty((len(points[rows]), 3))
            given = patch, *net, *_rows_of(rows, feet.uv, points), moved
            run_ranges(straight(net_nb.carry), len(moved), POINTS, *given)
            out[rows] = moved
        return out


def _on_patches(body: Faces, feet: SurfacePlaces) -> Iterator[tuple[NetPatch, Rows]]:
    """Yield each patch that has any of the feet, with the rows of these feet."""
    patches = _patches_of(body)
    if len(patches) == 1 and (feet.patch == 0).all():  # a slice copies nothing
        yield patches[0], slice(None)
        return
    for k, patch in enumerate(patches):
        rows = np.flatnonzero(feet.patch == k)
        if len(rows):
            yield patch, rows


def _rows_of(rows: Rows, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Return some rows of arrays, C-ordered for kernels."""
    return tuple(np.ascontiguousarray(array[rows]) for array in arrays)


def spread(
    body: Faces, shape: FloatArray, feet: SurfacePlaces, points: FloatArray, forces: FloatArray
) -> FloatArray:
    """Return the forces (m, 3) on control points equivalent to `forces` (k, 3) at `points` (k, 3).

    The points are carried along with their feet; work, sum and moment are the same. See `net_nb`.
    """
    out = np.zeros(shape.shape)
    for patch, rows in _on_patches(body, feet):
        given = patch, locked(shape), *_rows_of(rows, feet.uv, points, forces)
        straight(net_nb.spread)(*given, out)
    return out


class Dependence(NamedTuple):
    """Dependence of k places on the control points of a body, as e entries of sparse matrices."""

    place: IndexArray
    """(e,) row of the place."""
    control: IndexArray
    """(e,) row of the control point."""
    value: FloatArray
    """(e,) basis function of the control point at the place."""
    gradient: FloatArray
    """(e, 3) its gradient along the surface, one over length, body axes."""


def dependence_of(body: Faces, shape: FloatArray, feet: SurfacePlaces) -> Dependence:
    """Return the dependence of places `feet` (k,) on the control points `shape` (m, 3)."""
    parts = [Dependence(NO_ROWS, NO_ROWS, np.zeros(0), np.zeros((0, 3)))]
    every = np.arange(len(feet.patch))
    for patch, rows in _on_patches(body, feet):
        (uv,) = _rows_of(rows, feet.uv)
        k, c = len(uv), (patch.surface.p + 1) * (patch.surface.q + 1)
        found = Influence(np.empty((k, c), np.int32), np.empty((k, c)), np.empty((k, c, 3)))
        run_ranges(straight(net_nb.influence), k, POINTS, patch, locked(shape), uv, found)
        place = np.repeat(every[rows], c)
        flat = found.control.ravel(), found.value.ravel(), found.gradient.reshape(-1, 3)
        parts.append(Dependence(place, *flat))
    return Dependence(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
