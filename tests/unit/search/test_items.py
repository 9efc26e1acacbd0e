"""Closest points by formulas are those that leaves alone lead to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests import occ_solids
from tests.sample import FULL, full
from tests.scenes import box

import contiga as cg
from contiga.arrays.codes import NO_FORM
from contiga.records import (
    FacingLimits,
    FloatArray,
    Projection,
    SurfacePlaces,
    empty_projection,
)
from contiga.search.closest.closest import closest_of_rows
from contiga.search.closest.kernels import facing_nb
from contiga.search.hierarchy.table_types import Items, Tables
from contiga.search.tables import tables_of

LEAST = float(np.cos(np.radians(160.0)))


def countersunk() -> Any:
    """A plate with a countersunk hole and a blind one with a conical end."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone

    shape = occ_solids.block((-10, -6, 0), (10, 6, 5))
    tools = [
        occ_solids.cylinder(1.5, 20, (-4, 0, -5)),
        BRepPrimAPI_MakeCone(occ_solids.axes((-4, 0, 3)), 1.5, 3.5, 2.0).Shape(),
        occ_solids.cylinder(2.0, 20, (5, 0, 2)),
        BRepPrimAPI_MakeCone(occ_solids.axes((5, 0, 1)), 0.0, 2.0, 1.0).Shape(),
    ]
    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    return shape


SOLIDS: dict[str, Callable[[], Any]] = {**occ_solids.SOLIDS, "countersunk": countersunk}
SOME = ["countersunk", "rounded_box", "cone", "crossing_bores"]


def made(name: str, folder: Path) -> cg.Body:
    return cg.read_cad(occ_solids.write(SOLIDS[name](), folder / "solid.step"))


def leaves_alone(tables: Tables) -> Tables:
    """The same tables, with no element that has a form."""
    forms = np.zeros_like(tables.items.forms)
    return tables._replace(items=Items(tables.leaves, tables.plates, tables.tree, forms))


