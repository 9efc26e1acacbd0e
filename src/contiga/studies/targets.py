"""Targets of impacts of a study: a grid over a body, or points along wrap lines on its surface."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from contiga.case.spec import ExistingFile, Positive, Spec, Vector
from contiga.errors import CaseError, ContigaWarning, FileError
from contiga.io.sheet import read_sheet
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.rigid.frames import to_body, to_world
from contiga.statuses import Status

PLACE = ("x", "y", "z")
LINE = "line"
_HEADER = "line, x, y, z"
_MAX_RAYS = 1_000_000
"""Largest number of rays."""
_ON_GRID_TOL = 1e-9
"""Distance from a multiple of the spacing, over the spacing, that counts as on it."""


class TargetsSpec(Spec):
    """`targets`: points on a body of the base case, in place of a table."""

    body: str
    spacing: Positive
    """Spacing of the points, measured across `direction`."""
    direction: Vector = Field(default=[0.0, 0.0, -1.0])
    """Direction of the rays that find the points on the surface."""
    across: Vector = Field(default=[0.0, 1.0, 0.0])
    """Direction in which points of a wrap line are spaced, such as from side to side of a car."""
    origin: Vector = Field(default=[0.0, 0.0, 0.0])
    """A point that projects, along `direction`, to a point of the grid."""
    lines: ExistingFile | None = None
    """CSV file with the columns line, x, y, z: points of wrap lines in their order."""

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that variables may have."""
        return PLACE if self.lines is None else (LINE, *PLACE)

    def check_columns(self, columns: Mapping[str, str]) -> None:
        """Raise a CaseError if `columns`, by label of variable, is empty or has an unknown one."""
        allowed = ", ".join(self.columns)
        if not columns:
            raise CaseError("no variable is a column of them", where="targets", allowed=allowed)
        for label, column in columns.items():
            if column not in self.columns:
                raise CaseError(
                    "the targets have no such column", where=label, found=column, allowed=allowed
                )

    @property
    def axes(self) -> FloatArray:
        """The rows (3, 3): unit vectors across, along the lines, and down the rays.

        `across` is made perpendicular to `direction`.

        Raises
        ------
        CaseError
            `direction` is zero, or `across` is parallel to it.
        """
        down = np.array(self.direction)
        size = float(np.linalg.norm(down))
        across = np.array(self.across)
        if size > 0.0:
            down = down / size
            across = across - (across @ down) * down
        reach = float(np.linalg.norm(across))
        if not size > 0.0 or not reach > 1e-6 * float(np.linalg.norm(self.across)):
            raise CaseError(
                "must not be parallel to direction, and neither may be zero",
                where="targets.across",
                found=self.across,
            )
        across = across / reach
        return np.stack([across, np.cross(down, across), down])


