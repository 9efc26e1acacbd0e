"""The laws of a contact in a case: curves, laws of normal force, friction."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BeforeValidator, model_validator

from contiga.case.spec import NotNegative, Positive, Spec, by_kind
from contiga.errors import CaseError
from contiga.laws.characteristic import Characteristic
from contiga.laws.force import ForceLaw
from contiga.laws.friction import Coulomb, Friction, ViscousFriction
from contiga.laws.law import Law
from contiga.laws.normal import AdaptiveLaw, PenaltyLaw
from contiga.laws.stress import StressLaw


class CurveTable(Spec):
    """`{ points = [[x, y], …], extrapolation = "linear" }`."""

    points: list[list[float]]
    extrapolation: Literal["linear", "constant", "error"] = "linear"

    def describe(self) -> str:
        """In words."""
        (x0, _), (x1, y1) = self.points[0], self.points[-1]
        beyond = {"linear": "goes on straight", "constant": "held", "error": "the run stops"}
        return (
            f"{len(self.points)} points from x = {x0:g} to ({x1:g}, {y1:g}), "
            f"{beyond[self.extrapolation]} beyond"
        )


def _as_curve_table(value: Any) -> Any:
    # Numbers and plain tables are short forms: a line through the origin, and linear ends.
    if isinstance(value, int | float) and not isinstance(value, bool):
        return {"points": [[0.0, 0.0], [1.0, value]]}
    if isinstance(value, list):
        return {"points": value}
    if isinstance(value, dict | CurveTable):
        return value
    raise CaseError(
        "must be a curve",
        found=value,
        allowed='a number, [[x, y], …] or { points = [[x, y], …], extrapolation = "linear" }',
    )


Curve = Annotated[CurveTable, BeforeValidator(_as_curve_table)]


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


def characteristic_of(curve: CurveTable, name: str) -> Characteristic:
    """The curve, called `name` in errors."""
    return Characteristic(curve.points, extrapolation=curve.extrapolation, name=name)


def if_given(curve: CurveTable | None, name: str) -> Characteristic | None:
    """The same of a key that may be left out."""
    return None if curve is None else characteristic_of(curve, name)


class ForceSpec(_LawSpec):
    """`{ kind = "force", curve, unloading, hysteresis_slope, share }`: `ForceLaw`."""

    kind: Literal["force"] = "force"
    curve: Curve
    """Force over greatest penetration."""
    unloading: Curve | None = None
    hysteresis_slope: Positive | None = None
    share: Literal["penetration", "deepest"] = "penetration"

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
    elastic: Curve
    thickness: Positive | None = None
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0
    damping_curve: Curve | None = None
    amplification: Curve | None = None
    unloading: Curve | None = None
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
    """`{ kind = "penalty", stiffness, per_area, damping, damping_ratio }`: `PenaltyLaw`."""

    kind: Literal["penalty"] = "penalty"
    stiffness: Positive
    per_area: bool = False
    damping: NotNegative = 0.0
    damping_ratio: NotNegative = 0.0

    @cached_property
    def law(self) -> Law:
        """The law."""
        return PenaltyLaw(
            self.stiffness,
            per_area=self.per_area,
            damping=self.damping,
            damping_ratio=self.damping_ratio,
        )


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
