"""The laws of a contact in a case: laws of normal force, friction."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from contiga.case.curve_spec import (
    Amplification,
    CurveTable,
    DampingCurve,
    ForceCurve,
    StressCurve,
    characteristic_of,
    if_given,
)
from contiga.case.spec import NotNegative, Positive, Spec, by_kind
from contiga.errors import CaseError
from contiga.laws.force import ForceLaw
from contiga.laws.friction import Coulomb, Friction, ViscousFriction
from contiga.laws.law import Law
from contiga.laws.normal import AdaptiveLaw, PenaltyLaw
from contiga.laws.stress import StressLaw


class _KindSpec(Spec):
    kind: str

    def describe(self) -> str:
        """In words: what is not as it is by default."""
        given = []
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if isinstance(value, CurveTable):
                given.append(f"{name} {value.describe()}")
            elif name != "kind" and value != field.default:
                given.append(f"{name} {value}")
        return f"{self.kind}: {'; '.join(given)}" if given else self.kind


class _LawSpec(_KindSpec):
    @cached_property
    def law(self) -> Law:
        """The law."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _law_is_possible(self) -> Self:
        assert self.law is not None
        return self


class ForceSpec(_LawSpec):
    """`{ kind = "force", curve, unloading, hysteresis_slope, share }`: `ForceLaw`."""

    kind: Literal["force"] = "force"
    curve: ForceCurve
    """Force over greatest penetration."""
    unloading: ForceCurve | None = None
    hysteresis_slope: Positive | None = None
    share: Literal["deepest", "penetration"] = "deepest"

    @cached_property
    def law(self) -> Law:
        """The law."""
        return ForceLaw(
            characteristic_of(self.curve, "curve"),
            unloading=if_given(self.unloading, "unloading"),
            hysteresis_slope=self.hysteresis_slope,
            share=self.share,
        )


class StressSpec(_LawSpec):
    """`{ kind = "stress", elastic, thickness, damping, … }`: `StressLaw`, with all its options."""

    kind: Literal["stress"] = "stress"
    elastic: StressCurve
    thickness: Positive | None = None
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0
    damping_curve: DampingCurve | None = None
    amplification: Amplification | None = None
    unloading: StressCurve | None = None
    hysteresis_slope: Positive | None = None

    @cached_property
    def law(self) -> Law:
        """The law."""
        return StressLaw(
            characteristic_of(self.elastic, "elastic"),
            self.thickness,
            damping=self.damping,
            damping_ratio=self.damping_ratio,
            damping_curve=if_given(self.damping_curve, "damping_curve"),
            amplification=if_given(self.amplification, "amplification"),
            unloading=if_given(self.unloading, "unloading"),
            hysteresis_slope=self.hysteresis_slope,
        )


class PenaltySpec(_LawSpec):
    """`{ kind = "penalty", stiffness, per_area, damping, damping_ratio }`: `PenaltyLaw`.

    With `scale` in place of `stiffness`: so many times what the elements of the slave hold a unit
    of its area with.
    """

    kind: Literal["penalty"] = "penalty"
    stiffness: Positive | None = None
    scale: Positive | None = None
    per_area: bool = False
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0

    @cached_property
    def law(self) -> Law:
        """The law."""
        return self.scaled(1.0)

    def scaled(self, of_slave: float) -> Law:
        """The law; `of_slave` is what `scale` is of, a force over a volume."""
        stiffness = self.stiffness or (self.scale or 1.0) * of_slave
        return PenaltyLaw(
            stiffness,
            per_area=self.per_area or self.scale is not None,
            damping=self.damping,
            damping_ratio=self.damping_ratio,
        )

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

    kind: Literal["adaptive"] = "adaptive"
    scale: Positive = 0.1

    @cached_property
    def law(self) -> Law:
        """The law."""
        return AdaptiveLaw(self.scale)


class _FrictionSpec(_KindSpec):
    @cached_property
    def friction(self) -> Friction:
        """The friction."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _friction_is_possible(self) -> Self:
        assert self.friction is not None
        return self


class CoulombSpec(_FrictionSpec):
    """`{ kind = "coulomb", static, dynamic, decay, stiffness, per_area }`: `Coulomb`."""

    kind: Literal["coulomb"] = "coulomb"
    static: NotNegative
    dynamic: NotNegative | None = None
    decay: NotNegative = 0.0
    stiffness: NotNegative = 0.0
    """0: from the law of normal force."""
    per_area: bool = False

    @cached_property
    def friction(self) -> Friction:
        """The friction."""
        return Coulomb(
            self.static,
            self.dynamic,
            decay=self.decay,
            stiffness=self.stiffness,
            per_area=self.per_area,
        )


class ViscousSpec(_FrictionSpec):
    """`{ kind = "viscous-regularised", coefficient, speed }`: `ViscousFriction`."""

    kind: Literal["viscous-regularised"] = "viscous-regularised"
    coefficient: NotNegative
    speed: Positive

    @cached_property
    def friction(self) -> Friction:
        """The friction."""
        return ViscousFriction(self.coefficient, self.speed)


if TYPE_CHECKING:
    LawSpec = ForceSpec | StressSpec | PenaltySpec | AdaptiveSpec
    FrictionSpec = CoulombSpec | ViscousSpec
else:
    LawSpec = by_kind(ForceSpec, StressSpec, PenaltySpec, AdaptiveSpec)
    FrictionSpec = by_kind(CoulombSpec, ViscousSpec)
