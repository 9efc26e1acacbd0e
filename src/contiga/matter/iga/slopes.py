"""Springs that keep the slope of a shell across joints of patches and at planes of symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import read_only
from contiga.errors import InputError
from contiga.matter.iga.elements import gauss
from contiga.matter.tables import SlopeTables
from contiga.patches.basis import BasisAt, U, V, elements_of
from contiga.patches.net import Net, on_net
from contiga.patches.pieces import Piece, edge_parameters, rows_from
from contiga.records import FloatArray

MIN_STIFFNESS, FREE = 10.0, 2.0
"""Of springs whose stiffness is not given: a tenth of an element turns as much as they do at most;
with twice the square of width over thickness they shorten no critical step."""
NUDGE = 1e-5
"""Part of the width of an element by which differences move control points."""


@dataclass(frozen=True, eq=False)
class Symmetry:
    """An edge that lies in a plane of symmetry, towards which the surface keeps its angle.

    That the edge stays in the plane is for what holds its control points to say. Where all of them
    are held it is a clamp.

    Parameters
    ----------
    edge : "u0", "u1", "v0" or "v1"
    normal : (3,) of the plane; if omitted the surface is at right angles to it, along all the edge
    patch : number of the patch
    """

    edge: str
    normal: FloatArray | None = None
    patch: int = 0

    def __post_init__(self) -> None:
        if self.normal is None:
            return
        normal = np.asarray(self.normal, dtype=np.float64)
        length = np.sqrt(np.sum(normal * normal))
        if normal.shape != (3,) or not 0.0 < length < np.inf:
            raise InputError(
                "must be a direction", where="Symmetry(normal)", found=self.normal, allowed="(3,)"
            )
        object.__setattr__(self, "normal", read_only(normal / length))


class _Side(NamedTuple):
    """Points along an edge of a patch, as its elements have them."""

    at: BasisAt
    along: FloatArray
    """(k, c) derivative along the edge."""
    normal: FloatArray
    """(k, 3) unit normals at rest."""
    outward: FloatArray
    """(k, 3) unit vectors at rest, in the surface and across the edge."""
    width: FloatArray
    """(k,) of the element, across the edge."""
    length: FloatArray
    """(k,) of edge at rest for each point."""


class Bending(NamedTuple):
    """Stiffness of the springs."""

    rigidity: float
    """E t³/12 of the shell, moment · length."""
    thickness: float
    stiffness: float | None
    """Stiffness as a multiple of that of an element, rigidity by width; None for the largest one
    no stiffer than the element in its plane, and `MIN_STIFFNESS` at least."""

    def over(self, width: FloatArray) -> FloatArray:
        """Return the moment by radian and length (k,) for elements of widths (k,)."""
        if self.stiffness is None:
            parts = np.maximum(MIN_STIFFNESS, FREE * (width / self.thickness) ** 2)
        else:
            parts = np.full(len(width), self.stiffness)
        return parts * self.rigidity / width


def slope_tables(net: Net, symmetries: Sequence[Symmetry], bending: Bending) -> SlopeTables | None:
    """Springs at all joints and planes of symmetry; None where there are none."""
    parts = []
    for joint in net.joints:
        one, other = (
            _side(net, net.pieces[piece], edge, turned)
            for piece, edge, turned in zip(
                joint.pieces, joint.edges, (False, joint.turned), strict=True
            )
        )
        parts.append(_between(net, one, other, bending))
    for plane in symmetries:
        net.edge(plane.edge, plane.patch)  # raises where there is none
        for piece in net.pieces:
            if piece.patch == plane.patch and plane.edge in piece.ends:
                side = _side(net, piece, plane.edge, False)
                normal = side.outward if plane.normal is None else plane.normal
                parts.append(_towards(side, normal, bending))
    return _together(parts) if parts else None


def _side(net: Net, piece: Piece, edge: str, turned: bool) -> _Side:
    along, across = (1, 0) if edge[0] == "u" else (0, 1)
    rule = gauss(piece.degrees[along] + 1)
    spans = elements_of(piece.knots[along])
    spans = spans[::-1] if turned else spans
    size = np.diff(spans, axis=1)
    inner = 1.0 - rule.points if turned else rule.points
    parameters = (spans[:, :1] + size * inner).ravel()
    weights = (size * rule.weights).ravel()
    whole = on_net(piece, edge_parameters(piece, edge, parameters))
    p, q = piece.degrees
    # What lies beyond the second row of control points changes nothing of S_u and S_v there.
    near = rows_from(np.arange((p + 1) * (q + 1)).reshape(p + 1, q + 1), edge)[:2].ravel()
    at = BasisAt(whole.control[:, near], whole.values[:, :, near])
    a, b = at.of(U, net.points), at.of(V, net.points)
    normal = np.cross(a, b)
    tangent, out = (b, a) if along == 1 else (a, b)
    spans_across = elements_of(piece.knots[across])
    last = spans_across[0 if edge[1] == "0" else -1]
    outward = np.cross(normal, tangent)
    return _Side(
        at,
        at.values[:, (U, V)[along]] * (-1.0 if turned else 1.0),
        normal / _lengths(normal)[:, None],
        outward / _lengths(outward)[:, None],
        (last[1] - last[0]) * _lengths(out),
        weights * _lengths(tangent),
    )


class _Springs(NamedTuple):
    """Tables of some points, and both sides as they are put side by side."""

    sides: tuple[_Side, ...]
    basis: FloatArray
    plane: FloatArray
    rest: FloatArray
    stiffness: FloatArray


def _between(net: Net, one: _Side, other: _Side, bending: Bending) -> _Springs:
    tangent = (one.along[:, :, None] * net.points[one.at.control]).sum(axis=1)
    tangent /= _lengths(tangent)[:, None]
    cosine = np.sum(one.normal * other.normal, axis=1)
    sine = np.sum(tangent * np.cross(one.normal, other.normal), axis=1)
    rest = np.stack([cosine, sine], axis=1)
    rest /= _lengths(rest)[:, None]
    k, c = one.along.shape
    basis = np.zeros((k, 5, c + other.along.shape[1]))
    basis[:, :2, :c] = one.at.values[:, [U, V]]
    basis[:, 2:4, c:] = other.at.values[:, [U, V]]
    basis[:, 4, :c] = one.along
    stiff = one.length * bending.over(0.5 * (one.width + other.width))
    return _Springs((one, other), basis, np.zeros((k, 3)), rest, stiff)


def _towards(side: _Side, normal: FloatArray, bending: Bending) -> _Springs:
    k, c = side.along.shape
    basis = np.zeros((k, 5, c))
    basis[:, :2] = side.at.values[:, [U, V]]
    rest = np.stack([np.sum(side.normal * normal, axis=1), np.zeros(k)], axis=1)
    # The mirror image turns as much the other way: four times the energy, half of it on this side.
    stiff = 2.0 * side.length * bending.over(side.width)
    plane = np.ascontiguousarray(np.broadcast_to(normal, (k, 3)))
    return _Springs((side,), basis, plane, rest, stiff)


def _together(parts: Sequence[_Springs]) -> SlopeTables:
    """Return one table; control points that fill rows up have a basis of zero."""
    most = max(part.basis.shape[2] for part in parts)
    nodes, basis = [], []
    for part in parts:
        control = np.concatenate([side.at.control for side in part.sides], axis=1)
        fill = most - control.shape[1]
        nodes.append(np.pad(control, ((0, 0), (0, fill)), mode="edge"))
        basis.append(np.pad(part.basis, ((0, 0), (0, 0), (0, fill))))
    return SlopeTables(
        np.ascontiguousarray(np.concatenate(nodes), np.int32),
        np.ascontiguousarray(np.concatenate(basis)),
        np.concatenate([part.plane for part in parts]),
        np.concatenate([part.rest for part in parts]),
        np.concatenate([part.stiffness for part in parts]),
        NUDGE * np.concatenate([part.sides[0].width for part in parts]),
    )


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.sum(vectors * vectors, axis=-1)))
