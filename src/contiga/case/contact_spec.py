"""The `contact` tables of a case: pairs of parts and their areas; `law_spec` has the laws."""

from __future__ import annotations

import sys
from typing import Annotated, Literal, Self

from pydantic import model_validator

from contiga.area.cloud import CloudArea
from contiga.area.facet import FacetArea
from contiga.area.hull import HullArea
from contiga.area.method import AreaMethod
from contiga.case.law_spec import FrictionSpec, LawSpec
from contiga.case.spec import BY_KIND, InstanceSpec, Name, Positive, Spec, is_number, must_be
from contiga.errors import CaseError
from contiga.slaves.sampling import QUADRATURES

QUADRATURE = 3
"""Points per facet of a contact of a deforming slave, by default."""


class ConstantAreaSpec(Spec):
    """`{ kind = "constant", value }`: every slave node has this contact area."""

    kind: Literal["constant"] = "constant"
    value: Positive

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{self.value:g} a node"


class TributaryAreaSpec(Spec):
    """`{ kind = "tributary" }`: a node's third of each facet it belongs to."""

    kind: Literal["tributary"] = "tributary"

    def describe(self) -> str:
        """Describe the table in words."""
        return "tributary"


class FacetAreaSpec(InstanceSpec[AreaMethod]):
    """`{ kind = "facet", on }`: `FacetArea`."""

    makes = FacetArea
    kind: Literal["facet"] = "facet"
    on: Literal["slave", "master"] | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        return "facets cut where contact ends" + (f", on the {self.on}" if self.on else "")


class CloudAreaSpec(InstanceSpec[AreaMethod]):
    """`{ kind = "cloud", on, bridge, by }`: `CloudArea`."""

    makes = CloudArea
    kind: Literal["cloud"] = "cloud"
    on: Literal["slave", "master"] | None = None
    bridge: Positive = 3.0
    by: Literal["rest", "feet"] = "rest"

    def describe(self) -> str:
        """Describe the table in words."""
        vertices = "the points at rest" if self.by == "rest" else "the feet on the master"
        return f"triangles between {vertices}, cut where contact ends"


class HullAreaSpec(InstanceSpec[AreaMethod]):
    """`{ kind = "hull", clusters, mapping, k, eps, min_points, tolerance }`: `HullArea`."""

    makes = HullArea
    kind: Literal["hull"] = "hull"
    clusters: Annotated[
        str | int,
        must_be(
            lambda value: isinstance(value, str | int) and not isinstance(value, bool),
            "must be a method or a number of clusters",
            '"auto", "kmeans", "dbscan", "meanshift", "hdbscan", or a whole number ≥ 1',
        ),
    ] = "auto"
    mapping: Literal["linear", "exact"] = "linear"
    k: int = 2
    eps: Positive = 0.1
    min_points: int = 4
    tolerance: Positive | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        return f"hulls of clusters ({self.clusters}), {self.mapping} map"


AreaSpec = Annotated[
    ConstantAreaSpec | TributaryAreaSpec | FacetAreaSpec | CloudAreaSpec | HullAreaSpec, BY_KIND
]


class ContactSpec(Spec):
    """A `[[contact]]`: a body and a slave that may touch."""

    master: str
    slave: str
    name: Name | None = None
    """Name of the contact in results; "<master>-<slave>" if omitted."""
    type: Literal["slave", "master", "combined"] | None = None
    """The deformable side; follows from `law` and the layers of the bodies if omitted."""
    search: Literal["intersection", "penetration"] = "intersection"
    on_edge: Literal["release", "hold"] = "release"
    through: Literal["release", "hold"] = "release"
    """Whether points that tunnelled are released, or held on the wall they came in by."""
    foot: Literal["nearest", "tracked"] = "nearest"
    """The wall that pushes: the nearest that is not opposite, or the one a point came in by."""
    depth: Positive | None = None
    """Deepest penetration that the search by penetration accepts; see `Contact`."""
    law: LawSpec | None = None
    """The law of the body's layer if omitted."""
    master_law: LawSpec | None = None
    """Law of the master's side of a combined contact."""
    friction: FrictionSpec | None = None
    """Law of friction; without it, points slide freely."""
    area: AreaSpec | None = None
    """Method by which contact areas are measured.

    By default facets are cut where contact ends, if the slave has facets and was given no areas;
    else areas are tributary. A cloud without areas must have a method.
    """
    weights: Literal["rest", "area"] = "rest"
    """Whether areas at rest weigh the force, or contact areas as they are measured."""
    quadrature: Annotated[
        str | int | None,
        must_be(
            lambda value: not isinstance(value, bool) and value in QUADRATURES,
            "unknown points of contact",
            ", ".join(map(repr, QUADRATURES)),
        ),
    ] = None
    """Points of contact: the slave's nodes, or a number on each facet.

    By default a deforming slave has `QUADRATURE` points on its facets, if it has some and if law,
    weights and areas can be on them.
    """
    shell_thickness: Annotated[
        bool | float,
        must_be(
            lambda value: (
                isinstance(value, bool) or (is_number(value) and 0.0 < value <= sys.float_info.max)
            ),
            "must be a thickness",
            "true, false, or a length > 0",
        ),
    ] = False
    """Thickness of the slave as a shell, half of which stands off its points.

    True takes the thickness of its membranes, or of its mesh.
    """

    @property
    def title(self) -> str:
        """The name, or one made from the names of master and slave."""
        return self.name or f"{self.master}-{self.slave}"

    @model_validator(mode="after")
    def _sides_fit_the_type(self) -> Self:
        """Refuse keys that have no effect with this type or search."""
        if self.type != "combined" and self.master_law is not None:
            raise CaseError(
                'only a contact of type "combined" has a master_law',
                where="master_law",
                found=self.master_law.kind,
                remedy='Remove it, or set type = "combined"',
            )
        if self.depth is not None and self.search != "penetration":
            raise CaseError(
                "only a search by penetration has a depth",
                where="depth",
                found=self.depth,
                remedy='Remove it, or set search = "penetration"',
            )
        if self.through == "hold" and self.search == "penetration":
            raise CaseError(
                "a search by penetration does not know where points enter",
                where="through",
                found=self.through,
                remedy='Remove it, or set search = "intersection"',
            )
        return self
