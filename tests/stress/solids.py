"""Closed bodies, each with an inside test that owes nothing to the search.

The generated ones go through a STEP file, as a user's part does, and have a closed form. CAD files
have OpenCASCADE's solid classifier.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tests.cases import occ
from tests.stress import fields, parts
from tests.stress.outlines import blade, circle, rod, stadium, teeth

import contiga as cg
from contiga.io.cad.occ_geometry import quiet

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
CLOSED_FILES = ("nist_ctc_02_asme1_ap242.stp",)

SLOT = 6.0


class Recipe(NamedTuple):
    """How OpenCASCADE makes a solid, and what it is in closed form."""

    make: Callable[[], Any]
    field: fields.Field


class Solid(NamedTuple):
    """A closed body and what is known of it."""

    name: str
    body: cg.Body
    shape: Any
    """OpenCASCADE's."""
    field: fields.Field | None
    """Negative inside and never more than the distance to the surface; None for CAD files."""

    @property
    def size(self) -> float:
        """Diagonal of the box around it."""
        return self.body.size


def _block(radius: float) -> Recipe:
    low, high = (-30.0, -20.0, -10.0), (30.0, 20.0, 10.0)
    return Recipe(
        lambda: parts.rounded(parts.solid_box(low, high), radius), fields.box(low, high, radius)
    )


def _slot() -> Recipe:
    """A cube of 60 with a slot a tenth as wide from above."""
    cube = (-30.0, -30.0, -30.0), (30.0, 30.0, 30.0)
    tool = (-0.5 * SLOT, -40.0, -12.0), (0.5 * SLOT, 40.0, 40.0)
    return Recipe(
        lambda: parts.cut(parts.solid_box(*cube), parts.solid_box(*tool)),
        fields.minus(fields.box(*cube), fields.box(*tool)),
    )


def _cup() -> Recipe:
    """A round cup with a wall of 2 and a bottom of 3."""
    return Recipe(
        lambda: parts.cut(
            parts.solid_tube(2, 25.0, (0, 0, 0), 40.0), parts.solid_tube(2, 23.0, (0, 0, 3), 40.0)
        ),
        fields.minus(
            fields.common(fields.tube(2, 25.0), fields.between(2, 0.0, 40.0)),
            fields.common(fields.tube(2, 23.0), fields.between(2, 3.0, 50.0)),
        ),
    )


def _bores(radii: tuple[float, float, float], shift: float, scale: float = 1.0) -> Recipe:
    """A cube with bores along x, y and z that cross."""
    half = 30.0 * scale
    cube = 3 * (-half,), 3 * (half,)
    at = (shift * scale, -shift * scale)
    radii = (radii[0] * scale, radii[1] * scale, radii[2] * scale)

    def make() -> Any:
        low = -1.5 * half
        starts = ((low, *at), (at[0], low, at[1]), (*at, low))
        tools = [parts.solid_tube(k, radii[k], starts[k], 3.0 * half) for k in range(3)]
        return parts.cut(parts.solid_box(*cube), *tools)

    tubes = (fields.tube(k, radii[k], at) for k in range(3))
    return Recipe(make, fields.minus(fields.box(*cube), *tubes))


def _lens() -> Recipe:
    """What two balls have in common: a sharp rim, 12 thick."""
    low, high = (0.0, 0.0, -44.0), (0.0, 0.0, 44.0)
    return Recipe(
        lambda: parts.common_part(parts.solid_ball(low, 50.0), parts.solid_ball(high, 50.0)),
        fields.common(fields.ball(low, 50.0), fields.ball(high, 50.0)),
    )


def _shell() -> Recipe:
    """A box hollowed to walls of 1.5, open above."""
    low, high, wall = np.array([-30.0, -20.0, 0.0]), np.array([30.0, 20.0, 25.0]), 1.5
    return Recipe(
        lambda: parts.hollowed(parts.solid_box(low, high), wall, high[2]),
        fields.minus(fields.box(low, high), fields.box(low + wall, high - [wall, wall, -50.0])),
    )


