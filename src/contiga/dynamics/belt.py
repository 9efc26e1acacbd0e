"""A belt laid along a routed path: its nodes, elements, rest lengths and anchors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from contiga.arrays.layout import one_of, positive
from contiga.dynamics.deforming import Deforming
from contiga.errors import InputError
from contiga.matter.coefficients import Material
from contiga.records import FloatArray, IntArray
from contiga.routing.path import Path
from contiga.slaves.slave import Slave

KINDS = ("bars", "ribbon")
LIFT = 1e-7
"""Share of its length that a belt is laid above a surface, for its nodes to enter it."""
GROUND, FREE = "ground", "free"
"""Anchors that are no body."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Belt:
    """A belt along a `Path`: bars, or a ribbon of membranes whose width is tangent to the bodies.

    The nodes of the belt are evenly spaced along the path. A ribbon at rest lies flat, along x,
    with its width along y: the warp of a `Fabric` along the belt is ``direction=[1, 0, 0]``.

    Parameters
    ----------
    path : from `contiga.route`
    material : of bars `contiga.materials.Belt` or `Elastic`, of a ribbon `Fabric`, `Elastic` or
        another of membranes
    density : mass over volume
    width, thickness : length; of bars their product is the section
    kind : "bars" or "ribbon"
    segments : elements along the belt
    across : elements across a ribbon
    shortening : share of its length that the belt is shorter at rest than the path: its strain at
        the start is shortening/(1 − shortening)
    anchors : what holds its start and its end: "ground", the name of a body, or "free", for springs
        that end there
    damping : α of a force −α m v on each node, 1/time
    name : what messages and results call it

    Raises
    ------
    InputError
        A width, thickness or density that is not positive, fewer than one element, a shortening
        outside 0 to 1, an unknown kind.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
    >>> path = cg.route(ball, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], via=[[0.0, 0.0, 1.5]])
    >>> webbing = cg.materials.Belt(loading=100.0)
    >>> belt = cg.Belt(
    ...     path=path, material=webbing, density=1.0, width=0.2, thickness=0.01, segments=40
    ... )
    >>> len(belt.slave), belt.ends[1].tolist()
    (41, [40])
    """

    path: Path
    material: Material
    density: float
    width: float
    thickness: float
    kind: str = "bars"
    segments: int = 40
    across: int = 4
    shortening: float = 0.0
    anchors: tuple[str, str] = (GROUND, GROUND)
    damping: float = 0.0
    name: str = "belt"

    def __post_init__(self) -> None:
        one_of("kind", self.kind, KINDS)
        for key in ("density", "width", "thickness"):
            positive(getattr(self, key), key)
        for key in ("segments", "across"):
            if not (isinstance(getattr(self, key), int) and getattr(self, key) >= 1):
                raise InputError(
                    "must be a whole number", where=key, found=getattr(self, key), allowed="≥ 1"
                )
        if not 0.0 <= self.shortening < 1.0:
            raise InputError(
                "is a share of the length", where="shortening", found=self.shortening,
                allowed="0 up to, not including, 1",
            )  # fmt: skip

    @cached_property
    def slave(self) -> Slave:
        """The nodes of the belt, row by row across it, where the path lies."""
        points, rows = self._points, self._rows
        if self.kind == "bars":
            share = np.full(len(points), self.path.length / self.segments)
            share[[0, -1]] *= 0.5
            lines = np.stack([rows[:-1, 0], rows[1:, 0]], axis=1)
            return Slave(
                points, area=self.width * share, thickness=self.thickness, name=self.name,
                elements={"line": lines},
            )  # fmt: skip
        a, b, c, d = rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]
        # Diagonals cross, so that the ribbon is no stiffer towards one side.
        odd = (np.indices(a.shape).sum(axis=0) % 2 == 1)[..., None, None]
        one = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=-2)
        other = np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], axis=-2)
        facets = np.where(odd, one, other).reshape(-1, 3)
        return Slave(points, facets, thickness=self.thickness, name=self.name)

    @cached_property
    def motion(self) -> Deforming:
        """How the belt moves: by the forces of its elements."""
        ends = [(anchor, rows) for anchor, rows in zip(self.anchors, self.ends, strict=True)]
        fixed: list[dict[str, Any]] = [{"nodes": rows} for at, rows in ends if at == GROUND]
        carried = [{"nodes": rows, "body": at} for at, rows in ends if at not in (GROUND, FREE)]
        is_bars = self.kind == "bars"
        return Deforming(
            material=self.material,
            density=self.density,
            section=self.width * self.thickness if is_bars else None,
            thickness=None if is_bars else self.thickness,
            fixed=fixed or None,
            attached=carried or None,
            damping=self.damping,
            rest=self._rest,
        )

    @property
    def ends(self) -> tuple[IntArray, IntArray]:
        """Nodes of its start and of its end."""
        return self._rows[0], self._rows[-1]

    @property
    def rest_length(self) -> float:
        """Length of the belt without force."""
        return (1.0 - self.shortening) * self.path.length

    @cached_property
    def _rows(self) -> IntArray:
        """(segments + 1, nodes across) numbers of the nodes."""
        wide = 1 if self.kind == "bars" else self.across + 1
        count = (self.segments + 1) * wide
        return np.arange(count, dtype=np.int32).reshape(-1, wide)

    @cached_property
    def _offsets(self) -> FloatArray:
        """(nodes across,) from the middle of the belt."""
        if self.kind == "bars":
            return np.zeros(1)
        return np.linspace(-0.5 * self.width, 0.5 * self.width, self.across + 1)

    @cached_property
    def _points(self) -> FloatArray:
        """(n, 3) nodes on the path and beside it."""
        arc = np.linspace(0.0, self.path.length, self.segments + 1)
        normal, step = self.path.normal_at(arc), 0.5 * arc[1]
        middle = self.path.at(arc)
        ahead, behind = (np.clip(arc + x, 0.0, self.path.length) for x in (step, -step))
        along = self.path.at(ahead) - self.path.at(behind)
        # Width and normal in this order: facets face away from the bodies.
        wide = np.cross(normal, along)
        sizes = np.linalg.norm(wide, axis=1)
        if self.kind == "ribbon" and not (sizes > 1e-6 * step).all():
            raise InputError(
                "a ribbon cannot be laid straight towards a body",
                where=f"{self.name}: path",
                found=middle[int(np.argmin(sizes))].tolist(),
                allowed="a path that passes beside the nearest body",
                remedy="Move the end aside, or lay it as bars",
            )
        wide /= np.maximum(sizes, 1e-300)[:, None]
        points = middle[:, None] + self._offsets[None, :, None] * wide[:, None]
        return self.path.outside(points.reshape(-1, 3), LIFT * self.path.length)

    @cached_property
    def _rest(self) -> FloatArray:
        """(n, 3) nodes without strain: flat, along x.

        Between two nodes the belt is as long as their distance, a chord's, less the shortening.
        """
        middle = self._points.reshape(self.segments + 1, -1, 3)
        chords = np.linalg.norm(np.diff(middle.mean(axis=1), axis=0), axis=1)
        x = (1.0 - self.shortening) * np.concatenate([[0.0], np.cumsum(chords)])
        rest = np.zeros((*self._rows.shape, 3))
        rest[:, :, 0], rest[:, :, 1] = x[:, None], self._offsets
        return rest.reshape(-1, 3)
