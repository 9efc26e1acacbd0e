"""The `material` tables of what deforms."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contiga.case.curve_spec import BeltCurve, StressCurve
from contiga.case.spec import Positive, Spec, Vector, by_kind
from contiga.matter.coefficients import Material
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Belt, Fabric


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


class BeltSpec(_MaterialSpec):
    """`{ kind = "belt", loading, unloading, hysteresis_slope }`: `Belt`."""

    kind: Literal["belt"] = "belt"
    loading: BeltCurve
    """Force over strain."""
    unloading: BeltCurve | None = None
    hysteresis_slope: Positive | None = None

    @cached_property
    def material(self) -> Material:
        """The material."""
        unloading = None if self.unloading is None else np.array(self.unloading.points)
        return Belt(
            loading=np.array(self.loading.points),
            unloading=unloading,
            hysteresis_slope=self.hysteresis_slope,
        )

    def describe(self) -> str:
        """In words."""
        return f"belt: {self.loading.describe()}"


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
    MaterialSpec = ElasticSpec | NeoHookeSpec | FoamSpec | FabricSpec | BeltSpec
else:
    MaterialSpec = by_kind(ElasticSpec, NeoHookeSpec, FoamSpec, FabricSpec, BeltSpec)
