"""Patches that share control points where their edges meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

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

JOIN_TOL = 1e-6
"""Default tolerance of equal control points, as a share of the size of all patches."""
KNOT_TOL = 1e-9
"""Difference up to which knots and weights of two edges are the same."""


class Net(NamedTuple):
    """Patches and their control points, as degrees of freedom."""

    control: tuple[IntArray, ...]
    """(n, m) degree of freedom of each control point of each patch."""
    pieces: tuple[Piece, ...]
    """Pieces of all patches."""
    points: FloatArray
    """(d, 3) control points at rest."""
    sites: FloatArray
    """(d, 3) points of the surface at rest at the Greville parameters of the control points."""
    joints: tuple[Joint, ...]

    def edge(self, name: str, patch: int = 0, rows: int = 1) -> IntArray:
        """Return the degrees of freedom of an edge of a patch, ascending.

        Parameters
        ----------
        name : "u0", "u1", "v0" or "v1": the side on which u or v starts or ends
        patch : number of the patch
        rows : number of rows of control points from the edge on; two hold the slope as well

        Raises
        ------
        InputError
            There is no such edge or patch, or `rows` is more than the patch has.
        """
        if not 0 <= patch < len(self.control):
            raise InputError(
                "there is no such patch",
                where="patch",
                found=patch,
                allowed=f"0 to {len(self.control) - 1}",
            )
        control_rows = rows_from(self.control[patch], edge_name(name))
        if not 1 <= rows <= len(control_rows):
            raise InputError(
                f"patch {patch} has {len(control_rows)} rows of control points from its edge "
                f"{name} on",
                where="rows",
                found=rows,
                allowed=f"1 to {len(control_rows)}",
            )
        return np.unique(control_rows[:rows]).astype(np.int32)

    def box(self, low: Sequence[float], high: Sequence[float]) -> IntArray:
        """Return the numbers of the control points whose `sites` are in a box, ascending.

        Points up to `JOIN_TOL` of the size of all sites outside count as inside.

        Parameters
        ----------
        low, high : (3,) lowest and highest corner, length

        Raises
        ------
        InputError
            No site is in the box.
        """
        tol = JOIN_TOL * _size(self.sites)
        inside = (self.sites >= np.asarray(low) - tol) & (self.sites <= np.asarray(high) + tol)
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


def join(surfaces: Sequence[Patch], tolerance: float | None = None) -> Net:
    """Join patches whose edges have the same control points into one `Net`.

    Control points of joined edges become one degree of freedom, at the place of the first of them.

    Parameters
    ----------
    surfaces : patches of degrees 1 to 5, such as `contiga.NurbsSurface`
    tolerance : length within which control points are the same; a millionth of the size of all
        patches if omitted

    Raises
    ------
    InputError
        There is no patch, a degree outside 1 to 5, a pole or another edge along which the surface
        has no normal; patches do not meet, or meet along a part of an edge, or with other control
        points, knots or weights.
    GeometryError
        A control point is not finite, or a weight not positive.
    """
    patches = tuple(surfaces)
    if not patches:
        raise InputError("a shell needs a surface", where="surfaces", allowed="at least one")
    for k, patch in enumerate(patches):
        check_numbers(patch, f"surfaces[{k}]")
    size = _size(np.concatenate([patch.control_points.reshape(-1, 3) for patch in patches]))
    tol = JOIN_TOL * size if tolerance is None else float(tolerance)
    starts = np.cumsum([0, *(patch.control_points[..., 0].size for patch in patches)])
    pieces = [
        piece for k, patch in enumerate(patches) for piece in pieces_of(patch, k, int(starts[k]))
    ]
    for piece in pieces:
        check_edges(piece, tol)
    joints = _find_joints(pieces, tol)
    check_whole_edges(pieces, joints, tol)
    check_connected(pieces, joints)
    first, merged = merge_joined([piece.control for piece in pieces], joints, int(starts[-1]))
    numbers = merged.astype(np.int32)
    nets = [np.asarray(patch.control_points, np.float64).reshape(-1, 3) for patch in patches]
    points = np.concatenate(nets)[first]
    sites = np.concatenate([_greville_points(patch) for patch in patches])[first]
    control = tuple(
        numbers[start : start + patch.control_points[..., 0].size].reshape(
            patch.control_points.shape[:2]
        )
        for start, patch in zip(starts, patches, strict=False)
    )
    renumbered = tuple(piece._replace(control=numbers[piece.control]) for piece in pieces)
    return Net(control, renumbered, points, sites, joints)


def merge_joined(
    grids: Sequence[NDArray[Any]], joints: Sequence[Joint], count: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Number `count` points anew so that coinciding points of joined edges become one.

    New numbers are in the order of the first old point of each.

    Parameters
    ----------
    grids : (n, m) points of each piece
    joints : between edges of the pieces
    count : number of points before

    Returns
    -------
    first : (d,) first of the old points of each new one
    numbers : (count,) new point of each old one
    """
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        for joint in joints:
            first, second = (
                rows_from(grids[piece], edge)[0]
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            )
            second = second[::-1] if joint.turned else second
            lower = np.minimum(lowest[first], lowest[second])
            np.minimum.at(lowest, first, lower)
            np.minimum.at(lowest, second, lower)
        if (before == lowest).all():
            return np.unique(lowest, return_inverse=True)


