"""The `material` tables of deforming slaves."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from contiga.case.curve_spec import BeltCurve, CurveTable, StressCurve
from contiga.case.spec import BY_KIND, InstanceSpec, Positive, Spec, Vector
from contiga.matter.coefficients import Material
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Belt, Fabric


class _MaterialSpec(InstanceSpec[Material]):
    def arguments(self) -> dict[str, Any]:
        """Return the arguments that the material takes, curves as arrays."""
        arguments = super().arguments()
        return {
            name: np.array(value.points) if isinstance(value, CurveTable) else value
            for name, value in arguments.items()
        }


class ElasticSpec(_MaterialSpec):
    """`{ kind = "elastic", young, poisson, compression }`: `contiga.materials.Elastic`."""

    makes = Elastic
    kind: Literal["elastic"] = "elastic"
    young: Positive
    poisson: float = 0.0
    compression: bool = True

    def describe(self) -> str:
        """Describe the table in words."""
        return f"elastic: young {self.young:g}, poisson {self.poisson:g}"


class NeoHookeSpec(_MaterialSpec):
    """`{ kind = "neo-hooke", young, poisson, volume }`: `contiga.materials.NeoHooke`."""

    makes = NeoHooke
    kind: Literal["neo-hooke"] = "neo-hooke"
    young: Positive
    poisson: float
    volume: str = "element"

    def describe(self) -> str:
        """Describe the table in words."""
        return f"neo-Hooke: young {self.young:g}, poisson {self.poisson:g}"


class RateSpec(Spec):
    """`{ rate, loading }`: the loading curve of a foam at a strain rate."""

    rate: Positive
    loading: StressCurve


class FoamSpec(_MaterialSpec):
    """`{ kind = "foam", loading, hysteresis, shape, tension, rates, filter }`: `Foam`."""

    makes = Foam
    kind: Literal["foam"] = "foam"
    loading: StressCurve
    """Stress over strain in compression, both nominal."""
    hysteresis: float = 1.0
    shape: Positive = 9.0
    tension: Positive | None = None
    rates: list[RateSpec] = Field(default_factory=list)
    filter: Positive | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Foam` takes."""
        rates = tuple((spec.rate, np.array(spec.loading.points)) for spec in self.rates)
        return super().arguments() | {"rates": rates}

    def describe(self) -> str:
        """Describe the table in words."""
        rates = f", at {len(self.rates)} rates" if self.rates else ""
        return f"foam: {self.loading.describe()}{rates}"


class BeltSpec(_MaterialSpec):
    """`{ kind = "belt", loading, unloading, hysteresis_slope }`: `Belt`."""

    makes = Belt
    kind: Literal["belt"] = "belt"
    loading: BeltCurve
    """Force over strain."""
    unloading: BeltCurve | None = None
    hysteresis_slope: Positive | None = None

    def describe(self) -> str:
        """Describe the table in words."""
        return f"belt: {self.loading.describe()}"


class FabricSpec(_MaterialSpec):
    """`{ kind = "fabric", warp, weft, shear, direction, compression, … }`: `Fabric`."""

    makes = Fabric
    kind: Literal["fabric"] = "fabric"
    warp: StressCurve
    weft: StressCurve | None = None
    shear: StressCurve
    direction: Vector
    """Direction of the warp at rest, world axes."""
    compression: float = 0.0
    warp_unloading: StressCurve | None = None
    weft_unloading: StressCurve | None = None
    hysteresis_slope: Positive | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Fabric` takes."""
        return super().arguments() | {"direction": np.array(self.direction)}

    def describe(self) -> str:
        """Describe the table in words."""
        return f"fabric: warp {self.warp.describe()}"


MaterialSpec = Annotated[ElasticSpec | NeoHookeSpec | FoamSpec | FabricSpec | BeltSpec, BY_KIND]
