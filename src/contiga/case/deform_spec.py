"""`motion = { kind = "deform" }` of a slave: its materials, supports and loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.material_spec import MaterialSpec
from contiga.case.nodal_spec import (
    AttachedSpec,
    DrivenSpec,
    HeldSpec,
    MassesSpec,
    NodalLoadSpec,
    NodesOf,
)
from contiga.case.rigid_spec import PrescribedMotionSpec
from contiga.case.spec import (
    ExistingFile,
    LengthUnit,
    MotionSpec,
    NotNegative,
    Positive,
    Spec,
    Vector,
)
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.prescribed import BodyMotion
from contiga.errors import CaseError
from contiga.matter.parts import DIMENSION, Part
from contiga.records import FloatArray, IntArray
from contiga.slaves.slave import Slave

ElementsOf = Callable[[str | int], Mapping[str, IntArray]]
"""Elements by kind of the set with a name or number."""


class _ElementProperties(Spec):
    """Material and section of elements."""

    material: MaterialSpec | None = None
    density: Positive | None = None
    """Mass over volume."""
    thickness: Positive | None = None
    """Thickness of membranes; the thickness of the slave if omitted."""
    section: Positive | None = None
    """Area of the section of bars."""
    hourglass: Positive = 1.0
    """Stiffness of the hourglass modes of hexahedra, those with no mean strain."""
    bulk_viscosity: Annotated[list[NotNegative], Field(min_length=2, max_length=2)] = Field(
        default_factory=lambda: [0.0, 0.0]
    )
    """Linear and quadratic coefficient of solids."""

    @property
    def _viscosity(self) -> tuple[float, float]:
        linear, quadratic = self.bulk_viscosity
        return linear, quadratic


class PartSpec(_ElementProperties):
    """A table of `parts`: `set`, `material`, `density` and other properties of its elements."""

    set: str | int
    """Part, set or group of the mesh file; a set of nodes means the cells with all nodes in it."""
    material: MaterialSpec
    density: Positive

    def parts_of(self, elements_of: ElementsOf, thickness: float | None) -> list[Part]:
        """Return a part for each kind of elements in its set.

        Membranes have its thickness, else `thickness`; bars its section, solids its viscosity.
        """
        parts = []
        for kind, elements in elements_of(self.set).items():
            dimension = DIMENSION[kind]
            part = Part(
                kind=kind,
                elements=elements,
                material=self.material.instance,
                density=self.density,
                thickness=(self.thickness or thickness) if dimension == 2 else None,
                section=self.section if dimension == 1 else None,
                hourglass=self.hourglass,
                bulk_viscosity=self._viscosity if dimension == 3 else (0.0, 0.0),
                name=f"parts {self.set!r}: {kind}",
            )
            parts.append(part)
        return parts

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{self.set}: {self.material.describe()}, density {self.density:g}"


class ReferenceSpec(Spec):
    """`reference = { file, unit }` or `{ scale }`: the shape in which no element is strained.

    A mesh with the nodes and elements of the slave, or the slave itself scaled.
    """

    file: ExistingFile | None = None
    unit: LengthUnit | None = None
    """Unit of the file; by default the unit of the slave's mesh, or of the case."""
    scale: Positive | Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = None
    """Scale relative to the slave as placed: one factor, or factors along x, y and z."""

    @model_validator(mode="after")
    def _one_mesh(self) -> Self:
        if (self.file is None) == (self.scale is None):
            raise CaseError(
                "must have exactly one of the keys file, scale",
                allowed='{ file = "flat.vtu" }, { scale = 0.98 } or { scale = [1, 1, 0.5] }',
            )
        return self

    def nodes(self, slave: Slave, mesh_of: Callable[[str, str | None], Slave]) -> FloatArray:
        """Return the reference nodes (n, 3) of a slave.

        `mesh_of` reads a file as the slave's own was read.

        Raises
        ------
        CaseError
            The file has another number of nodes, or other elements.
        """
        if self.scale is not None:
            return slave.points * np.broadcast_to(self.scale, 3)
        assert self.file is not None
        mesh = mesh_of(self.file, self.unit)
        if len(mesh) != len(slave):
            raise CaseError(
                "must have the nodes of the slave",
                where="reference.file",
                found=f"{len(mesh)} nodes in {self.file}",
                allowed=f"{len(slave)}, in the same order",
            )
        elements, elements_of_file = (dict(part.elements) for part in (slave, mesh))
        for kinds, part in ((elements, slave), (elements_of_file, mesh)):
            if part.facets is not None:
                kinds["facets"] = part.facets
        for kind in {**elements, **elements_of_file}:
            rows, rows_of_file = elements.get(kind), elements_of_file.get(kind)
            if rows is None or rows_of_file is None or not np.array_equal(rows, rows_of_file):
                raise CaseError(
                    "must have the elements of the slave, with the same nodes",
                    where="reference.file",
                    found=f"other {kind} in {self.file}",
                    allowed="the mesh of the slave with its nodes moved",
                )
        return mesh.points

    def describe(self) -> str:
        """Describe the table in words."""
        return f"of size {self.scale}" if self.file is None else f"as in {self.file}"


