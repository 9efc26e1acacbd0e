"""Solids as OpenCASCADE makes them, each with its closed form and, where one is known, its volume.

A piece stands where it is made; `placed` turns, moves and scales all that is known of it at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from tests.stress import fields, parts


class Piece(NamedTuple):
    """A shape of OpenCASCADE and what is known of it without OpenCASCADE."""

    shape: Any
    field: fields.Field | None
    """Negative inside and never more than the distance to the surface; None if not known."""
    volume: float | None = None
    """None if no closed form is known."""


def box(low: Sequence[float], high: Sequence[float]) -> Piece:
    """A box by its corners."""
    low, high = tuple(map(float, low)), tuple(map(float, high))
    sides = np.subtract(high, low)
    return Piece(parts.solid_box(low, high), fields.box(low, high), float(sides.prod()))


def rod(
    axis: int, radius: float, low: Sequence[float], length: float, seam: float | None = None
) -> Piece:
    """A cylinder along x, y or z that begins at `low`; its seam at the angle `seam`, rad."""
    low = tuple(map(float, low))
    others = [low[k] for k in range(3) if k != axis]
    field = fields.common(
        fields.tube(axis, radius, others), fields.between(axis, low[axis], low[axis] + length)
    )
    shape = parts.solid_tube(axis, radius, low, length)
    if seam is not None:
        shape = parts.turned(shape, low, axis, seam)
    return Piece(shape, field, math.pi * radius**2 * length)


def ball(centre: Sequence[float], radius: float) -> Piece:
    """A ball."""
    centre = tuple(map(float, centre))
    volume = 4.0 / 3.0 * math.pi * radius**3
    return Piece(parts.solid_ball(centre, radius), fields.ball(centre, radius), volume)


def cone(centre: Sequence[float], radii: tuple[float, float], height: float) -> Piece:
    """A cone or frustum about z: radii at its base, which stands on `centre`, and at its top."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    centre = tuple(map(float, centre))
    one, two = radii
    axes = gp_Ax2(gp_Pnt(*centre), gp_Dir(0.0, 0.0, 1.0))
    slant = math.hypot(one - two, height)

    def field(p: np.ndarray) -> np.ndarray:
        q = p - np.asarray(centre)
        side = ((fields.norm(q[:, :2]) - one) * height + q[:, 2] * (one - two)) / slant
        return np.maximum(side, np.maximum(-q[:, 2], q[:, 2] - height))

    volume = math.pi * height * (one * one + one * two + two * two) / 3.0
    return Piece(BRepPrimAPI_MakeCone(axes, one, two, height).Shape(), field, volume)


def torus(centre: Sequence[float], major: float, minor: float) -> Piece:
    """A ring about z."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    centre = tuple(map(float, centre))
    axes = gp_Ax2(gp_Pnt(*centre), gp_Dir(0.0, 0.0, 1.0))
    field = fields.scaled(fields.torus(major, minor), 1.0, centre)
    volume = 2.0 * math.pi**2 * major * minor**2
    return Piece(BRepPrimAPI_MakeTorus(axes, major, minor).Shape(), field, volume)


def wedge(sides: Sequence[float], top: tuple[float, float, float, float]) -> Piece:
    """A wedge: `sides` (x, y, z) from the origin; at y's end x and z go from, to as `top` says.

    `top` is (x from, z from, x to, z to), within the sides.
    """
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeWedge

    dx, dy, dz = map(float, sides)
    x0, z0, x1, z1 = map(float, top)
    # Half-spaces n · p ≤ d.
    planes = [((0.0, -1.0, 0.0), 0.0), ((0.0, 1.0, 0.0), dy)]
    planes += [((-dy, x0, 0.0), 0.0), ((dy, dx - x1, 0.0), dx * dy)]
    planes += [((0.0, z0, -dy), 0.0), ((0.0, dz - z1, dy), dz * dy)]
    middle = 0.25 * (dx + x1 - x0) * (dz + z1 - z0)
    volume = dy / 6.0 * (dx * dz + 4.0 * middle + (x1 - x0) * (z1 - z0))
    maker = BRepPrimAPI_MakeWedge(dx, dy, dz, x0, z0, x1, z1)
    return Piece(maker.Shape(), convex(planes), volume)


def convex(planes: Sequence[tuple[Sequence[float], float]]) -> fields.Field:
    """What lies in all half-spaces n · p ≤ d."""
    normal = np.array([plane[0] for plane in planes], float)
    offset = np.array([plane[1] for plane in planes], float)
    length = fields.norm(normal)
    normal, offset = normal / length[:, None], offset / length
    return lambda p: (p @ normal.T - offset).max(axis=1)


def prism(loops: Sequence[Sequence[fields.Piece]], low: float, high: float) -> Piece:
    """A profile in (x, y), its first loop the outer one, given the extent low … high in z."""
    return Piece(parts.prism(loops, low, high), fields.extruded(loops, low, high))


def fused(*pieces: Piece, volume: float | None = None) -> Piece:
    """The union; `volume` if known, of pieces that do not overlap `summed`."""
    return Piece(parts.fused(*(piece.shape for piece in pieces)), union_field(pieces), volume)


def cut(piece: Piece, *tools: Piece, volume: float | None = None) -> Piece:
    """`piece` without the tools."""
    known = piece.field is not None and all(tool.field is not None for tool in tools)
    field = fields.minus(piece.field, *(tool.field for tool in tools)) if known else None
    return Piece(parts.cut(piece.shape, *(tool.shape for tool in tools)), field, volume)


def common(piece: Piece, other: Piece, volume: float | None = None) -> Piece:
    """What lies in both."""
    known = piece.field is not None and other.field is not None
    field = fields.common(piece.field, other.field) if known else None
    return Piece(parts.common_part(piece.shape, other.shape), field, volume)


def together(*pieces: Piece, volume: float | None = None) -> Piece:
    """A compound of pieces as they are: solids of an assembly."""
    return Piece(parts.compound([piece.shape for piece in pieces]), union_field(pieces), volume)


def union_field(pieces: Sequence[Piece]) -> fields.Field | None:
    """Of the union of pieces."""
    some = [piece.field for piece in pieces if piece.field is not None]
    return fields.union(*some) if len(some) == len(pieces) else None


def summed(*pieces: Piece) -> float:
    """Volume of pieces that do not overlap, in closed form."""
    volumes = [piece.volume for piece in pieces]
    assert None not in volumes
    return math.fsum(volumes)


def placed(piece: Piece, turn: np.ndarray, shift: Sequence[float], factor: float = 1.0) -> Piece:
    """A piece made `factor` times as large, turned by a rotation matrix, then moved."""
    shift = np.asarray(shift, float)
    given = piece.field
    field = None
    if given is not None:
        field = lambda p: factor * given((p - shift) @ turn / factor)  # noqa: E731
    volume = None if piece.volume is None else factor**3 * piece.volume
    return Piece(parts.placed(piece.shape, factor * turn, shift), field, volume)
