"""Patches that share control points where their edges meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from contiga.errors import InputError
from contiga.patches.basis import VALUE, BasisAt, Patch, basis_at
from contiga.patches.checks import (
    check_connected,
    check_edges,
    check_numbers,
    check_whole_edges,
)
from contiga.patches.pieces import EDGES, Joint, Piece, edge_of, pieces_of, rows_from
from contiga.records import FloatArray, IntArray

NEAR = 1e-6
"""Part of the size of all patches within which control points are the same, where none is given."""
SAME = 1e-9
"""Part by which knots and weights of two edges may differ and still be the same."""


class Net(NamedTuple):
    """Patches and their control points, as degrees of freedom."""

    control: tuple[IntArray, ...]
    """(n, m) degree of freedom of each control point of each patch."""
    pieces: tuple[Piece, ...]
    """Of all patches."""
    points: FloatArray
    """(d, 3) control points at rest."""
    sites: FloatArray
    """(d, 3) where each control point has its place on the surface: at its Greville parameters."""
    joints: tuple[Joint, ...]

    def edge(self, name: str, patch: int = 0, rows: int = 1) -> IntArray:
        """Degrees of freedom of an edge of a patch, ascending.

        Parameters
        ----------
        name : "u0", "u1", "v0" or "v1": where u or v begins or ends
        patch : number of the patch
        rows : of control points, from the edge on; two hold the slope there as well

        Raises
        ------
        InputError
            No such edge or patch, more rows than the patch has.
        """
        net = self._control_of(patch)
        way = rows_from(net, edge_name(name))
        if not 1 <= rows <= len(way):
            raise InputError(
                f"patch {patch} has {len(way)} rows of control points from its edge {name} on",
                where="rows",
                found=rows,
                allowed=f"1 to {len(way)}",
            )
        return np.unique(way[:rows]).astype(np.int32)

    def box(self, low: Sequence[float], high: Sequence[float]) -> IntArray:
        """Degrees of freedom whose place on the surface is in a box, ascending.

        Raises
        ------
        InputError
            None is there.
        """
        near = NEAR * _size(self.sites)
        inside = (self.sites >= np.asarray(low) - near) & (self.sites <= np.asarray(high) + near)
        rows = np.flatnonzero(inside.all(axis=1))
        if rows.size == 0:
            raise InputError(
                "no control point has its place on the surface there",
                where="box",
                found=[list(low), list(high)],
                allowed=f"from {self.sites.min(axis=0).tolist()} to "
                f"{self.sites.max(axis=0).tolist()}",
            )
        return rows.astype(np.int32)

    def _control_of(self, patch: int) -> IntArray:
        if not 0 <= patch < len(self.control):
            raise InputError(
                "there is no such patch",
                where="patch",
                found=patch,
                allowed=f"0 to {len(self.control) - 1}",
            )
        return self.control[patch]


def join(surfaces: Sequence[Patch], tolerance: float | None = None) -> Net:
    """Patches joined where their edges have the same control points.

    Parameters
    ----------
    surfaces : of degrees 1 to 5, such as `contiga.NurbsSurface`
    tolerance : length within which control points are the same; a millionth of the size of all
        patches if omitted

    Raises
    ------
    InputError
        No patch, a degree above 5, weights that are not positive, a pole or another edge along
        which the surface has no normal, patches that do not meet, that meet along a part of an
        edge, or with other control points, knots or weights.
    """
    patches = tuple(surfaces)
    if not patches:
        raise InputError("a shell needs a surface", where="surfaces", allowed="at least one")
    for k, patch in enumerate(patches):
        check_numbers(patch, f"surfaces[{k}]")
    size = _size(np.concatenate([patch.control_points.reshape(-1, 3) for patch in patches]))
    near = NEAR * size if tolerance is None else float(tolerance)
    starts = np.cumsum([0, *(patch.control_points[..., 0].size for patch in patches)])
    pieces = [
        piece for k, patch in enumerate(patches) for piece in pieces_of(patch, k, int(starts[k]))
    ]
    for piece in pieces:
        check_edges(piece, near)
    joints = _joints(pieces, near)
    check_whole_edges(pieces, joints, near)
    check_connected(pieces, joints)
    first, numbers = _shared(int(starts[-1]), pieces, joints)
    points, sites = (
        np.concatenate([part.reshape(-1, 3) for part in parts])[first]
        for parts in (
            [np.asarray(patch.control_points, np.float64) for patch in patches],
            [_greville_points(patch) for patch in patches],
        )
    )
    control = tuple(
        numbers[start : start + patch.control_points[..., 0].size].reshape(
            patch.control_points.shape[:2]
        )
        for start, patch in zip(starts, patches, strict=False)
    )
    renumbered = tuple(piece._replace(control=numbers[piece.control]) for piece in pieces)
    return Net(control, renumbered, points, sites, joints)


def _shared(
    count: int, pieces: Sequence[Piece], joints: Sequence[Joint]
) -> tuple[NDArray[np.intp], IntArray]:
    """The first control point of each degree of freedom, and the degree of freedom of each."""
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        for joint in joints:
            one, other = (
                rows_from(pieces[piece].control, edge)[0]
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            )
            other = other[::-1] if joint.turned else other
            least = np.minimum(lowest[one], lowest[other])
            np.minimum.at(lowest, one, least)
            np.minimum.at(lowest, other, least)
        if (before == lowest).all():
            break
    first, numbers = np.unique(lowest, return_inverse=True)
    return first, numbers.astype(np.int32)


def _joints(pieces: Sequence[Piece], near: float) -> tuple[Joint, ...]:
    """All pairs of edges with the same control points.

    Raises
    ------
    InputError
        A pair of edges that is the same curve with other control points, knots or weights.
    """
    edges = [(piece, name) for piece in range(len(pieces)) for name in EDGES]
    lines = [rows_from(pieces[piece].control_points, name)[0] for piece, name in edges]
    ends = np.stack([line[[0, -1]] for line in lines])
    close = cKDTree(ends.mean(axis=1)).query_pairs(2.0 * near, output_type="ndarray")
    joints = []
    for a, b in close[np.lexsort(close.T[::-1])]:
        for turned in (False, True):
            other = ends[b][::-1] if turned else ends[b]
            if np.abs(ends[a] - other).max() > near:
                continue
            joint = Joint((edges[a][0], edges[b][0]), (edges[a][1], edges[b][1]), turned)
            if _same_curve(pieces, joint, near):
                joints.append(joint)
                break
    return tuple(joints)


def _same_curve(pieces: Sequence[Piece], joint: Joint, near: float) -> bool:
    """Return whether two edges with the same ends are one, with the same control points."""
    both = [(pieces[k], name) for k, name in zip(joint.pieces, joint.edges, strict=True)]
    one, other = (edge_of(piece, name) for piece, name in both)
    if joint.turned:
        other = other.turned()
    if np.abs(one.samples - other.samples).max() > near:
        return False
    for what, a, b, slack in (
        ("degree", np.array([one.degree]), np.array([other.degree]), 0.5),
        ("knots", one.knots, other.knots, SAME),
        ("control points", one.points, other.points, near),
        ("weights", one.weights, other.weights, SAME),
    ):
        if a.shape != b.shape or np.abs(a - b).max() > slack:
            raise InputError(
                f"they meet, but their {what} there differ",
                where=" and ".join(f"surfaces[{piece.patch}] {name}" for piece, name in both),
                found=f"{len(one.points)} and {len(other.points)} control points, "
                f"degrees {one.degree} and {other.degree}",
                allowed="the same degree, knots, control points and weights along the joint",
                remedy="Refine both alike: NurbsSurface.insert_knots, elevate",
            )
    return True


def _greville_points(patch: Patch) -> FloatArray:
    """Return (n · m, 3) points of the surface at the Greville parameters of its control points."""
    means = [
        np.array([knots[i + 1 : i + p + 1].mean() for i in range(len(knots) - p - 1)])
        for knots, p in zip(patch.knots, patch.degrees, strict=True)
    ]
    uv = np.stack(np.meshgrid(*means, indexing="ij"), axis=2).reshape(-1, 2)
    return basis_at(patch, uv).of(VALUE, patch.control_points.reshape(-1, 3))


def edge_name(name: str) -> str:
    """An edge by its name, refused where there is none of that name."""
    if name not in EDGES:
        raise InputError(
            "there is no such edge", where="edge", found=name, allowed=", ".join(EDGES)
        )
    return name


def _size(points: FloatArray) -> float:
    return float(np.sqrt(np.sum(np.ptp(points, axis=0) ** 2)))


def on_net(piece: Piece, uv: FloatArray) -> BasisAt:
    """Basis functions at parameters (k, 2), with degrees of freedom of the net."""
    at = basis_at(piece, uv)
    return BasisAt(piece.control.ravel()[at.control], at.values)