def targets_of(
    spec: TargetsSpec, body: Master, pose: FloatArray, unit: str
) -> list[dict[str, Any]]:
    """Return rows of `columns`, each a point where a ray first meets the free side of the body.

    Rays that meet nothing, through holes or past the border, give none. Points are in the world
    frame, on their rays. Points of a wrap line stand where it passes multiples of the spacing,
    measured across from the origin.

    Parameters
    ----------
    spec : the specification of the targets
    body : the body, in its own frame
    pose : (4, 4) pose of the body at the start
    unit : unit of lengths of the case

    Raises
    ------
    CaseError
        No ray meets the body; a spacing with more than a million points.
    FileError
        The table of lines cannot be read, has no rows, or a line of one point.

    Warns
    -----
    ContigaWarning
        Rays whose search was given up: they are left out.
    """
    axes = spec.axes
    corners = np.stack(np.meshgrid(*body.bounds().T, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = to_world(pose, corners) @ axes.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    origin = axes @ spec.origin
    names: list[float] = []
    if spec.lines is None:
        # Multiples of the spacing within the two ends.
        with np.errstate(over="ignore", invalid="ignore"):
            first = np.ceil((low - origin)[:2] / spec.spacing)
            last = np.floor((high - origin)[:2] / spec.spacing)
            _check_number(spec, float(np.prod(np.maximum(last - first + 1.0, 0.0))))
        axis_points = [
            np.arange(a, b + 1.0) * spec.spacing for a, b in zip(first, last, strict=True)
        ]
        grid = np.stack(np.meshgrid(*axis_points, indexing="ij"), axis=-1).reshape(-1, 2)
        sides = grid + origin[:2]
    else:
        names, sides = _on_lines(spec, Path(spec.lines), unit)
    beyond = float((high - low).max())
    p0, p1 = (
        to_body(pose, np.column_stack([sides, np.full(len(sides), end)]) @ axes)
        for end in (low[2] - beyond, high[2] + beyond)
    )
    hit = body.first_hit(p0, p1)
    given_up = int((hit.status == Status.BUDGET).sum())
    if given_up:
        text = f"targets: the search of {given_up} rays was given up; they are left out"
        warnings.warn(text, ContigaWarning, stacklevel=2)
    is_hit = np.isin(hit.status, (Status.OK, Status.AT_START))
    if not is_hit.any():
        raise CaseError(
            "no ray meets the free side of the body",
            where="targets",
            found=f"{len(sides)} rays along {spec.direction}",
            allowed="a direction onto its free side, a spacing below its size, lines over it",
        )
    # Exactly on the ray, so that a point in the middle plane stays in it.
    rays = np.column_stack([sides, to_world(pose, hit.point) @ axes[2]]) @ axes
    return [
        {**({LINE: names[k]} if names else {}), **dict(zip(PLACE, rays[k].tolist(), strict=True))}
        for k in np.flatnonzero(is_hit)
    ]


def _check_number(spec: TargetsSpec, number: float) -> None:
    """Raise a CaseError above a million points; also at NaN, from a spacing that overflows."""
    if not number <= _MAX_RAYS:
        raise CaseError(
            "too many targets",
            where="targets.spacing",
            found=spec.spacing,
            allowed=f"up to {_MAX_RAYS} points",
        )


def _on_lines(spec: TargetsSpec, path: Path, unit: str) -> tuple[list[float], FloatArray]:
    """Return the line numbers of points on wrap lines, and their places (n, 2) across and along.

    Lines keep their order of appearance in the file, whose lengths are converted to `unit`.
    """
    sheet = read_sheet(path, _HEADER)
    sheet.check_header(_HEADER)
    order = sheet.order([LINE, *PLACE], (4,), _HEADER)
    rows = sheet.numbers(order, ("ratio", "length", "length", "length"), (unit, "kg", "s")).table
    if len(rows) == 0:
        raise FileError("has no rows", where=str(path), allowed="two points of a line or more")
    names: list[float] = []
    targets: list[FloatArray] = []
    axes = spec.axes
    origin = axes @ spec.origin
    number = 0.0
    for name in dict.fromkeys(rows[:, 0].tolist()):
        points = rows[rows[:, 0] == name, 1:] @ axes.T
        if len(points) < 2:
            raise FileError(
                "a line has one point only", where=str(path), found=name, allowed="two or more"
            )
        with np.errstate(over="ignore"):
            number += np.abs(np.diff(points[:, 0])).sum() / spec.spacing
        _check_number(spec, number)
        crossings = _crossings(points[:, :2], origin[0], spec.spacing)
        targets.append(crossings)
        names += [int(name) if name.is_integer() else name] * len(crossings)
    return names, np.concatenate(targets)


def _crossings(points: FloatArray, origin: float, spacing: float) -> FloatArray:
    """Return the points (k, 2) where a line (n, 2) passes multiples of the spacing, in its order.

    Multiples are those of the first coordinate from `origin`. An end within 1e-9 of one counts.

    >>> _crossings(np.array([[-1.0, 0.0], [0.5, 1.5], [2.0, 3.0]]), 0.0, 1.0).tolist()
    [[-1.0, 0.0], [0.0, 1.0], [1.0, 2.0], [2.0, 3.0]]
    """
    counts = (points[:, 0] - origin) / spacing
    rounded = np.round(counts)
    counts = np.where(np.abs(counts - rounded) <= _ON_GRID_TOL, rounded, counts)
    crossings = []
    for (u, w), (a, b) in zip(pairwise(counts), pairwise(points), strict=True):
        sign = 1.0 if u <= w else -1.0
        steps = sign * np.arange(math.ceil(sign * u), math.ceil(sign * w))
        crossings.append(a + ((steps - u) / (w - u))[:, None] * (b - a))
    # Each piece excludes its end, which begins the next one.
    return np.concatenate([*crossings, points[-1:][counts[-1:] == rounded[-1:]]])
