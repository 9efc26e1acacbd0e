"""`motion = { kind = "deform" }` of a slave: its material, and what is held of its nodes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.curve_spec import StressCurve
from contiga.case.nodal_spec import DrivenSpec, HeldSpec, NodalLoadSpec, NodesOf
from contiga.case.rigid_spec import ToldMotionSpec
from contiga.case.spec import NotNegative, Positive, Spec, Vector, by_kind
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.prescribed import BodyMotion
from contiga.matter.coefficients import Material
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Fabric

QUADRATURE = 3
"""Points a facet of a contact of what deforms, where nothing else is said."""


class _MaterialSpec(Spec):
    @cached_property
    def material(self) -> Material:
        """The material."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _material_is_possible(self) -> Self:
        assert self.material is not None
        return self


class ElasticSpec(_MaterialSpec):
    """`{ kind = "elastic", young, poisson, compression }`: `contiga.materials.Elastic`."""

    kind: Literal["elastic"] = "elastic"
    young: Positive
    poisson: float = 0.0
    compression: bool = True

    @cached_property
    def material(self) -> Material:
        """The material."""
        return Elastic(young=self.young, poisson=self.poisson, compression=self.compression)

    def describe(self) -> str:
        """In words."""
        return f"elastic: young {self.young:g}, poisson {self.poisson:g}"


class NeoHookeSpec(_MaterialSpec):
    """`{ kind = "neo-hooke", young, poisson, volume }`: `contiga.materials.NeoHooke`."""

    kind: Literal["neo-hooke"] = "neo-hooke"
    young: Positive
    poisson: float
    volume: str = "element"

    @cached_property
    def material(self) -> Material:
        """The material."""
        return NeoHooke(young=self.young, poisson=self.poisson, volume=self.volume)

    def describe(self) -> str:
        """In words."""
        return f"neo-Hooke: young {self.young:g}, poisson {self.poisson:g}"


class RateSpec(Spec):
    """`{ rate, loading }`: the loading curve of a foam at a rate of strain."""

    rate: Positive
    loading: StressCurve


class FoamSpec(_MaterialSpec):
    """`{ kind = "foam", loading, hysteresis, shape, tension, rates, filter }`: `Foam`."""

    kind: Literal["foam"] = "foam"
    loading: StressCurve
    """Stress over strain in compression, both nominal."""
    hysteresis: float = 1.0
    shape: Positive = 9.0
    tension: Positive | None = None
    rates: list[RateSpec] = Field(default_factory=list)
    filter: Positive | None = None

    @cached_property
    def material(self) -> Material:
        """The material."""
        return Foam(
            loading=np.array(self.loading.points),
            hysteresis=self.hysteresis,
            shape=self.shape,
            tension=self.tension,
            rates=tuple((one.rate, np.array(one.loading.points)) for one in self.rates),
            filter=self.filter,
        )

    def describe(self) -> str:
        """In words."""
        rates = f", at {len(self.rates)} rates" if self.rates else ""
        return f"foam: {self.loading.describe()}{rates}"


class FabricSpec(_MaterialSpec):
    """`{ kind = "fabric", warp, weft, shear, direction, compression, … }`: `Fabric`."""

    kind: Literal["fabric"] = "fabric"
    warp: StressCurve
    weft: StressCurve | None = None
    shear: StressCurve
    direction: Vector
    """Of the warp at rest, world axes."""
    compression: float = 0.0
    warp_unloading: StressCurve | None = None
    weft_unloading: StressCurve | None = None
    hysteresis_slope: Positive | None = None

    @cached_property
    def material(self) -> Material:
        """The material."""
        names = ("weft", "warp_unloading", "weft_unloading")
        curves = {name: getattr(self, name) for name in names}
        return Fabric(
            warp=np.array(self.warp.points),
            shear=np.array(self.shear.points),
            direction=np.array(self.direction),
            compression=self.compression,
            hysteresis_slope=self.hysteresis_slope,
            **{k: None if one is None else np.array(one.points) for k, one in curves.items()},
        )

    def describe(self) -> str:
        """In words."""
        return f"fabric: warp {self.warp.describe()}"


if TYPE_CHECKING:
    MaterialSpec = ElasticSpec | NeoHookeSpec | FoamSpec | FabricSpec
else:
    MaterialSpec = by_kind(ElasticSpec, NeoHookeSpec, FoamSpec, FabricSpec)


class DeformSpec(Spec):
    """`{ kind = "deform", material, density, thickness, fixed, driven, loads, … }`: elements.

    `fixed`, `driven` and `loads` are tables, or lists of them.
    """

    kind: Literal["deform"] = "deform"
    material: MaterialSpec
    density: Positive
    """Mass over volume."""
    thickness: Positive | None = None
    """Of membranes; that of the slave if omitted."""
    fixed: list[HeldSpec] = Field(default_factory=list)
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Of all nodes at the start that are not held."""
    damping: NotNegative = 0.0
    """α of a force −α m v on each node."""
    driven: list[DrivenSpec] = Field(default_factory=list)
    loads: list[NodalLoadSpec] = Field(default_factory=list)

    @model_validator(mode="before")
    @classmethod
    def _one_table_is_a_list(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        keys = ("fixed", "driven", "loads")
        return data | {key: [data[key]] for key in keys if isinstance(data.get(key), dict)}

    def moved(self, nodes_of: NodesOf, told: Callable[[ToldMotionSpec], BodyMotion]) -> Deforming:
        """The motion; `told` answers motions in the units of the case."""
        return Deforming(
            material=self.material.material,
            density=self.density,
            thickness=self.thickness,
            fixed=[one.table(nodes_of) for one in self.fixed] or None,
            velocity=self.velocity,
            damping=self.damping,
            driven=[one.table(nodes_of) | {"motion": told(one.motion)} for one in self.driven],
            loads=[one.load(nodes_of) for one in self.loads],
        )

    def describe(self) -> str:
        """In words."""
        held = f", nodes held at {len(self.fixed)} places" if self.fixed else ""
        held += "".join(f", {one.describe()}" for one in self.driven)
        held += "".join(f", {one.describe()}" for one in self.loads)
        way = f", velocity {self.velocity} at the start" if any(self.velocity) else ""
        return f"deforms, {self.material.describe()}, density {self.density:g}{held}{way}"


def with_quadrature(data: Any) -> Any:
    """The tables of a case, with points on facets for contacts of what deforms: nodes of solids
    carry forces unevenly, and are few. Where something is said against it nodes stay."""
    if not isinstance(data, dict) or not isinstance(data.get("contact"), list):
        return data
    slaves = data.get("slave")
    if not isinstance(slaves, list):
        return data
    deforming = {slave.get("name") for slave in slaves if _deforms(slave)}
    return data | {"contact": [_on_facets(one, deforming) for one in data["contact"]]}


def _deforms(slave: Any) -> bool:
    motion = slave.get("motion") if isinstance(slave, dict) else None
    return isinstance(motion, dict) and motion.get("kind") == "deform"


def _on_facets(contact: Any, deforming: set[Any]) -> Any:
    if not isinstance(contact, dict) or contact.get("slave") not in deforming:
        return contact
    law, area = contact.get("law"), contact.get("area")
    of_points = isinstance(law, dict) and law.get("kind") in ("penalty", "adaptive")
    of_points = of_points and not (isinstance(law, dict) and law.get("per_area", False))
    constant = isinstance(area, dict) and area.get("kind") == "constant"
    if "quadrature" in contact or contact.get("weights") == "area" or of_points or constant:
        return contact
    return contact | {"quadrature": QUADRATURE}
