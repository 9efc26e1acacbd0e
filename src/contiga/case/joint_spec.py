"""The `joint` tables of a case: joints between bodies, or to the ground."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from contiga.case.curve_spec import JointCurve, with_characteristics
from contiga.case.spec import MadeSpec, Name, NotNegative, Positive, is_number
from contiga.dynamics.joint_laws import JointLaw
from contiga.dynamics.joints import Joint
from contiga.errors import CaseError


def _vector_or_two(value: Any) -> Any:
    # One message: a union of types would give one for each type.
    rows = value if isinstance(value, list) else []
    each = rows if rows and all(isinstance(row, list) for row in rows) else [rows]
    sizes = len(each) in (1, 2) and all(len(row) == 3 for row in each)
    if not sizes or not all(is_number(number) for row in each for number in row):
        raise CaseError(
            "must be a vector, or one for each body",
            found=value,
            allowed="[x, y, z] or [[x, y, z], [x, y, z]]",
        )
    return value


VectorOrTwo = Annotated[list[float] | list[list[float]], BeforeValidator(_vector_or_two)]


class JointLawSpec(MadeSpec[JointLaw]):
    """`angle = { … }` of a joint: `JointLaw`, with all its options."""

    makes = JointLaw
    curve: JointCurve | None = None
    """Moment over radians, or force over travel."""
    unloading: JointCurve | None = None
    hysteresis_slope: Positive | None = None
    damping: NotNegative = 0.0
    friction: NotNegative = 0.0
    friction_slope: Positive | None = None
    stops: list[float] | None = None
    """[low, high]: radians, or length."""
    stop_curve: JointCurve | None = None
    start: float = 0.0
    """Value of the coordinate at the start."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `JointLaw` takes."""
        return with_characteristics(super().arguments())

    def describe(self) -> str:
        """Describe the table in words."""
        given = [f"from {self.start:g}"] if self.start else []
        given += [
            f"{name.replace('_', ' ')} {curve.describe()}"
            for name in ("curve", "unloading", "stop_curve")
            if (curve := getattr(self, name)) is not None
        ]
        given += [f"damping {self.damping:g}"] if self.damping else []
        given += [f"friction {self.friction:g}"] if self.friction else []
        given += [f"stops at {self.stops[0]:g} and {self.stops[1]:g}"] if self.stops else []
        return ", ".join(given)


class JointSpec(MadeSpec[Joint]):
    """A `[[joint]]`: `Joint`, with all its options."""

    makes = Joint
    name: Name | None = None
    """How results call it; "<first>-<second>" if omitted."""
    kind: str
    between: list[str]
    at: VectorOrTwo
    axis: VectorOrTwo | None = None
    angle: JointLawSpec | None = None
    travel: JointLawSpec | None = None
    angle_1: JointLawSpec | None = None
    angle_2: JointLawSpec | None = None
    cone: JointLawSpec | None = None
    twist: JointLawSpec | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Joint` takes.

        Raises
        ------
        CaseError
            Not two bodies.
        """
        given = super().arguments() | {"name": self.name or ""}
        between = given.pop("between")
        if len(between) != 2:
            raise CaseError(
                "must be two names",
                where="between",
                found=between,
                allowed='the names of two bodies, or of one and "ground"',
            )
        return given | {"kind": self.kind, "first": between[0], "second": between[1]}

    def describe(self) -> str:
        """Describe the table in words."""
        laws = [
            f"{key}: {law.describe()}"
            for key in ("angle", "travel", "angle_1", "angle_2", "cone", "twist")
            if (law := getattr(self, key)) is not None
        ]
        text = f"{self.kind} between {' and '.join(self.between)}"
        return "; ".join([text, *laws])