def around(body: cg.Body, n: int, seed: int) -> FloatArray:
    """Points inside and outside, near and far, beside the surface, and on axes and planes of
    symmetry."""
    rng = np.random.default_rng(seed)
    low, high = body.bounds()
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    there = middle + half * rng.uniform(-1.4, 1.4, (n, 3))
    far = middle + body.size * rng.normal(size=(n // 8, 3)) * np.geomspace(1, 1e3, n // 8)[:, None]
    on_planes = there[: n // 2].copy()
    for k, row in enumerate(on_planes):
        row[k % 3] = middle[k % 3]
        if k % 2:
            row[(k + 1) % 3] = middle[(k + 1) % 3]
    places = body.project(there[: n // 4])
    off = body.size * np.geomspace(1e-9, 1e-2, n // 4) * np.where(np.arange(n // 4) % 2, 1, -1)
    beside = places.point + off[:, None] * places.normal
    return np.concatenate([there, far, on_planes, beside])


def closest(tables: Tables, points: FloatArray) -> Projection:
    out = empty_projection(len(points))
    closest_of_rows(tables, points, np.arange(len(points)), out)
    return out


def check_the_same(body: cg.Body, points: FloatArray) -> None:
    tables = tables_of(body)
    assert (tables.items.forms["kind"] != NO_FORM).any()
    found, known = closest(tables, points), closest(leaves_alone(tables), points)
    away = np.linalg.norm(points - body.bounds().mean(axis=0), axis=1)
    tolerance = 4e-12 * (body.size + away)
    assert (np.abs(np.abs(found.gap) - np.abs(known.gap)) <= tolerance).all()
    sure = np.abs(known.gap) > 1e-9 * body.size
    assert (np.sign(found.gap) == np.sign(known.gap))[sure].all()
    np.testing.assert_array_equal(found.status, known.status)
    assert (found.certified >= known.certified).all()
    # The point is that far from where it says, and that is on the patch.
    on_patch = [
        body.patches[k].evaluate(uv[None])[0] for k, uv in zip(found.patch, found.uv, strict=True)
    ]
    np.testing.assert_allclose(found.point, on_patch, rtol=0, atol=1e-11 * body.size)
    reached = np.linalg.norm(points - found.point, axis=1)
    assert (np.abs(reached - np.abs(found.gap)) <= tolerance + 1e-7 * body.size * ~sure).all()


@pytest.mark.parametrize("name", [*SOME, *full(*(set(SOLIDS) - set(SOME)))])
def test_closest_points_are_those_of_leaves_alone(name: str, tmp_path: Path) -> None:
    body = made(name, tmp_path)
    check_the_same(body, around(body, 4000 if FULL else 300, 1))


MOVED: dict[str, Callable[[cg.Body], cg.Body]] = {
    "turned": lambda body: body.rotated([1.0, 2.0, -0.7], 0.9).translated([1e3, -20.0, 7.0]),
    "small": lambda body: body.scaled(1e-3),
    "large": lambda body: body.scaled(1e3),
    "sheared": lambda body: body.transformed(np.eye(4) + 0.3 * np.eye(4, k=2)),
    "stretched": lambda body: body.scaled([1.0, 1.0, 2.5]),
    "flipped": lambda body: body.flipped(),
}


@pytest.mark.parametrize("how", MOVED)
def test_so_they_are_of_bodies_that_are_moved(how: str, tmp_path: Path) -> None:
    body = MOVED[how](made("countersunk", tmp_path))
    check_the_same(body, around(body, 300, 2))


@pytest.mark.parametrize(
    "patch", [cg.shapes.torus(), cg.shapes.sphere(), cg.shapes.cylinder(), cg.shapes.cone()]
)
def test_so_they_are_of_single_faces(patch: cg.NurbsSurface) -> None:
    body = cg.Body([patch])
    check_the_same(body, around(body, 300, 3))


def facing(tables: Tables, points: FloatArray, guards: FloatArray, near: FloatArray) -> Projection:
    out = empty_projection(len(points))
    starts = SurfacePlaces(np.full(len(points), -1, np.int32), np.zeros((len(points), 2)))
    limits = FacingLimits(LEAST, near, np.full(len(near), np.inf))
    facing_nb.project_facing(tables, points, guards, limits, starts, out, 0, len(points))
    return out


def check_facing(body: cg.Body, n: int) -> None:
    """Feet that do not face away are those of leaves alone, where these have found a minimum."""
    tables = tables_of(body)
    rng = np.random.default_rng(6)
    points = rng.uniform(*body.bounds(), (n, 3))
    nearest = body.project(points)
    inside = nearest.gap < 0.0
    points, normal = points[inside], nearest.normal[inside]
    guards = rng.normal(0.0, 0.3, points.shape) - normal
    guards /= np.linalg.norm(guards, axis=1)[:, None]
    near = -nearest.gap[inside] * rng.choice([0.0, 0.9, 1.5], len(points))
    found = facing(tables, points, guards, near)
    known = facing(leaves_alone(tables), points, guards, near)
    depth, truth = (np.where(feet.status == 0, -feet.gap, 1e9) for feet in (found, known))
    hair = 1e-7 * body.size
    same = np.abs(depth - truth) <= hair
    assert len(points) > n // 5
    assert same.mean() > 0.98
    # What leaves have found nearer is no minimum: followed from there, the foot comes nearer.
    rows = np.flatnonzero(truth < depth - hair)
    followed = empty_projection(len(rows))
    places = known.patch[rows], np.ascontiguousarray(known.uv[rows])
    body.surface.track(np.ascontiguousarray(points[rows]), *places, followed)
    reached = np.linalg.norm(followed.point - points[rows], axis=1)
    assert (reached < truth[rows] - hair).all()


@pytest.mark.parametrize("name", [*SOME, *full(*(set(SOLIDS) - set(SOME)))])
def test_feet_that_face_a_guard_are_those_of_leaves_alone(name: str, tmp_path: Path) -> None:
    check_facing(made(name, tmp_path), 4000 if FULL else 400)


def test_feet_that_face_a_guard_in_a_block() -> None:
    check_facing(box((0.0, 0.0, 0.0), (4.0, 3.0, 2.0)), 400)


@pytest.mark.full
def test_closest_points_of_a_casting_are_those_of_leaves_alone(data_dir: Path) -> None:
    body = cg.read_cad(data_dir / "nist_ctc_02_asme1_ap242.stp")
    check_the_same(body, around(body, 20000, 5))