class DeformSpec(_ElementProperties, MotionSpec):
    """`{ kind = "deform", material, density, parts, fixed, driven, attached, … }`: elements.

    `parts`, `fixed`, `driven`, `attached`, `masses` and `loads` are tables, or lists of them.
    """

    by_forces = True
    kind: Literal["deform"] = "deform"
    parts: list[PartSpec] = Field(default_factory=list)
    """Elements with other materials or sections."""
    fixed: list[HeldSpec] = Field(default_factory=list)
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Initial velocity of all nodes that are not held."""
    bending: NotNegative = 1.0
    """Share of a solid sheet's bending stiffness that a shell of splines has; 0 is a membrane."""
    damping: NotNegative = 0.0
    """Coefficient α of a force −α m v on each node, 1 / time."""
    driven: list[DrivenSpec] = Field(default_factory=list)
    attached: list[AttachedSpec] = Field(default_factory=list)
    masses: list[MassesSpec] = Field(default_factory=list)
    """Lumped masses on nodes, in addition to the masses of the elements."""
    loads: list[NodalLoadSpec] = Field(default_factory=list)
    reference: ReferenceSpec | None = None
    """Mesh on which no element is strained; the slave's own if omitted."""
    mass_scaling: Positive | None = None
    """Lower bound of the critical step of the elements at rest, time."""

    @model_validator(mode="before")
    @classmethod
    def _one_table_is_a_list(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        keys = ("parts", "fixed", "driven", "attached", "masses", "loads")
        return data | {key: [data[key]] for key in keys if isinstance(data.get(key), dict)}

    @model_validator(mode="after")
    def _made_of_something(self) -> Self:
        if self.parts and self.material is None:
            return self
        for key in ("material", "density"):
            if getattr(self, key) is None:
                raise CaseError(
                    "is missing: elements need it",
                    where=key,
                    allowed="that of all elements, or of those that are in none of the `parts`",
                )
        return self

    def named_bodies(self) -> Iterator[tuple[str, str]]:
        """Yield the keys that name bodies that carry nodes, and the names."""
        for k, table in enumerate(self.attached):
            yield f"attached[{k}].body", table.body

    def moved(
        self,
        nodes_of: NodesOf,
        motion_of: Callable[[PrescribedMotionSpec], BodyMotion],
        elements_of: ElementsOf,
        reference_nodes: FloatArray | None,
    ) -> Deforming:
        """Return the motion, with its selections of nodes and elements looked up in the mesh.

        `motion_of` returns motions in the units of the case, `reference_nodes` (n, 3) are the nodes
        of the `reference`. Whether all of it fits a slave is not checked.
        """
        return Deforming(
            material=None if self.material is None else self.material.instance,
            density=self.density,
            thickness=self.thickness,
            bending=self.bending,
            section=self.section,
            hourglass=self.hourglass,
            bulk_viscosity=self._viscosity,
            parts=[
                part for spec in self.parts for part in spec.parts_of(elements_of, self.thickness)
            ],
            fixed=[spec.table(nodes_of) for spec in self.fixed] or None,
            velocity=self.velocity,
            damping=self.damping,
            driven=[
                spec.table(nodes_of) | {"motion": motion_of(spec.motion)} for spec in self.driven
            ],
            attached=[spec.table(nodes_of) for spec in self.attached],
            masses=[spec.table(nodes_of) for spec in self.masses],
            loads=[spec.load(nodes_of) for spec in self.loads],
            rest=reference_nodes,
            mass_scaling=self.mass_scaling,
        )

    def describe(self) -> str:
        """Describe the table in words."""
        materials = [spec.describe() for spec in self.parts]
        if self.material is not None:
            materials.insert(0, f"{self.material.describe()}, density {self.density:g}")
        places = "1 place" if len(self.fixed) == 1 else f"{len(self.fixed)} places"
        supports = f", nodes fixed at {places}" if self.fixed else ""
        supports += "".join(f", {spec.describe()}" for spec in self.driven)
        supports += "".join(f", nodes attached to {spec.body}" for spec in self.attached)
        loads = "".join(f", {spec.describe()}" for spec in self.masses)
        loads += "".join(f", {spec.describe()}" for spec in self.loads)
        if self.reference is not None:
            loads += f", without strain {self.reference.describe()}"
        if self.mass_scaling is not None:
            loads += f", masses scaled for steps of {self.mass_scaling:g}"
        start = f", velocity {self.velocity} at the start" if any(self.velocity) else ""
        return f"deforms, {'; '.join(materials)}{supports}{loads}{start}"
