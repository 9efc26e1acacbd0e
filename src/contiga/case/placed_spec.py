"""Placed parts of a case: the keys `transform`, `align`, `place` and `then`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from contiga.arrays.ordered import product
from contiga.case.place_spec import AlignSpec, PlaceSpec
from contiga.case.problems import errors_at
from contiga.case.spec import Axis, Positive, Spec, Vector
from contiga.errors import CaseError
from contiga.masters.protocol import Master
from contiga.placement.place import Part
from contiga.records import FloatArray
from contiga.rigid import transform
from contiga.slaves.slave import Slave


class RotateEntry(Spec):
    """`rotate = { axis, degrees, centre }` of a transform."""

    axis: Axis = "z"
    degrees: float
    centre: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])


class TransformEntry(Spec):
    """One step of `transform = [ … ]`: translate, rotate or scale (about the origin)."""

    translate: Vector | None = None
    rotate: RotateEntry | None = None
    scale: Positive | None = None

    @cached_property
    def matrix(self) -> FloatArray:
        """The step as a (4, 4) matrix."""
        if self.translate is not None:
            return transform.translation(self.translate)
        if self.rotate is not None:
            angle = math.radians(self.rotate.degrees)
            return transform.rotation(self.rotate.axis, angle, self.rotate.centre)
        assert self.scale is not None
        return transform.scaling(self.scale)

    @model_validator(mode="after")
    def _one_step_an_entry(self) -> Self:
        keys = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(keys) != 1:
            raise CaseError(
                "must have exactly one of the keys translate, rotate or scale",
                found=", ".join(keys) or "none",
                remedy="Write one entry for each step, in the order they are applied",
            )
        assert self.matrix is not None
        return self


def matrix_of(steps: Iterable[TransformEntry]) -> FloatArray:
    """Return several steps, in the order they are applied, as one (4, 4) matrix."""
    matrix = np.eye(4)
    for entry in steps:
        matrix = product(entry.matrix, matrix)
    return matrix


class Placed(Spec):
    """A part that `transform`, then `align`, then `place`, then `then` may move."""

    transform: list[TransformEntry] = Field(default_factory=list)
    align: AlignSpec | None = None
    place: PlaceSpec | None = None
    then: list[TransformEntry] = Field(default_factory=list)
    """Steps of a file that is included: its placement, and its joints."""

    @property
    def matrix(self) -> FloatArray:
        """The steps of `transform` as one (4, 4) matrix."""
        return matrix_of(self.transform)

    def place_part(self, part: Part, parts: Mapping[str, Master | Slave]) -> Part:
        """Return `part` aligned, then placed, relative to `parts`; before the steps of `then`."""
        for key, entry in (("align", self.align), ("place", self.place)):
            with errors_at(key):
                part = part if entry is None else entry.moved(part, parts)
        return part

    def moved(self, part: Part) -> Part:
        """Return `part` moved by the steps of `then`."""
        return part.transformed(matrix_of(self.then)) if self.then else part