def _find_joints(pieces: Sequence[Piece], tol: float) -> tuple[Joint, ...]:
    """Return the joints: all pairs of edges that are the same curve, in the order of edges.

    Two edges are the same curve if their ends and `N_SAMPLES` points agree within the length `tol`.
    They must then have the same degree, knots, control points and weights.

    Raises
    ------
    InputError
        Two such edges differ in one of these.
    """
    edges = [(piece, name) for piece in range(len(pieces)) for name in EDGES]
    lines = [rows_from(pieces[piece].control_points, name)[0] for piece, name in edges]
    ends = np.stack([line[[0, -1]] for line in lines])
    close = cKDTree(ends.mean(axis=1)).query_pairs(2.0 * tol, output_type="ndarray")
    joints = []
    for a, b in close[np.lexsort(close.T[::-1])]:
        for turned in (False, True):
            if np.abs(ends[a] - (ends[b][::-1] if turned else ends[b])).max() > tol:
                continue
            sides = [(pieces[piece], name) for piece, name in (edges[a], edges[b])]
            first, second = (edge_of(piece, name) for piece, name in sides)
            second = second.reversed() if turned else second
            if np.abs(first.samples - second.samples).max() > tol:
                continue
            for quantity, p, q, allowed in (
                ("degree", np.array([first.degree]), np.array([second.degree]), 0.5),
                ("knots", first.knots, second.knots, KNOT_TOL),
                ("control points", first.points, second.points, tol),
                ("weights", first.weights, second.weights, KNOT_TOL),
            ):
                if p.shape != q.shape or np.abs(p - q).max() > allowed:
                    raise InputError(
                        f"they meet, but their {quantity} there differ",
                        where=" and ".join(
                            f"surfaces[{piece.patch}] {name}" for piece, name in sides
                        ),
                        found=f"{len(first.points)} and {len(second.points)} control points, "
                        f"degrees {first.degree} and {second.degree}",
                        allowed="the same degree, knots, control points and weights along the "
                        "joint",
                        remedy="Refine both alike: NurbsSurface.insert_knots, elevate",
                    )
            joints.append(Joint((edges[a][0], edges[b][0]), (edges[a][1], edges[b][1]), turned))
            break
    return tuple(joints)


def _greville_points(patch: Patch) -> FloatArray:
    """Return (n · m, 3) points of the surface at the Greville parameters of its control points."""
    means = [
        np.array([knots[i + 1 : i + p + 1].mean() for i in range(len(knots) - p - 1)])
        for knots, p in zip(patch.knots, patch.degrees, strict=True)
    ]
    uv = np.stack(np.meshgrid(*means, indexing="ij"), axis=2).reshape(-1, 2)
    return basis_at(patch, uv).of(VALUE, patch.control_points.reshape(-1, 3))


def edge_name(name: str) -> str:
    """Return `name` if it is one of `EDGES`; raise InputError otherwise."""
    if name not in EDGES:
        raise InputError(
            "there is no such edge", where="edge", found=name, allowed=", ".join(EDGES)
        )
    return name


def _size(points: FloatArray) -> float:
    """Return the diagonal of the box of points (k, 3)."""
    return float(np.sqrt(np.sum(np.ptp(points, axis=0) ** 2)))


def on_net(piece: Piece, uv: FloatArray) -> BasisAt:
    """Return `basis_at` parameters (k, 2) of a piece, its control points numbered as in the net."""
    at = basis_at(piece, uv)
    return BasisAt(piece.control.ravel()[at.control], at.values)
