"""The `joint` tables of a case: joints between bodies, or to the ground."""

from __future__ import annotations

from typing import Annotated, Any

from contiga.case.curve_spec import JointCurve, with_characteristics
from contiga.case.spec import (
    InstanceSpec,
    Name,
    NotNegative,
    Positive,
    has_rows,
    is_number,
    must_be,
)
from contiga.dynamics.joint_laws import JointLaw
from contiga.dynamics.joints import Joint
from contiga.errors import CaseError


def _is_vector_or_two(value: Any) -> bool:
    """Return whether a value is a vector of three numbers, or a list of one or two such."""
    vectors = value if has_rows(value) else [value if isinstance(value, list) else []]
    sizes_fit = len(vectors) in (1, 2) and all(len(vector) == 3 for vector in vectors)
    return sizes_fit and all(is_number(number) for vector in vectors for number in vector)


VectorOrTwo = Annotated[
    list[float] | list[list[float]],
    must_be(
        _is_vector_or_two,
        "must be a vector, or one for each body",
        "[x, y, z] or [[x, y, z], [x, y, z]]",
    ),
]


class JointLawSpec(InstanceSpec[JointLaw]):
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
        facts = [f"from {self.start:g}"] if self.start else []
        facts += [
            f"{name.replace('_', ' ')} {curve.describe()}"
            for name in ("curve", "unloading", "stop_curve")
            if (curve := getattr(self, name)) is not None
        ]
        facts += [f"damping {self.damping:g}"] if self.damping else []
        facts += [f"friction {self.friction:g}"] if self.friction else []
        facts += [f"stops at {self.stops[0]:g} and {self.stops[1]:g}"] if self.stops else []
        return ", ".join(facts)


class JointSpec(InstanceSpec[Joint]):
    """A `[[joint]]`: `Joint`, with all its options."""

    makes = Joint
    name: Name | None = None
    """Name in results; "<first>-<second>" if omitted."""
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
        arguments = super().arguments() | {"name": self.name or ""}
        between = arguments.pop("between")
        if len(between) != 2:
            raise CaseError(
                "must be two names",
                where="between",
                found=between,
                allowed='the names of two bodies, or of one and "ground"',
            )
        return arguments | {"kind": self.kind, "first": between[0], "second": between[1]}

    def describe(self) -> str:
        """Describe the table in words."""
        laws = [
            f"{key}: {law.describe()}"
            for key in ("angle", "travel", "angle_1", "angle_2", "cone", "twist")
            if (law := getattr(self, key)) is not None
        ]
        text = f"{self.kind} between {' and '.join(self.between)}"
        return "; ".join([text, *laws])
