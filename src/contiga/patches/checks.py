"""Refuse patches that cannot be a shell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contiga.errors import GeometryError, InputError
from contiga.patches.basis import VALUE, Patch, U, V, basis_at
from contiga.patches.pieces import (
    EDGES,
    SAMPLES,
    Joint,
    Piece,
    edge_of,
    edge_parameters,
    rows_from,
)
from contiga.records import FloatArray

DEGREES = 5
"""The highest."""
PARALLEL = 1e-9
"""Sine of the angle between S_u and S_v below which a surface has no normal."""
HALVINGS = 40
"""Of the distance between samples, until there is rounding alone."""


def check_numbers(patch: Patch, where: str) -> None:
    """Refuse a degree that is too high, points that are not finite, weights not above zero."""
    if max(patch.degrees) > DEGREES or min(patch.degrees) < 1:
        raise InputError(
            "is of a degree that shells do not have",
            where=where,
            found=tuple(patch.degrees),
            allowed=f"1 to {DEGREES}",
        )
    if not np.isfinite(patch.control_points).all():
        raise GeometryError("control points must be finite", where=where)
    if patch.weights is not None and not (np.asarray(patch.weights) > 0.0).all():
        raise GeometryError(
            "weights must be positive", where=where, found=float(np.min(patch.weights))
        )


def check_edges(patch: Piece, near: float) -> None:
    """Refuse a pole, and any other edge along which there is no normal."""
    net = patch.control_points.reshape(-1, 3)
    for name in EDGES:
        line = rows_from(patch.control_points, name)[0]
        knots = patch.knots[1 if name[0] == "u" else 0]
        inner = knots[0] + (knots[-1] - knots[0]) * (np.arange(SAMPLES) + 0.5) / SAMPLES
        at = basis_at(patch, edge_parameters(patch, name, inner))
        a, b = at.of(U, net), at.of(V, net)
        sine = _lengths(np.cross(a, b))
        if np.abs(line - line[0]).max() <= near:
            what = "is a pole: all its control points are one"
        elif (sine <= PARALLEL * _lengths(a) * _lengths(b)).any():
            what = "is degenerate: the surface has no normal along it"
        else:
            continue
        raise InputError(
            f"edge {name} {what}",
            where=f"surfaces[{patch.patch}]",
            found=np.round(line[0], 9).tolist(),
            allowed="edges of a length, along which S_u and S_v span a plane",
            remedy="Cut it off, or cover it by patches of four sides",
        )


def check_connected(pieces: Sequence[Piece], joints: Sequence[Joint]) -> None:
    """Refuse patches that hang together with none of the others."""
    reached, new = {0}, True
    while new:
        new = False
        for joint in joints:
            ends = set(joint.pieces)  # one piece where it is joined with itself
            if ends & reached and not ends <= reached:
                reached |= ends
                new = True
    apart = [k for k in range(len(pieces)) if k not in reached]
    if not apart:
        return
    own = _border_points(pieces[apart[0]])
    gaps = {k: _gap(own, _border_points(pieces[k])) for k in reached}
    nearest = min(gaps, key=lambda k: gaps[k])
    patches = dict.fromkeys(str(pieces[k].patch) for k in apart)
    raise InputError(
        f"surfaces {', '.join(patches)} do not meet the others: no edge of theirs has the control "
        "points of another",
        where="surfaces",
        found=f"surfaces[{pieces[apart[0]].patch}] is {gaps[nearest]:.3g} from "
        f"surfaces[{pieces[nearest].patch}]",
        allowed="patches that share control points along whole edges",
        remedy="Refine neighbours alike, or make shells of their own",
    )


def check_whole_edges(pieces: Sequence[Piece], joints: Sequence[Joint], near: float) -> None:
    """Refuse edges that meet another along a part of theirs: a slit would open there."""
    joined = {
        (piece, edge)
        for joint in joints
        for piece, edge in zip(joint.pieces, joint.edges, strict=True)
    }
    free = [(k, name) for k in range(len(pieces)) for name in EDGES if (k, name) not in joined]
    if not free:
        return
    lines = [rows_from(pieces[k].control_points, name)[0] for k, name in free]
    ends = np.concatenate([line[[0, -1]] for line in lines])
    for (k, name), line in zip(free, lines, strict=True):
        # A curve lies in the box of its control points, and other corners lie on it if on any.
        inside = (ends >= line.min(axis=0) - near) & (ends <= line.max(axis=0) + near)
        apart = [np.abs(ends - end).max(axis=1) > near for end in line[[0, -1]]]
        rows = np.flatnonzero(inside.all(axis=1) & apart[0] & apart[1])
        on = rows[_distances(pieces[k], name, ends[rows]) <= near]
        if on.size:
            other, edge = free[int(on[0]) // 2]
            raise InputError(
                "they meet along a part of an edge",
                where=f"surfaces[{pieces[k].patch}] {name} and "
                f"surfaces[{pieces[other].patch}] {edge}",
                found=f"a corner at {np.round(ends[on[0]], 9).tolist()}",
                allowed="patches that share control points along whole edges",
                remedy="Split the longer one there: NurbsSurface.split",
            )


def _distances(piece: Piece, name: str, points: FloatArray) -> FloatArray:
    """Return (k,) distances of points from an edge, by halving between the nearest samples."""
    knots = piece.knots[1 if name[0] == "u" else 0]
    low, high = float(knots[0]), float(knots[-1])
    net = piece.control_points.reshape(-1, 3)
    found = np.empty(len(points))
    for row, point in enumerate(points):
        width, middle = high - low, 0.5 * (low + high)
        count = 8 * len(knots) + 1
        for _ in range(HALVINGS):
            along = np.linspace(
                max(middle - 0.5 * width, low), min(middle + 0.5 * width, high), count
            )
            x = basis_at(piece, edge_parameters(piece, name, along)).of(VALUE, net)
            ways = _lengths(x - point)
            best = int(np.argmin(ways))
            found[row], middle = ways[best], along[best]
            width, count = 4.0 * width / (count - 1), 9
    return found


def _border_points(patch: Patch) -> FloatArray:
    """Points on all edges."""
    return np.concatenate([edge_of(patch, name).samples for name in EDGES])


def _gap(some: FloatArray, others: FloatArray) -> float:
    """The least distance between points."""
    return float(np.sqrt(np.min(np.sum((some[:, None] - others[None]) ** 2, axis=2))))


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(vectors * vectors, axis=-1)))


def whole_number(value: object, where: str, least: int) -> int:
    """A whole number, checked."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(
            "must be a whole number", where=where, found=value, allowed=f"{least} or more"
        )
    return int(value)
