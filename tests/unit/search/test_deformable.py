"""The search on bodies whose control points move, against bodies that are built with them."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from tests.unit.geometry.test_net import bent, brick
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.errors import GeometryError
from contiga.geometry.edges import BodyEdge, EdgeUse
from contiga.records import Projection, empty_projection
from contiga.search.balls import radii
from contiga.search.certify import neighbourhoods
from contiga.search.deformable import Deformable, DeformedSurface, deformable_of
from contiga.search.sides import side_grid
from contiga.search.sweep import piece_lists
from contiga.search.tables import tables_of

KEPT = (radii._BALLS, neighbourhoods._NEIGHBOURHOODS, side_grid._SIDES, piece_lists._LISTS)


def pinched(body: cg.Body) -> cg.Body:
    """The same with a trace of a bend, so that no element has a formula."""
    patches = [
        cg.NurbsSurface(p.degrees, p.knots, bent(body, 3, 1e-3)[rows], p.weights)
        for p, rows in zip(body.patches, body.net.control, strict=True)
    ]
    return cg.Body(patches, trims=body.trims)


BODIES = {
    "plate": lambda: cg.Body([cg.shapes.bumpy_plate(waves=2)]),
    "holed": holed_plate,
    "ball": lambda: cg.Body([cg.shapes.sphere(radius=1.0)]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]),
    "box": brick,
    "high degree": lambda: cg.Body([cg.shapes.bumpy_plate(waves=1).elevate(4, 1)]),
}


def feet_on(surface: DeformedSurface, points: np.ndarray) -> Projection:
    feet = empty_projection(len(points))
    surface.closest(points, np.arange(len(points), dtype=np.int32), feet)
    return feet


def built_with(body: cg.Body, points: np.ndarray) -> cg.Body:
    """A body that has these control points from the first."""
    patches = [
        cg.NurbsSurface(p.degrees, p.knots, points[rows], p.weights)
        for p, rows in zip(body.patches, body.net.control, strict=True)
    ]
    return cg.Body(patches, trims=body.trims)


@pytest.mark.parametrize("name", BODIES)
def test_the_shape_at_rest_has_the_elements_and_boxes_of_the_body(name: str) -> None:
    body = BODIES[name]()
    at_rest, rest = deformable_of(body).at(body.net.points).tables, tables_of(body)
    close = {"rtol": 0.0, "atol": 1e-13 * body.size}  # the box's corners lie on each other so far
    np.testing.assert_allclose(at_rest.elements.coefs, rest.elements.coefs, **close)
    np.testing.assert_allclose(at_rest.tree["low"][0], rest.tree["low"][0], **close)
    np.testing.assert_array_equal(at_rest.scale, rest.scale)
    for column in ("patch", "trim", "neighbour", "neighbour_side", "flip", "ring", "box"):
        np.testing.assert_array_equal(
            at_rest.elements.table[column], rest.elements.table[column], err_msg=column
        )


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("by", [0.005, 0.05])
def test_feet_on_a_shape_are_those_of_a_body_that_is_built_so(name: str, by: float) -> None:
    body = BODIES[name]()
    shape = bent(body, 2, by)
    rng = np.random.default_rng(4)
    low, high = body.bounds()
    points = rng.uniform(low - 0.2 * body.size, high + 0.2 * body.size, (400, 3))
    feet = feet_on(deformable_of(body).at(shape), points)
    own = built_with(body, shape).project(points)
    ended = (int(cg.Status.BORDER), int(cg.Status.TRIMMED))  # by rounding one or the other
    np.testing.assert_array_equal(np.isin(feet.status, ended), np.isin(own.status, ended))
    away, own_away = (np.linalg.norm(f.point - points, axis=1) for f in (feet, own))
    np.testing.assert_allclose(away, own_away, rtol=0, atol=1e-10 * body.size)
    assert (feet.certified >= own.certified).mean() > 0.99


def test_a_shape_made_in_one_go_is_that_made_on_the_way() -> None:
    deformable = deformable_of(BODIES["torus"]())
    shape = bent(BODIES["torus"]())
    deformable.at(shape * 1.5)
    first, again = deformable.at(shape).tables, deformable.at(shape).tables
    assert first.elements.table.tobytes() == again.elements.table.tobytes()
    assert first.tree.tobytes() == again.tree.tobytes()
    fresh = deformable_of(BODIES["torus"]()).at(shape).tables
    assert first.leaves.tobytes() == fresh.leaves.tobytes()


def test_two_shapes_are_kept_as_they_were() -> None:
    """Several contacts ask for one, and the next step for it; who changes an array gets another."""
    deformable, shape = deformable_of(BODIES["torus"]()), bent(BODIES["torus"]())
    first, second = deformable.at(shape), deformable.at(1.1 * shape)
    assert deformable.at(shape.copy()) is first
    assert deformable.at(1.1 * shape) is second
    shape *= 1.2
    third = deformable.at(shape)
    assert third is not first
    assert deformable.at(shape / 1.2 * 1.2) is third
    assert deformable.at(shape / 1.2) is not first
    np.testing.assert_allclose(third.tables.tree["high"][0], 1.2 * first.tables.tree["high"][0])


def test_a_joint_that_gets_a_kink_holds_feet() -> None:
    """Two halves of a plate, joined in one plane; a roof as the ridge goes up."""
    left = cg.shapes.plane(width=1.0, length=2.0)
    halves = [left.translated([x, 0.0, 0.0]) for x in (-0.5, 0.5)]
    body = cg.Body(halves)
    assert (tables_of(body).elements.table["kind"] == 0).any()  # smooth at rest
    roof = body.net.points.copy()
    roof[np.abs(roof[:, 0]) < 1e-9, 2] = 1.0
    above = np.array([[0.1, 0.3, 3.0]])
    feet = feet_on(deformable_of(body).at(roof), above)
    np.testing.assert_allclose(feet.point, [[0.0, 0.3, 1.0]], atol=1e-12)
    assert feet.feature[0] == cg.Feature.EDGE


def test_a_patch_that_is_folded_along_a_knot_line_holds_feet() -> None:
    plate = cg.shapes.plane(width=2.0, length=2.0).insert_knots([0.5], [])
    body = cg.Body([plate])
    roof = body.net.points.copy()
    roof[np.abs(roof[:, 0]) < 1e-9, 2] = 1.0
    feet = feet_on(deformable_of(body).at(roof), np.array([[0.1, 0.3, 3.0]]))
    np.testing.assert_allclose(feet.point, [[0.0, 0.3, 1.0]], atol=1e-12)


def test_a_pole_that_gets_a_tip_holds_feet() -> None:
    body = BODIES["ball"]()
    tipped = body.net.points.copy()
    top = body.net.control[0][0, -1]
    tipped[top] += [0.0, 0.0, 1.0]
    feet = feet_on(deformable_of(body).at(tipped), tipped[[top]] + [0.01, 0.0, 2.0])
    np.testing.assert_allclose(feet.point, tipped[[top]], atol=1e-12)


def test_a_foot_that_is_handed_to_another_shape_is_never_certified() -> None:
    body = BODIES["plate"]()
    deformable = deformable_of(body)
    points = body.patches[0].evaluate(np.full((1, 2), 0.4))
    points[:, 2] += 0.1
    on_rest = feet_on(deformable.at(body.net.points), points)
    assert on_rest.certified[0] == 1
    out = empty_projection(1)
    shape = deformable.at(bent(body, by=1e-3))
    shape.track(points, on_rest.patch, on_rest.uv, out, points)
    assert out.status[0] == cg.Status.OK
    assert out.certified[0] == 0


def test_nothing_is_kept_of_shapes() -> None:
    body = BODIES["ball"]()
    deformable = deformable_of(body)
    points = np.random.default_rng(0).standard_normal((300, 3))
    rows = np.arange(300, dtype=np.int32)

    def use(shape: DeformedSurface) -> None:
        feet = feet_on(shape, points)
        shape.track(points, feet.patch, feet.uv, empty_projection(300), points)
        shape.sides(points, rows)
        shape.clear_paths(points, points + 0.1, rows)
        shape.last_crossings(points, points + 0.5, rows)
        assert shape.contact_tables is None

    use(deformable.at(body.net.points))
    gc.collect()
    kept = [len(each._uses) for each in KEPT]
    for k in range(20):
        use(deformable.at(body.net.points * (1.0 + 0.01 * k)))
    gc.collect()
    assert [len(each._uses) for each in KEPT] == kept


def test_of_a_closed_shape_what_is_beyond_its_box_is_outside() -> None:
    body = BODIES["ball"]()
    surface = deformable_of(body).at(body.net.points * 2.0)
    points = np.array([[0.0, 0.0, 5.0], [0.1, 0.0, 0.0], [1.3, 1.3, 1.3]])
    known = surface.sides(points, np.arange(3, dtype=np.int32))
    assert known.side.tolist() == [1, 0, 0]
    assert 2.0 < known.reach[0] <= 3.0


def made(body: cg.Body) -> Deformable:
    return deformable_of(body)


def test_patches_that_would_come_apart_are_refused() -> None:
    left = cg.shapes.plane(width=1.0, length=2.0)
    right = left.translated([1.0, 0.0, 0.0])
    with pytest.raises(GeometryError, match=r"patch 0 and 1: patches that meet.*Refine both"):
        made(cg.Body([left.elevate(0, 1), right]))
    twice = (
        left.elevate(0, 1).insert_knots([], [0.5, 0.5]),
        right.elevate(0, 1).insert_knots([], [0.5]),
    )
    with pytest.raises(GeometryError, match="would come apart"):
        made(cg.Body(twice))


def test_a_trimmed_face_that_meets_another_is_refused() -> None:
    plate = holed_plate()
    curve = cg.shapes.circle(radius=0.2)
    body = cg.Body(
        [*plate.patches, cg.shapes.disc(radius=0.2)],
        trims=[*plate.trims, None],
        edges=[BodyEdge(curve, 1.0, (EdgeUse(0, 1, 0, False), EdgeUse(1, -1, 3, False)))],
    )
    with pytest.raises(GeometryError, match="edge 0: a trimmed face that meets another"):
        made(body)


@pytest.mark.parametrize("size", [0.0, 1e80])
def test_a_shape_that_cannot_be_computed_with_is_refused(size: float) -> None:
    body = BODIES["plate"]()
    with pytest.raises(GeometryError, match="size cannot be computed with"):
        made(body).at(body.net.points * size)
