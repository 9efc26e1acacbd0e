"""The control points of a body in one array, with one row where patches share one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

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

MERGE_TOL = 1e-7
"""Control points on borders of patches closer than this share of the body's size are one."""
Rows: TypeAlias = IndexArray | slice
NO_ROWS = np.zeros(0, np.int64)
MIN_POINTS = 1024
"""Number of points above which a second thread pays."""


class ControlNet(NamedTuple):
    """The control points of all patches in one array (m, 3).

    They are numbered patch after patch, along v first. A control point on the border of a patch
    that coincides with an earlier one on a border (of another patch, a seam or a pole) is the same
    row.
    """

    points: FloatArray
    """(m, 3) at rest, body axes; read-only."""
    control: tuple[IntArray, ...]
    """For each patch the row (n, m) of each of its control points; read-only."""

    def checked(self, control_points: object, where: str = "control_points") -> FloatArray:
        """Return `control_points` as an array (m, 3) of floats, without a copy if it is one.

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
    """Return the control points of `body`, computed at the first call.

    Border points within `MERGE_TOL` of the body's size of each other are one row, also over others
    between; it has the place of the first of them.
    """
    nets = [patch.control_points for patch in body.patches]
    points = np.concatenate([net.reshape(-1, 3) for net in nets])
    masks = [np.ones(net.shape[:2], bool) for net in nets]
    for is_border in masks:
        is_border[1:-1, 1:-1] = False
    rows = np.flatnonzero(np.concatenate([is_border.ravel() for is_border in masks]))
    pairs = near_pairs(points[rows], MERGE_TOL * body.size)
    group = groups_of(rows[pairs[:, 0]], rows[pairs[:, 1]], len(points))
    _, first = np.unique(group, return_index=True)
    ends = np.cumsum([net[..., 0].size for net in nets])[:-1]
    group.flags.writeable = False
    control = tuple(
        part.reshape(net.shape[:2]) for part, net in zip(np.split(group, ends), nets, strict=True)
    )
    return ControlNet(read_only(points[first]), control)


@once
def _patches_of(body: Faces) -> tuple[NetPatch, ...]:
    """Return the patches with the rows of their control points, for kernels."""
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

        It is zero for rows without a foot (patch −1), and of first order in `change`: see `net_nb`.
        """
        out, net = np.zeros((len(points), 3)), (locked(self.shape), locked(self.change))
        for patch, rows in _on_patches(self.body, feet):
            moved = np.empty((len(points[rows]), 3))
            arguments = patch, *net, *_rows_of(rows, feet.uv, points), moved
            run_ranges(straight(net_nb.carry), len(moved), MIN_POINTS, *arguments)
            out[rows] = moved
        return out


def _on_patches(body: Faces, feet: SurfacePlaces) -> Iterator[tuple[NetPatch, Rows]]:
    """Yield each patch that has any of the feet, ascending, with the rows of these feet."""
    patches = _patches_of(body)
    if len(patches) == 1 and (feet.patch == 0).all():  # a slice copies nothing
        yield patches[0], slice(None)
        return
    for k, patch in enumerate(patches):
        rows = np.flatnonzero(feet.patch == k)
        if len(rows):
            yield patch, rows


def _rows_of(rows: Rows, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Return some rows of each array, C-ordered for kernels; copies unless `rows` is a slice."""
    return tuple(np.ascontiguousarray(array[rows]) for array in arrays)


def spread(
    body: Faces, shape: FloatArray, feet: SurfacePlaces, points: FloatArray, forces: FloatArray
) -> FloatArray:
    """Return the forces (m, 3) on control points equivalent to `forces` (k, 3) at `points` (k, 3).

    The points are carried along with their feet; work, sum and moment are the same. Rows without a
    foot (patch −1) are left out. See `net_nb`.
    """
    out = np.zeros(shape.shape)
    for patch, rows in _on_patches(body, feet):
        arguments = patch, locked(shape), *_rows_of(rows, feet.uv, points, forces)
        straight(net_nb.spread)(*arguments, out)
    return out


class Jet(NamedTuple):
    """A vector field on a surface at k places, with its covariant derivatives there."""

    value: FloatArray
    """(k, 3)."""
    gradient: FloatArray
    """(k, 3, 3): components of the field by row, directions along the surface by column."""
    hessian: FloatArray
    """(k, 3, 3, 3): components first."""


class OnPatch(NamedTuple):
    """Places on one patch."""

    rows: Rows
    """Rows of the places among all."""
    influence: Influence


class Entries(NamedTuple):
    """Dependence of places on control points as e entries of sparse matrices, by place."""

    place: IndexArray
    """(e,) row of the place, ascending."""
    control: IndexArray
    """(e,) row of the control point."""
    value: FloatArray
    """(e,) basis function of the control point at the place."""
    gradient: FloatArray
    """(e, 3) its gradient along the surface, one over length, body axes."""
    hessian: FloatArray
    """(e, 3, 3) its second covariant derivative along the surface, one over length squared."""


class Dependence(NamedTuple):
    """Dependence of k places on the control points of a body."""

    patches: list[OnPatch]
    normal: FloatArray
    """(k, 3) unit normals of the surface at the places; zero where it has none."""

    def jet(self, vectors: FloatArray) -> Jet:
        """Return the field Σ N_i `vectors`_i and its derivatives at the places, as a `Jet`.

        `vectors` (m, 3) belong to the control points; rows without a foot are zero.
        """
        k = len(self.normal)
        jet = Jet(np.zeros((k, 3)), np.zeros((k, 3, 3)), np.zeros((k, 3, 3, 3)))
        for rows, influence in self.patches:
            values = vectors[influence.control]
            jet.value[rows] = np.einsum("kca,kc->ka", values, influence.value, optimize=False)
            jet.gradient[rows] = np.einsum(
                "kca,kcb->kab", values, influence.gradient, optimize=False
            )
            jet.hessian[rows] = np.einsum(
                "kca,kcbd->kabd", values, influence.hessian, optimize=False
            )
        return jet

    @property
    def entries(self) -> Entries:
        """The entries of all places, sorted by place."""
        places = np.arange(len(self.normal))
        blocks: list[tuple[NDArray[Any], ...]]
        blocks = [(NO_ROWS, NO_ROWS, np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3, 3)))]
        for rows, influence in self.patches:
            k, c = influence.control.shape
            flat = (array.reshape(k * c, *array.shape[2:]) for array in influence[:4])
            blocks.append((np.repeat(places[rows], c), *flat))
        columns = [np.concatenate(arrays) for arrays in zip(*blocks, strict=True)]
        order = np.argsort(columns[0], kind="stable")
        return Entries(*(column[order] for column in columns))


def dependence_of(body: Faces, shape: FloatArray, feet: SurfacePlaces) -> Dependence:
    """Return the dependence of places `feet` (k,) on the control points `shape` (m, 3).

    Places of patch −1 depend on none.
    """
    patches, normal = [], np.zeros((len(feet.patch), 3))
    for patch, rows in _on_patches(body, feet):
        (uv,) = _rows_of(rows, feet.uv)
        k, c = len(uv), (patch.surface.p + 1) * (patch.surface.q + 1)
        per_control = np.empty((k, c)), np.empty((k, c, 3)), np.empty((k, c, 3, 3))
        influence = Influence(np.empty((k, c), np.int32), *per_control, np.empty((k, 3)))
        run_ranges(straight(net_nb.influence), k, MIN_POINTS, patch, locked(shape), uv, influence)
        normal[rows] = influence.normal
        patches.append(OnPatch(rows, influence))
    return Dependence(patches, normal)