def _link(scale: float = 1.0) -> Recipe:
    """A link rod: two eyes, a bar with a pocket on either side, oil ways that cross the bores."""
    length, far = 100.0 * scale, 200.0 * scale
    outline = rod(length, (22.0 * scale, 15.0 * scale), 9.0 * scale, 12.0 * scale)
    pocket = stadium(36.0 * scale, 70.0 * scale, 3.0 * scale)
    deep, half = 4.0 * scale, 8.0 * scale
    # Axis, radius, the other two coordinates of the axis.
    holes = [(2, 12.0, (0.0, 0.0)), (2, 8.0, (length, 0.0)), (1, 2.5, (0.0, 0.0))]
    way = 1.5 * scale

    def make() -> Any:
        low = (0.0, 0.0, -half - deep)
        tools = [
            parts.prism([pocket], deep, far),
            parts.prism([pocket], -far, -deep),
            parts.solid_tube(2, 12.0 * scale, low, far),
            parts.solid_tube(2, 8.0 * scale, (length, *low[1:]), far),
            parts.solid_tube(1, 2.5 * scale, (0.0, -length, 0.0), far),
            parts.solid_tube(0, way, (0.5 * length, 0.0, 0.0), length),
        ]
        return parts.cut(parts.prism([outline], -half, half), *tools)

    return Recipe(
        make,
        fields.minus(
            fields.extruded([outline], -half, half),
            fields.extruded([pocket], deep, far),
            fields.extruded([pocket], -far, -deep),
            *(fields.tube(axis, radius * scale, at) for axis, radius, at in holes),
            fields.common(fields.tube(0, way), fields.between(0, 0.5 * length, 1.5 * length)),
        ),
    )


def _prism(loops: list[list[fields.Piece]], half: float) -> Recipe:
    return Recipe(lambda: parts.prism(loops, -half, half), fields.extruded(loops, -half, half))


# Internal gear: count of teeth, radii of roots and tips; rotor blade: its ends and its bulge.
GEAR = (8, 32.0, 25.0)
BLADE = (10.0, 50.0, 3.0)

RECIPES: dict[str, Recipe] = {
    "box": Recipe(
        lambda: parts.solid_box((-20.0, -30.0, -40.0), (20.0, 30.0, 40.0)),
        fields.box((-20.0, -30.0, -40.0), (20.0, 30.0, 40.0)),
    ),
    "block, fillets 0.5": _block(0.5),
    "block, fillets 3": _block(3.0),
    "block, fillets 9": _block(9.0),
    "slot": _slot(),
    "cup": _cup(),
    "bores": _bores((12.0, 10.0, 8.0), 0.0),
    "bores off centre": _bores((12.0, 11.0, 9.0), 2.0),
    # As small as a millimetre, OpenCASCADE's joints are 1e-7 of the size wide.
    "small bores": _bores((10.0, 10.0, 10.0), 0.0, 1.0 / 60.0),
    "cone": Recipe(lambda: parts.solid_cone(20.0, 45.0), fields.cone(20.0, 45.0)),
    "lens": _lens(),
    "torus": Recipe(lambda: parts.solid_torus(30.0, 8.0), fields.torus(30.0, 8.0)),
    "shell": _shell(),
    "link rod": _link(),
    "small link rod": _link(0.1),
    "internal gear": _prism([circle((0.0, 0.0), 40.0), teeth(*GEAR)], 6.0),
    "blade": _prism([blade(*BLADE)], 15.0),
}


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="contiga-stress-")


def written(name: str, shape: Any) -> Path:
    """A shape as a STEP file."""
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    path = Path(_folder().name) / f"{name.replace(' ', '_').replace(',', '')}.step"
    with quiet():
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
    return path


@cache
def solid(name: str) -> Solid:
    """A solid of `RECIPES`, or a closed file of the data folder."""
    recipe = RECIPES.get(name)
    if recipe is not None:
        shape = recipe.make()
        return Solid(name, cg.read_cad(written(name, shape)), shape, recipe.field)
    path = DATA / name
    return Solid(name, cg.read_cad(path), occ.read_shape(path), None)


def names() -> list[str]:
    """All of them; the files where the data folder is there."""
    return [*RECIPES, *(name for name in CLOSED_FILES if (DATA / name).is_file())]
