"""A slave with a `geometry`: a surface of splines, or its triangles."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Self, cast

from pydantic import Field, model_validator

from contiga.case.geometry_spec import GeometrySpec, MeshGeometry
from contiga.case.points_spec import Sampling
from contiga.case.spec import Count, Positive, Spec
from contiga.errors import CaseError
from contiga.masters.body import Body
from contiga.slaves.slave import Slave
from contiga.slaves.surfaces import Refinement, patches_of, refined


class RefineSpec(Spec):
    """`refine = { degree, elements | size }` of the patches of a slave."""

    degree: Annotated[int, Field(ge=1, le=5)] = 2
    """Degree; lower ones are raised to it."""
    elements: Annotated[list[Count], Field(min_length=2, max_length=2)] | None = None
    """Number of equal spans of each patch in u and v, in addition to its own knots."""
    size: Positive | None = None
    """Largest length of an element; a tenth of the size of the surface if omitted."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.elements is not None and self.size is not None:
            raise CaseError(
                "says twice how long elements are",
                where="size",
                found=self.size,
                allowed="elements = [n, m], or size",
            )
        return self

    @property
    def instance(self) -> Refinement:
        """The refinement of the patches."""
        elements = None if self.elements is None else (self.elements[0], self.elements[1])
        return Refinement(self.degree, elements, self.size)

    def describe(self) -> str:
        """Describe the table in words."""
        if self.elements is not None:
            return f"degree {self.degree}, {self.elements[0]} × {self.elements[1]} elements a patch"
        size = "a tenth of its size" if self.size is None else f"{self.size:g}"
        return f"degree {self.degree}, elements of {size} at most"


def check_surface(geometry: GeometrySpec, refine: RefineSpec | None, mesh: Sampling | None) -> None:
    """Refuse a mesh as the geometry of a slave, and `refine` beside `mesh`."""
    if isinstance(geometry, MeshGeometry):
        raise CaseError(
            "is no surface of splines",
            where="geometry.mesh",
            found=geometry.mesh,
            remedy="Write points = { file = … }: nodes and elements of a mesh",
        )
    if refine is not None and mesh is not None:
        raise CaseError(
            "is for surfaces of splines, and mesh makes triangles",
            where="refine",
            found="both",
            allowed="one of them",
        )


def surface_of(geometry: GeometrySpec, refine: RefineSpec, names: tuple[str, str]) -> Slave:
    """Return the slave on the patches of a geometry; `names` are its name and unit of length."""
    body = cast(Body, geometry.body(*names))  # a mesh has been refused before
    return Slave(surfaces=refined(patches_of(body), refine.instance), name=names[0], unit=names[1])


def meshed_of(
    geometry: GeometrySpec, mesh: Sampling, names: tuple[str, str], master_sizes: Iterable[float]
) -> Slave:
    """Return the slave of triangles on a geometry; `names` are its name and unit of length.

    Raises
    ------
    CaseError
        As `Sampling.mesh_of`.
    """
    triangles = mesh.mesh_of(geometry.body(*names), master_sizes)
    return Slave(triangles.vertices, triangles.triangles, name=names[0], unit=names[1])
