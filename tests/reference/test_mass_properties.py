"""Mass, centre and inertia: closed forms, OpenCASCADE, and meshes that come closer."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests import occ_solids

import contiga as cg
from contiga.rigid import transform

DENSITY = 2.5


class Truth(NamedTuple):
    """Of unit density, about the centre."""

    volume: float
    centre: np.ndarray
    inertia: np.ndarray


def truth(volume: float, centre: Any, *radii2: float) -> Truth:
    """A volume whose axes are principal ones, with squared radii of gyration."""
    return Truth(volume, np.array(centre, dtype=float), volume * np.diag(radii2))


def together(*parts: tuple[float, Truth]) -> Truth:
    """Parts with their signs, by the parallel axes."""
    volume = sum(sign * part.volume for sign, part in parts)
    centre = sum(sign * part.volume * part.centre for sign, part in parts) / volume
    inertia = np.zeros((3, 3))
    for sign, part in parts:
        d = part.centre - centre
        inertia += sign * (part.inertia + part.volume * (d @ d * np.eye(3) - np.outer(d, d)))
    return Truth(volume, centre, inertia)


def ellipsoid(a: float, b: float, c: float) -> Truth:
    radii2 = ((b * b + c * c) / 5, (a * a + c * c) / 5, (a * a + b * b) / 5)
    return truth(4 / 3 * math.pi * a * b * c, (0, 0, 0), *radii2)


def box(low: Any, high: Any) -> Truth:
    a, b, c = np.subtract(high, low)
    radii2 = ((b * b + c * c) / 12, (a * a + c * c) / 12, (a * a + b * b) / 12)
    return truth(a * b * c, np.add(low, high) / 2, *radii2)


def cylinder(r: float, h: float, place: Any) -> Truth:
    """From `place` up along z."""
    across = r * r / 4 + h * h / 12
    return truth(math.pi * r * r * h, np.add(place, (0, 0, h / 2)), across, across, r * r / 2)


def torus(R: float, r: float) -> Truth:
    across, along = R * R / 2 + 5 * r * r / 8, R * R + 3 * r * r / 4
    return truth(2 * math.pi**2 * R * r * r, (0, 0, 0), across, across, along)


def cone(r: float, h: float) -> Truth:
    across = 3 / 20 * r * r + 3 / 80 * h * h
    return truth(math.pi * r * r * h / 3, (0, 0, h / 4), across, across, 0.3 * r * r)


def moved(given: Truth, scale: float, turn: np.ndarray, to: np.ndarray) -> Truth:
    return Truth(
        scale**3 * given.volume,
        turn @ (scale * given.centre) + to,
        scale**5 * turn @ given.inertia @ turn.T,
    )


def assert_is(found: cg.MassProperties, given: Truth, size: float, rel: float) -> None:
    """Lengths to `rel` of the size, beyond what numbers as large as the centre can say."""
    far = 1e-15 * np.abs(given.centre).max() / size
    assert found.mass == pytest.approx(DENSITY * given.volume, rel=rel + 1e2 * far)
    assert np.abs(found.centre - given.centre).max() <= (rel + 1e2 * far) * size
    largest = DENSITY * np.abs(given.inertia).max()
    miss = np.abs(found.inertia - DENSITY * given.inertia).max()
    assert miss <= (rel + 1e3 * far) * largest


def solid(tmp_path: Path, shape: Any) -> cg.Body:
    return cg.read_cad(occ_solids.write(shape, tmp_path / "solid.step"), unit="mm")


def bored() -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(
        occ_solids.block((0, 0, 0), (8, 6, 4)), occ_solids.cylinder(1.5, 10.0, (3.0, 2.5, -3.0))
    ).Shape()


STRETCH = np.diag([3.0, 1.0, 0.5, 1.0])
EXACT = {
    "ball": (lambda: cg.Body([cg.shapes.sphere(radius=1.5)]), ellipsoid(1.5, 1.5, 1.5)),
    "ellipsoid": (
        lambda: cg.Body([cg.shapes.sphere(radius=1.0)]).transformed(STRETCH),
        ellipsoid(3.0, 1.0, 0.5),
    ),
    "torus": (lambda: cg.Body(cg.shapes.torus(major=3.0, minor=1.0)), torus(3.0, 1.0)),
    "ball with a ball as a void": (
        lambda: cg.Body(
            [cg.shapes.sphere(radius=2.0), cg.shapes.sphere(radius=0.7, centre=(1, 0, 0)).flipped()]
        ),
        together(
            (1, ellipsoid(2.0, 2.0, 2.0)),
            (-1, ellipsoid(0.7, 0.7, 0.7)._replace(centre=np.array([1.0, 0.0, 0.0]))),
        ),
    ),
}
CAD = {
    "box": (lambda: occ_solids.block((1, 2, 3), (5, 4, 4)), box((1, 2, 3), (5, 4, 4))),
    "cylinder": (lambda: occ_solids.cylinder(2.0, 5.0, (1, 1, 1)), cylinder(2.0, 5.0, (1, 1, 1))),
    "cone": (occ_solids.cone, cone(4.0, 9.0)),
    "torus": (occ_solids.torus, torus(6.0, 2.0)),
    "ball": (occ_solids.sphere, ellipsoid(3.0, 3.0, 3.0)),
    "box with a bore": (
        bored,
        together((1, box((0, 0, 0), (8, 6, 4))), (-1, cylinder(1.5, 4.0, (3.0, 2.5, 0.0)))),
    ),
    "cup": (
        occ_solids.cup,
        together((1, cylinder(5, 10, (0, 0, 0))), (-1, cylinder(4, 9, (0, 0, 1)))),
    ),
}


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e4])
@pytest.mark.parametrize("away", [0.0, 1e3])
def test_shapes_have_the_moments_of_closed_forms(name, scale, away):
    make, given = EXACT[name]
    axis, angle, way = np.array([1.0, 2.0, -0.5]), 0.8, np.array([0.6, -0.7, 0.4])
    body = make().scaled(scale).rotated(axis, angle).translated(away * scale * way)
    turn = transform.rotation(axis, angle)[:3, :3]
    expected = moved(given, scale, turn, away * scale * way)
    assert_is(body.mass_properties(DENSITY), expected, body.size, 1e-11)


@pytest.mark.parametrize("name", CAD)
def test_cad_solids_have_the_moments_of_closed_forms(name, tmp_path):
    make, given = CAD[name]
    body = solid(tmp_path, make())
    assert_is(body.mass_properties(DENSITY), given, body.size, 1e-11)


def of_occ(shape: Any) -> Truth:
    """OpenCASCADE's adaptive integration of unit density."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    total = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, total, 1e-10, False, False)
    middle, matrix = total.CentreOfMass(), total.MatrixOfInertia()
    return Truth(
        total.Mass(),
        np.array([middle.X(), middle.Y(), middle.Z()]),
        np.array([[matrix.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)]),
    )


