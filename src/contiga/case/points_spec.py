"""The `points` tables of a case: where a slave's points come from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.geometry_spec import _ShapeSpec
from contiga.case.placed_spec import Placed
from contiga.case.spec import (
    Count,
    DiscriminatedBy,
    ExistingFile,
    LengthUnit,
    Name,
    Pair,
    Parts,
    Positive,
    Spec,
    Vector,
    listed_choice,
    numbers_in,
)
from contiga.errors import CaseError
from contiga.geometry import clouds
from contiga.geometry.body_mesh import fewest_triangles
from contiga.masters.protocol import Master
from contiga.masters.sampling import default_size, refined
from contiga.records import FloatArray
from contiga.slaves.slave import Slave
from contiga.triangles.trimesh import TriMesh

_MAX_TRIANGLES = 500_000
"""Largest number of triangles of a sampled body: its points are searched at every step."""
_MAX_TOLERANCE = 0.1
"""Largest departure of a body's triangles from it, as a share of its size."""
_MAX_TRIANGLE_AREA = 0.433
"""Area of an equilateral triangle, the largest possible, over the square of the longest side."""
_DEFAULT = "A thousandth of the size of the body is the default"
Corner = Annotated[int, Field(ge=2)]
PointCount = Annotated[int, Field(ge=1, le=clouds.MAX_CLOUD_POINTS)]
Seed = Annotated[int, Field(ge=0)]


class SideSpec(Spec):
    """`side = { direction, angle }`: facets whose normals are near a direction."""

    direction: Vector
    angle: Annotated[float, Field(gt=0.0, le=180.0)] = 60.0
    """Largest angle, degrees."""


class _Points(Placed):
    box: Pair | None = None
    """Two corners of a box; only placed points within it take part."""
    side: SideSpec | None = None
    """Selection of the placed facets that face a direction."""

    def slave(self, name: str, unit: str) -> Slave:
        """Return the slave, placed and selected, lengths in `unit`."""
        return self.transformed(self.raw(name, unit))

    def transformed(self, slave: Slave) -> Slave:
        """Return the slave moved by the transform; only what `box` and `side` select is active."""
        if self.transform:
            slave = slave.transformed(self.matrix)
        if self.box is None and self.side is None:
            return slave
        side = None if self.side is None else (self.side.direction, self.side.angle)
        return slave.selected(box=self.box, side=side)

    def describe_selection(self) -> str:
        """Describe the points and their selection."""
        selection = "" if self.box is None else f", in the box {self.box[0]} to {self.box[1]}"
        if self.side is not None:
            selection += f", within {self.side.angle:g}° of {self.side.direction}"
        return self.describe() + selection

    def describe(self) -> str:
        """Describe the points without their selection."""
        raise NotImplementedError

    def raw(self, name: str, unit: str) -> Slave:
        """Return the slave before it is placed."""
        raise NotImplementedError


class FilePoints(_Points):
    """`{ file, unit, parts, sets, layer }`; `unit` is its own, by default that of the case."""

    file: ExistingFile
    unit: LengthUnit | None = None
    parts: Parts | None = None
    """Parts, sets or groups of the file that take part; all if omitted."""
    sets: Parts | None = None
    """Sets of nodes; only facets with all corners in these sets take part."""
    layer: Literal["skin", "all"] | Count = "skin"
    """Nodes of solids that take part: the skin, a layer below it, or all."""

    def raw(self, name: str, unit: str) -> Slave:
        """Return the nodes of the file."""
        from contiga.io.mesh.read_mesh import read_mesh

        return read_mesh(
            self.file,
            unit=unit,
            file_unit=self.unit,
            parts=self.parts,
            sets=self.sets,
            layer=self.layer,
        )

    def describe(self) -> str:
        """Describe the table in words."""
        selection = listed_choice("parts", self.parts) + listed_choice("sets", self.sets)
        layer = "" if self.layer == "skin" else f", layer {self.layer}"
        return f"{self.file}{selection}{layer}, " + numbers_in(self.unit, "the case's unit")


class SampleValues(_ShapeSpec):
    """A shape and the numbers of points along u and v, borders included."""

    nu: Corner
    nv: Corner

    @model_validator(mode="after")
    def _points_can_be_made(self) -> Self:
        clouds.check_grid(self.nu, self.nv)
        return self

    def points(self) -> FloatArray:
        """Return the points (nu · nv, 3); v runs fastest."""
        return clouds.sample(self.make(), self.nu, self.nv)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{self.nu} × {self.nv} points on a {self.shape}"


