"""Springs that hold the slope of a shell across joints of patches and at planes of symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import read_only
from contiga.errors import InputError
from contiga.matter.iga.elements import gauss, lengths
from contiga.matter.tables import SlopeTables
from contiga.patches.basis import BasisAt, U, V, elements_of
from contiga.patches.net import Net, on_net
from contiga.patches.pieces import Piece, edge_parameters, rows_from
from contiga.records import FloatArray

MIN_STIFFNESS, IN_PLANE_FACTOR = 10.0, 2.0
"""Default stiffness of springs over that of an element: at least 10, so that they turn no more than
a tenth of the element does; 2 (width/thickness)² does not shorten the critical step."""
NUDGE = 1e-5
"""Displacement of control points for finite differences, over the width of an element."""


@dataclass(frozen=True, eq=False)
class Symmetry:
    """An edge in a plane of symmetry, to which springs hold the angle of the surface.

    They do not hold the edge in the plane: its control points must be held for that. If these are
    held in all directions, the edge is clamped.

    Parameters
    ----------
    edge : "u0", "u1", "v0" or "v1"
    normal : (3,) of the plane; if omitted the surface is perpendicular to it along the edge
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
    """Points along an edge of a patch, Gauss points of its elements."""

    at: BasisAt
    tangent_basis: FloatArray
    """(k, c) derivative along the edge."""
    normal: FloatArray
    """(k, 3) unit normals at rest."""
    outward: FloatArray
    """(k, 3) unit vectors at rest, in the surface and across the edge."""
    width: FloatArray
    """(k,) width of the element across the edge."""
    length: FloatArray
    """(k,) length of edge at rest of each point."""


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
            factors = np.maximum(MIN_STIFFNESS, IN_PLANE_FACTOR * (width / self.thickness) ** 2)
        else:
            factors = np.full(len(width), self.stiffness)
        return factors * self.rigidity / width


def slope_tables(net: Net, symmetries: Sequence[Symmetry], bending: Bending) -> SlopeTables | None:
    """Return the springs at all joints and planes of symmetry; None without any.

    Rows are points: of joints first, then of planes. Raises as `Net.edge` does for an edge that
    does not exist.
    """
    parts = []
    for joint in net.joints:
        first, second = (net.pieces[piece] for piece in joint.pieces)
        side_1 = _side(net, first, joint.edges[0], False)
        side_2 = _side(net, second, joint.edges[1], joint.turned)
        parts.append(_springs_at_joint(net, side_1, side_2, bending))
    for plane in symmetries:
        net.edge(plane.edge, plane.patch)  # raises if there is no such edge
        for piece in net.pieces:
            if piece.patch != plane.patch or plane.edge not in piece.ends:
                continue
            side = _side(net, piece, plane.edge, False)
            normal = side.outward if plane.normal is None else plane.normal
            k, c = side.tangent_basis.shape
            basis = np.zeros((k, 5, c))
            basis[:, :2] = side.at.values[:, [U, V]]
            rest = np.stack([np.sum(side.normal * normal, axis=1), np.zeros(k)], axis=1)
            # The mirror image rotates the other way: four times the energy, half on this side.
            stiffness = 2.0 * side.length * bending.over(side.width)
            planes = np.ascontiguousarray(np.broadcast_to(normal, (k, 3)))
            parts.append(_Springs((side,), basis, planes, rest, stiffness))
    if not parts:
        return None
    # Rows with fewer control points are padded, with a basis of zero.
    width = max(part.basis.shape[2] for part in parts)
    nodes, bases = [], []
    for part in parts:
        control = np.concatenate([side.at.control for side in part.sides], axis=1)
        padding = width - control.shape[1]
        nodes.append(np.pad(control, ((0, 0), (0, padding)), mode="edge"))
        bases.append(np.pad(part.basis, ((0, 0), (0, 0), (0, padding))))
    return SlopeTables(
        np.ascontiguousarray(np.concatenate(nodes), np.int32),
        np.ascontiguousarray(np.concatenate(bases)),
        np.concatenate([part.plane for part in parts]),
        np.concatenate([part.rest for part in parts]),
        np.concatenate([part.stiffness for part in parts]),
        NUDGE * np.concatenate([part.sides[0].width for part in parts]),
    )


def _side(net: Net, piece: Piece, edge: str, turned: bool) -> _Side:
    """Return the Gauss points along an edge of a piece; reversed, with their tangent, if `turned`.

    Each element has as many as its degree along the edge, plus one.
    """
    along, across = (1, 0) if edge[0] == "u" else (0, 1)
    rule = gauss(piece.degrees[along] + 1)
    spans = elements_of(piece.knots[along])
    spans = spans[::-1] if turned else spans
    size = np.diff(spans, axis=1)
    fractions = 1.0 - rule.points if turned else rule.points
    parameters = (spans[:, :1] + size * fractions).ravel()
    weights = (size * rule.weights).ravel()
    full = on_net(piece, edge_parameters(piece, edge, parameters))
    p, q = piece.degrees
    # Only the first two rows of control points affect S_u and S_v at the edge.
    columns = rows_from(np.arange((p + 1) * (q + 1)).reshape(p + 1, q + 1), edge)[:2].ravel()
    at = BasisAt(full.control[:, columns], full.values[:, :, columns])
    a, b = at.of(U, net.points), at.of(V, net.points)
    normal = np.cross(a, b)
    tangent, transverse = (b, a) if along == 1 else (a, b)
    spans_across = elements_of(piece.knots[across])
    span = spans_across[0 if edge[1] == "0" else -1]
    outward = np.cross(normal, tangent)
    return _Side(
        at,
        at.values[:, (U, V)[along]] * (-1.0 if turned else 1.0),
        normal / lengths(normal)[:, None],
        outward / lengths(outward)[:, None],
        (span[1] - span[0]) * lengths(transverse),
        weights * lengths(tangent),
    )


class _Springs(NamedTuple):
    """Columns of `SlopeTables` at the points of one joint or plane, and its sides."""

    sides: tuple[_Side, ...]
    basis: FloatArray
    plane: FloatArray
    rest: FloatArray
    stiffness: FloatArray


def _springs_at_joint(net: Net, side_1: _Side, side_2: _Side, bending: Bending) -> _Springs:
    """Return springs that hold the angle between the normals of the two sides of a joint.

    Their points are the Gauss points of the sides, paired in order.
    """
    tangent = (side_1.tangent_basis[:, :, None] * net.points[side_1.at.control]).sum(axis=1)
    tangent /= lengths(tangent)[:, None]
    cosine = np.sum(side_1.normal * side_2.normal, axis=1)
    sine = np.sum(tangent * np.cross(side_1.normal, side_2.normal), axis=1)
    rest = np.stack([cosine, sine], axis=1)
    rest /= lengths(rest)[:, None]
    k, c = side_1.tangent_basis.shape
    basis = np.zeros((k, 5, c + side_2.tangent_basis.shape[1]))
    basis[:, :2, :c] = side_1.at.values[:, [U, V]]
    basis[:, 2:4, c:] = side_2.at.values[:, [U, V]]
    basis[:, 4, :c] = side_1.tangent_basis
    stiffness = side_1.length * bending.over(0.5 * (side_1.width + side_2.width))
    return _Springs((side_1, side_2), basis, np.zeros((k, 3)), rest, stiffness)