@pytest.mark.parametrize("name", occ_solids.SOLIDS)
def test_solids_have_the_moments_of_opencascade(name, tmp_path):
    shape = occ_solids.SOLIDS[name]()
    body = solid(tmp_path, shape)
    # Edges of fillets meet to 1e-7.
    assert_is(body.mass_properties(DENSITY), of_occ(shape), body.size, 1e-8)


@lru_cache(maxsize=1)
def nist(path: Path) -> tuple[cg.Body, Any]:
    return cg.read_cad(path, unit="mm"), occ_solids.plain_shape(path)


@pytest.mark.full
def test_a_part_of_487_faces_has_the_moments_of_opencascade(data_dir):
    body, shape = nist(data_dir / "nist_ctc_02_asme1_ap242.stp")
    assert_is(body.mass_properties(DENSITY), of_occ(shape), body.size, 5e-6)


@pytest.mark.parametrize("name", EXACT)
def test_meshes_come_closer_with_the_square_of_their_sides(name):
    make, given = EXACT[name]
    body = make()
    sides, misses = [], []
    for tol in (0.02, 0.005, 0.00125):
        mesh = body.tessellate(tol * body.size / 6.0)
        result = mesh.mass_properties(1.0)
        sides.append(math.sqrt(mesh.area() / len(mesh.triangles)))
        misses.append(
            [
                abs(result.mass / given.volume - 1.0),
                np.abs(result.inertia - given.inertia).max() / np.abs(given.inertia).max(),
            ]
        )
    orders = np.polyfit(np.log(sides), np.log(misses), 1)[0]
    assert np.all(np.abs(orders - 2.0) < 0.15), orders
    assert np.max(misses[-1]) < 0.01


def test_a_fine_mesh_of_a_cad_part_has_its_moments(tmp_path):
    body = solid(tmp_path, occ_solids.link_rod())
    exact = body.mass_properties(1.0)
    coarse, fine = (body.tessellate(tol).mass_properties(1.0) for tol in (0.04, 0.01))
    assert abs(fine.mass / exact.mass - 1.0) < 2e-3
    assert abs(fine.mass - exact.mass) < 0.4 * abs(coarse.mass - exact.mass)
    assert np.abs(fine.inertia - exact.inertia).max() < 5e-3 * exact.inertia.max()
