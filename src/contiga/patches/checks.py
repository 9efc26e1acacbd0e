"""Checks that patches can be a shell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contiga.errors import GeometryError, InputError
from contiga.patches.basis import VALUE, Patch, U, V, basis_at
from contiga.patches.pieces import (
    EDGES,
    N_SAMPLES,
    Joint,
    Piece,
    edge_of,
    edge_parameters,
    rows_from,
)
from contiga.records import FloatArray

MAX_DEGREE = 5
"""Highest degree of a shell."""
PARALLEL_TOL = 1e-9
"""Sine of the angle between S_u and S_v below which a surface has no normal."""
MAX_HALVINGS = 40
"""Number of refinements of a distance; each halves the interval about the nearest sample."""


def check_numbers(patch: Patch, where: str) -> None:
    """Raise an error for numbers that no shell can have.

    Raises
    ------
    InputError
        A degree outside 1 to 5.
    GeometryError
        A control point that is not finite, a weight that is not positive.
    """
    if max(patch.degrees) > MAX_DEGREE or min(patch.degrees) < 1:
        raise InputError(
            "is of a degree that shells do not have",
            where=where,
            found=tuple(patch.degrees),
            allowed=f"1 to {MAX_DEGREE}",
        )
    if not np.isfinite(patch.control_points).all():
        raise GeometryError("control points must be finite", where=where)
    if patch.weights is not None and not (np.asarray(patch.weights) > 0.0).all():
        raise GeometryError(
            "weights must be positive", where=where, found=float(np.min(patch.weights))
        )


def check_edges(patch: Piece, tol: float) -> None:
    """Raise InputError for an edge that is a pole, or on which the surface lacks a normal.

    All control points of a pole are within the length `tol` in x, y and z. Normals are tested at
    `N_SAMPLES` parameters inside the edge: one at which S_u and S_v are parallel to `PARALLEL_TOL`
    is a fault.
    """
    net = patch.control_points.reshape(-1, 3)
    for name in EDGES:
        line = rows_from(patch.control_points, name)[0]
        knots = patch.knots[1 if name[0] == "u" else 0]
        inner = knots[0] + (knots[-1] - knots[0]) * (np.arange(N_SAMPLES) + 0.5) / N_SAMPLES
        at = basis_at(patch, edge_parameters(patch, name, inner))
        S_u, S_v = at.of(U, net), at.of(V, net)
        normal_length = _lengths(np.cross(S_u, S_v))
        if np.abs(line - line[0]).max() <= tol:
            fault = "is a pole: all its control points are one"
        elif (normal_length <= PARALLEL_TOL * _lengths(S_u) * _lengths(S_v)).any():
            fault = "is degenerate: the surface has no normal along it"
        else:
            continue
        raise InputError(
            f"edge {name} {fault}",
            where=f"surfaces[{patch.patch}]",
            found=np.round(line[0], 9).tolist(),
            allowed="edges of a length, along which S_u and S_v span a plane",
            remedy="Cut it off, or cover it by patches of four sides",
        )


def check_connected(pieces: Sequence[Piece], joints: Sequence[Joint]) -> None:
    """Raise InputError unless joints connect all pieces, directly or through others.

    The message names the patches that piece 0 does not reach, and the distance between samples of
    the edges of the first of these and of the nearest piece.
    """
    reached, has_grown = {0}, True
    while has_grown:
        has_grown = False
        for joint in joints:
            ends = set(joint.pieces)  # one piece if it is joined with itself
            if ends & reached and not ends <= reached:
                reached |= ends
                has_grown = True
    separate = [k for k in range(len(pieces)) if k not in reached]
    if not separate:
        return
    points = _border_points(pieces[separate[0]])
    gaps = {}
    for k in reached:
        offsets = points[:, None] - _border_points(pieces[k])[None]
        gaps[k] = float(np.sqrt(np.min(np.sum(offsets**2, axis=2))))
    nearest = min(gaps, key=lambda k: gaps[k])
    patches = dict.fromkeys(str(pieces[k].patch) for k in separate)
    raise InputError(
        f"surfaces {', '.join(patches)} do not meet the others: no edge of theirs has the control "
        "points of another",
        where="surfaces",
        found=f"surfaces[{pieces[separate[0]].patch}] is {gaps[nearest]:.3g} from "
        f"surfaces[{pieces[nearest].patch}]",
        allowed="patches that share control points along whole edges",
        remedy="Refine neighbours alike, or make shells of their own",
    )


def check_whole_edges(pieces: Sequence[Piece], joints: Sequence[Joint], tol: float) -> None:
    """Raise InputError if a free edge contains an end of another one: a slit would open there.

    Free edges have no joint. An end counts if it is within the length `tol` of the edge, and
    farther than that, in x, y or z, from both of the edge's own ends.
    """
    joined = {
        (piece, edge)
        for joint in joints
        for piece, edge in zip(joint.pieces, joint.edges, strict=True)
    }
    free = [(k, name) for k in range(len(pieces)) for name in EDGES if (k, name) not in joined]
    if not free:
        return
    lines = [rows_from(pieces[k].control_points, name)[0] for k, name in free]
    corners = np.concatenate([line[[0, -1]] for line in lines])
    for (k, name), line in zip(free, lines, strict=True):
        # A curve lies in the box of its control points, and so do corners of others on it.
        in_box = (corners >= line.min(axis=0) - tol) & (corners <= line.max(axis=0) + tol)
        differs = [np.abs(corners - end).max(axis=1) > tol for end in line[[0, -1]]]
        rows = np.flatnonzero(in_box.all(axis=1) & differs[0] & differs[1])
        on_edge = rows[_edge_distances(pieces[k], name, corners[rows]) <= tol]
        if on_edge.size:
            partner, edge = free[int(on_edge[0]) // 2]
            raise InputError(
                "they meet along a part of an edge",
                where=f"surfaces[{pieces[k].patch}] {name} and "
                f"surfaces[{pieces[partner].patch}] {edge}",
                found=f"a corner at {np.round(corners[on_edge[0]], 9).tolist()}",
                allowed="patches that share control points along whole edges",
                remedy="Split the longer one there: NurbsSurface.split",
            )


def _edge_distances(piece: Piece, name: str, points: FloatArray) -> FloatArray:
    """Return distances (k,) of points from an edge, length.

    The edge is sampled, and sampled again around the nearest sample until the interval is rounding.
    A second minimum between the first samples can be missed.
    """
    knots = piece.knots[1 if name[0] == "u" else 0]
    low, high = float(knots[0]), float(knots[-1])
    net = piece.control_points.reshape(-1, 3)
    result = np.empty(len(points))
    for row, point in enumerate(points):
        width, middle = high - low, 0.5 * (low + high)
        count = 8 * len(knots) + 1
        for _ in range(MAX_HALVINGS):
            t = np.linspace(max(middle - 0.5 * width, low), min(middle + 0.5 * width, high), count)
            x = basis_at(piece, edge_parameters(piece, name, t)).of(VALUE, net)
            distances = _lengths(x - point)
            nearest = int(np.argmin(distances))
            result[row], middle = distances[nearest], t[nearest]
            width, count = 4.0 * width / (count - 1), 9
    return result


def _border_points(patch: Patch) -> FloatArray:
    """Return (4 N_SAMPLES, 3) points on the four edges."""
    return np.concatenate([edge_of(patch, name).samples for name in EDGES])


def _lengths(vectors: FloatArray) -> FloatArray:
    """Return lengths of vectors (..., 3)."""
    return np.asarray(np.sqrt(np.sum(vectors * vectors, axis=-1)))


def whole_number(value: object, where: str, minimum: int) -> int:
    """Return `value` as an int; raise InputError unless it is a whole number ≥ `minimum`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < minimum:
        raise InputError(
            "must be a whole number", where=where, found=value, allowed=f"{minimum} or more"
        )
    return int(value)
