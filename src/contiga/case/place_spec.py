"""The `align` and `place` tables of a case: places of parts relative to others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

from pydantic import Field, model_validator

from contiga.case.spec import Axis, Name, NotNegative, Spec
from contiga.errors import CaseError
from contiga.masters.protocol import Master
from contiga.placement.align import align, check_alignment
from contiga.placement.place import Part, place
from contiga.rigid.transform import unit_axis
from contiga.slaves.slave import Slave


class AlignSpec(Spec):
    """`align = { to, centres, lows, highs, axes }`: `contiga.align`; `to` the origin if omitted."""

    to: Name | None = None
    centres: list[str] = Field(default_factory=list)
    lows: list[str] = Field(default_factory=list)
    highs: list[str] = Field(default_factory=list)
    axes: str | None = None
    """Axes that are aligned: "principal"."""

    @model_validator(mode="after")
    def _something_is_aligned(self) -> Self:
        ends = check_alignment(self.centres, self.lows, self.highs, self.axes)
        if self.to is not None and not ends:
            raise CaseError(
                "nothing of the boxes is named",
                where="to",
                found=self.to,
                allowed='beside centres, lows or highs of "x", "y", "z"',
            )
        return self

    def moved(self, part: Part, parts: Mapping[str, Master | Slave]) -> Part:
        """Return `part`, aligned to one of the parts placed already, or to the origin."""
        return align(
            part,
            to=None if self.to is None else parts[self.to],
            centres=self.centres,
            lows=self.lows,
            highs=self.highs,
            axes=self.axes,
        )

    def describe(self) -> str:
        """Describe the table in words."""
        sides = [
            f"{key} {', '.join(axes)}"
            for key in ("centres", "lows", "highs")
            if (axes := getattr(self, key))
        ]
        boxes = f"{' and '.join(sides)} aligned to {self.to or 'the origin'}" if sides else ""
        rotation = "principal axes along x, y, z" if self.axes else ""
        return ", ".join(text for text in (rotation, boxes) if text)


class PlaceSpec(Spec):
    """The table `place = { on, direction, gap }`: the arguments of `contiga.place`."""

    on: Name
    direction: Axis
    gap: NotNegative = 0.0

    @model_validator(mode="after")
    def _direction_is_one(self) -> Self:
        unit_axis(self.direction, "direction")
        return self

    def moved(self, part: Part, parts: Mapping[str, Master | Slave]) -> Part:
        """Return `part` at the gap from one of the parts placed already."""
        return place(part, on=parts[self.on], direction=self.direction, gap=self.gap)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"moved along {self.direction} to a gap of {self.gap:g} from {self.on}"
