"""The laws of a contact in a case: laws of normal force, friction."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import model_validator

from contiga.case.curve_spec import (
    Amplification,
    CurveTable,
    DampingCurve,
    ForceCurve,
    StressCurve,
    with_characteristics,
)
from contiga.case.spec import BY_KIND, InstanceSpec, InstanceT, NotNegative, Positive
from contiga.errors import CaseError
from contiga.laws.force import ForceLaw
from contiga.laws.friction import Coulomb, Friction, ViscousFriction
from contiga.laws.law import Law
from contiga.laws.normal import AdaptiveLaw, PenaltyLaw
from contiga.laws.stress import StressLaw


class _KindSpec(InstanceSpec[InstanceT]):
    kind: str

    def describe(self) -> str:
        """Describe the keys that differ from their defaults."""
        facts = []
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if isinstance(value, CurveTable):
                facts.append(f"{name} {value.describe()}")
            elif name != "kind" and value != field.default:
                facts.append(f"{name} {value}")
        return f"{self.kind}: {'; '.join(facts)}" if facts else self.kind


class _LawSpec(_KindSpec[Law]):
    def arguments(self) -> dict[str, Any]:
        """Return the arguments that the law takes."""
        return with_characteristics(super().arguments())


class ForceSpec(_LawSpec):
    """`{ kind = "force", curve, unloading, hysteresis_slope, share }`: `ForceLaw`."""

    makes = ForceLaw
    kind: Literal["force"] = "force"
    curve: ForceCurve
    """Force over largest penetration."""
    unloading: ForceCurve | None = None
    hysteresis_slope: Positive | None = None
    share: Literal["deepest", "penetration"] = "deepest"


class StressSpec(_LawSpec):
    """`{ kind = "stress", elastic, thickness, damping, … }`: `StressLaw`, with all its options."""

    makes = StressLaw
    kind: Literal["stress"] = "stress"
    elastic: StressCurve
    thickness: Positive | None = None
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0
    damping_curve: DampingCurve | None = None
    amplification: Amplification | None = None
    unloading: StressCurve | None = None
    hysteresis_slope: Positive | None = None


class PenaltySpec(_LawSpec):
    """`{ kind = "penalty", stiffness, per_area, damping, damping_ratio }`: `PenaltyLaw`.

    `scale`, in place of `stiffness`, is a multiple of the stiffness per area of the elements of
    the slave.
    """

    makes = PenaltyLaw
    kind: Literal["penalty"] = "penalty"
    stiffness: Positive | None = None
    scale: Positive | None = None
    per_area: bool = False
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0

    def arguments(self, slave_stiffness: float = 1.0) -> dict[str, Any]:
        """Return the arguments that `PenaltyLaw` takes.

        With `scale`, the stiffness is that multiple of `slave_stiffness`, a force over a volume,
        and `per_area` is True.
        """
        arguments = super().arguments()
        scale = arguments.pop("scale")
        stiffness = self.stiffness or (scale or 1.0) * slave_stiffness
        return arguments | {"stiffness": stiffness, "per_area": self.per_area or scale is not None}

    def scaled(self, slave_stiffness: float) -> Law:
        """Return the law; `slave_stiffness` is the quantity that `scale` multiplies."""
        return PenaltyLaw(**self.arguments(slave_stiffness))

    @model_validator(mode="after")
    def _one_stiffness(self) -> Self:
        if (self.stiffness is None) == (self.scale is None):
            raise CaseError(
                "must have exactly one of the keys stiffness or scale",
                allowed="stiffness, or scale: so many times that of the elements of the slave",
            )
        return self


class AdaptiveSpec(_LawSpec):
    """`{ kind = "adaptive", scale = 0.1 }`."""

    makes = AdaptiveLaw
    kind: Literal["adaptive"] = "adaptive"
    scale: Positive = 0.1


class CoulombSpec(_KindSpec[Friction]):
    """`{ kind = "coulomb", static, dynamic, decay, stiffness, per_area }`: `Coulomb`."""

    makes = Coulomb
    kind: Literal["coulomb"] = "coulomb"
    static: NotNegative
    dynamic: NotNegative | None = None
    decay: NotNegative = 0.0
    stiffness: NotNegative = 0.0
    """Tangential stiffness; 0 takes the stiffness of the law of normal force."""
    per_area: bool = False


class ViscousSpec(_KindSpec[Friction]):
    """The table `{ kind = "viscous-regularised", coefficient, speed }` of a `ViscousFriction`."""

    makes = ViscousFriction
    kind: Literal["viscous-regularised"] = "viscous-regularised"
    coefficient: NotNegative
    speed: Positive


LawSpec = Annotated[ForceSpec | StressSpec | PenaltySpec | AdaptiveSpec, BY_KIND]
FrictionSpec = Annotated[CoulombSpec | ViscousSpec, BY_KIND]