class SamplePoints(_Points):
    """`{ sample = { shape …, nu, nv } }`: a cloud on a grid of parameters."""

    sample: SampleValues

    def raw(self, name: str, unit: str) -> Slave:
        """Return a cloud without facets."""
        return Slave(self.sample.points(), name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"a cloud of {self.sample.describe()}"


class GridPoints(_Points):
    """`{ grid = { shape …, nu, nv } }`: the same points joined by triangles."""

    grid: SampleValues

    def raw(self, name: str, unit: str) -> Slave:
        """Return a surface mesh: two triangles per cell, anticlockwise about S_u × S_v.

        Triangles without area at a pole are left out.
        """
        points, nu, nv = self.grid.points(), self.grid.nu, self.grid.nv
        index = np.arange(nu * nv, dtype=np.int32).reshape(nu, nv)
        a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
        c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
        facets = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        corners = points[facets]
        edges = corners[:, 1:] - corners[:, :1]
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        longest = np.square(edges).sum(axis=2).max(axis=1)
        facets = np.ascontiguousarray(facets[area > 1e-12 * longest])
        return Slave(points, facets, name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"a mesh of {self.grid.describe()}"


class RandomOnShape(_ShapeSpec):
    """Random points on a shape, uniform in its area."""

    n: PointCount
    seed: Seed = 0

    def points(self) -> FloatArray:
        """Return the points (n, 3)."""
        return clouds.random_on(self.make(), self.n, seed=self.seed)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{self.n} random points on a {self.shape}"


class RandomInBox(Spec):
    """Random points in the box between two corners."""

    box: Pair
    n: PointCount
    seed: Seed = 0

    @model_validator(mode="after")
    def _box_is_possible(self) -> Self:
        clouds.random_in_box(self.box[0], self.box[1], 0)
        return self

    def points(self) -> FloatArray:
        """Return the points (n, 3)."""
        return clouds.random_in_box(self.box[0], self.box[1], self.n, seed=self.seed)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{self.n} random points in the box {self.box[0]} to {self.box[1]}"


RandomValues = Annotated[RandomOnShape | RandomInBox, DiscriminatedBy("shape", "box")]


class RandomPoints(_Points):
    """`{ random = { shape … or box, n, seed } }`."""

    random: RandomValues

    def raw(self, name: str, unit: str) -> Slave:
        """Return a cloud without facets."""
        return Slave(self.random.points(), name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        return self.random.describe()


class GivenPoints(_Points):
    """`{ coordinates = [[x, y, z], …], segments }`: a cloud, or the path of a belt."""

    coordinates: Annotated[list[Vector], Field(min_length=1)]
    segments: PointCount | None = None
    """Total number of bars that join them in turn; each leg has at least one."""

    @model_validator(mode="after")
    def _legs_have_a_length(self) -> Self:
        if self.segments is not None:
            legs = np.diff(np.array(self.coordinates), axis=0)
            if len(legs) == 0 or not legs.any(axis=1).all():
                raise CaseError(
                    "bars need two points or more, none twice in a row",
                    where="coordinates",
                    found=self.coordinates,
                )
        return self

    def raw(self, name: str, unit: str) -> Slave:
        """Return a cloud without facets, joined by bars if there are segments."""
        if self.segments is None:
            return Slave(self.coordinates, name=name, unit=unit)
        points = _subdivided(np.array(self.coordinates), self.segments)
        rows = np.arange(len(points), dtype=np.int32)
        lines = np.stack([rows[:-1], rows[1:]], axis=1)
        return Slave(points, name=name, unit=unit, elements={"line": lines})

    def describe(self) -> str:
        """Describe the table in words."""
        points = f"{len(self.coordinates)} given points"
        if self.segments is None:
            return points
        bars = len(_subdivided(np.array(self.coordinates), self.segments)) - 1
        return f"{points}, joined by {bars} bars"


class Sampling(Spec):
    """`{ tolerance, size }`: the triangulation of an exact surface."""

    tolerance: Positive | None = None
    """Largest distance of the triangles from the surface; a thousandth of its size if omitted."""
    size: Positive | None = None
    """Longest side of the triangles; `contiga.masters.sampling.default_size` if omitted."""

    def mesh_of(self, body: Master, master_sizes: Iterable[float] = ()) -> TriMesh:
        """Return triangles of a body; `master_sizes` are the sizes of bodies that it will touch.

        Triangles within the tolerance, by default 1e-3 of the size of the body, are divided until
        no side is longer than `size`, by default that of `default_size`.

        Raises
        ------
        CaseError
            Tolerance or size need more than 500 000 triangles, or the tolerance is above a tenth of
            the size of the body.
        """
        tolerance = 1e-3 * body.size if self.tolerance is None else self.tolerance
        if tolerance > _MAX_TOLERANCE * body.size:
            raise CaseError(
                f"is {tolerance / body.size:.2g} times the size of the body, which it would leave "
                "little of",
                where="tolerance",
                found=tolerance,
                allowed=f"up to {_MAX_TOLERANCE * body.size:.4g}",
                remedy=_DEFAULT,
            )
        if self.tolerance is not None and body.faces is not None:
            _check_triangle_count(
                "tolerance", tolerance, fewest_triangles(body.faces, tolerance), 1
            )
        mesh = body.tessellate(tolerance)
        if self.tolerance is not None and body.faces is not None:
            _check_triangle_count("tolerance", tolerance, len(mesh.triangles), 1)
        if self.size is not None:
            _check_triangle_count(
                "size", self.size, mesh.area() / (_MAX_TRIANGLE_AREA * self.size**2), 2
            )
        size = default_size(body, mesh, master_sizes) if self.size is None else self.size
        return refined(body, mesh, size)

    def describe_mesh(self) -> str:
        """Describe the triangulation."""
        tolerance = "a thousandth of its size" if self.tolerance is None else f"{self.tolerance:g}"
        size = "" if self.size is None else f", no side longer than {self.size:g}"
        return f"sampled to {tolerance}{size}"


class BodyPoints(_Points, Sampling):
    """`{ body, tolerance, size }`: the surface of a body of the case, sampled by triangles.

    Two bodies can touch in this way: one exact, one sampled. A slave of such points moves with its
    body if it has no motion of its own.
    """

    body: Name

    def sampled(self, body: Master, master_sizes: Iterable[float] = ()) -> Slave:
        """Return points and triangles of the placed body, moved by the transform.

        `master_sizes` are the sizes of the bodies that it will touch.

        Raises
        ------
        CaseError
            As `mesh_of`.
        """
        mesh = self.mesh_of(body, master_sizes)
        return self.transformed(Slave(mesh.vertices, mesh.triangles))

    def describe(self) -> str:
        """Describe the table in words."""
        return f"the surface of {self.body}, {self.describe_mesh()}"


PointsSpec = Annotated[
    FilePoints | SamplePoints | GridPoints | RandomPoints | GivenPoints | BodyPoints,
    DiscriminatedBy("file", "sample", "grid", "random", "coordinates", "body"),
]


def _subdivided(corners: FloatArray, segments: int) -> FloatArray:
    """Return the points of a polyline, subdivided into `segments` pieces, one a leg at least.

    Legs get pieces in proportion to their lengths, each rounded so that the sum stays right; a leg
    that would have none gets one in addition.
    """
    legs = np.diff(corners, axis=0)
    lengths = np.sqrt((legs * legs).sum(axis=1))
    ends = np.round(segments * np.cumsum(lengths) / lengths.sum()).astype(int)
    counts = np.maximum(np.diff(ends, prepend=0), 1)
    points = [
        start + np.linspace(0.0, 1.0, n, endpoint=False)[:, None] * leg
        for start, leg, n in zip(corners, legs, counts, strict=False)
    ]
    return np.concatenate([*points, corners[-1:]])


def _check_triangle_count(key: str, value: float, triangles: float, power: int) -> None:
    """Refuse a value that needs more than 500 000 triangles.

    Their number falls with the `power` of it, which gives the smallest value for the message.
    """
    if triangles > _MAX_TRIANGLES:
        lower_bound = value * (triangles / _MAX_TRIANGLES) ** (1.0 / power)
        raise CaseError(
            f"takes about {triangles:.2g} triangles or more",
            where=key,
            found=value,
            allowed=f"{lower_bound:.2g} or more: all their points are searched for at every step",
            remedy=_DEFAULT if key == "tolerance" else "Without it sides are as the bodies need",
        )
