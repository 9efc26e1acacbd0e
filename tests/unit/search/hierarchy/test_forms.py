"""Which elements have a form: planes and surfaces of revolution, however a body was moved."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.codes import NO_FORM, PLANE, TURNED_ARC, TURNED_LINE
from contiga.search.tables import tables_of

SHAPES = {
    "plane": (cg.shapes.plane(), PLANE),
    "parallelogram": (cg.shapes.bilinear([0, 0, 0], [2, 1, 0], [0.5, 1, 1], [2.5, 2, 1]), PLANE),
    "cylinder": (cg.shapes.cylinder(radius=0.3), TURNED_LINE),
    "cone": (cg.shapes.cone(), TURNED_LINE),
    "disc": (cg.shapes.disc(), TURNED_LINE),
    "sphere": (cg.shapes.sphere(), TURNED_ARC),
    "torus": (cg.shapes.torus(), TURNED_ARC),
    "twisted plane": (cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1e-6]), NO_FORM),
    "ellipsoid": (cg.shapes.ellipsoid(axes=(1.0, 1.01, 1.0)), NO_FORM),
    "wavy plate": (cg.shapes.bumpy_plate(), NO_FORM),
}


def kinds(body: cg.Body) -> set[int]:
    return set(tables_of(body).items.forms["kind"].tolist()) or {NO_FORM}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_known_wherever_they_are(name: str) -> None:
    patch, kind = SHAPES[name]
    body = cg.Body([patch])
    moved = body.rotated([1.0, 2.0, -0.5], 1.1).translated([3.0, -7.0, 0.4])
    for one in (body, moved, moved.scaled(1e-3), moved.scaled(1e3), moved.flipped()):
        assert kinds(one) == {kind}


def sheared(body: cg.Body, share: float) -> cg.Body:
    matrix = np.eye(4)
    matrix[0, 2] = share
    return body.transformed(matrix)


def test_a_sheared_plane_is_one_and_a_sheared_cylinder_is_none() -> None:
    assert kinds(sheared(cg.Body([cg.shapes.plane()]), 0.3)) == {PLANE}
    cylinder = cg.Body([cg.shapes.cylinder()])
    assert kinds(sheared(cylinder, 0.3)) == {NO_FORM}
    # Rounding is no shear, and what the tolerance of a foot tells is.
    assert kinds(sheared(cylinder, 1e-14)) == {TURNED_LINE}
    assert kinds(sheared(cylinder, 1e-9)) == {NO_FORM}


def test_weights_that_are_not_those_of_a_circle_are_seen() -> None:
    patch = cg.shapes.cylinder()
    weights = patch.weights.copy()
    weights[1] *= 1.0 + 1e-9
    other = cg.NurbsSurface(patch.degrees, patch.knots, patch.control_points, weights)
    assert NO_FORM in kinds(cg.Body([other]))


def test_a_face_whose_loops_leave_its_patch_has_none() -> None:
    ends = np.array([[-0.005, 0.1], [0.9, 0.1], [0.9, 0.9], [-0.005, 0.9], [-0.005, 0.1]])
    flat = np.column_stack([ends, np.zeros(5)])
    loop = tuple(cg.NurbsCurve(1, [0, 0, 1, 1], flat[k : k + 2]) for k in range(4))
    patch = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    assert kinds(cg.Body([patch], trims=[[loop]])) == {NO_FORM}
    inside = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], np.maximum(c.control_points, [0.0, 0.0, 0.0])) for c in loop
    )
    assert kinds(cg.Body([patch], trims=[[inside]])) == {PLANE}


def test_elements_with_forms_are_one_item_each_and_others_keep_their_leaves() -> None:
    wavy = cg.shapes.bumpy_plate().translated([0.0, 0.0, 3.0])
    tables = tables_of(cg.Body([cg.shapes.sphere(), wavy]))
    items, kind = tables.items, tables.items.forms["kind"]
    formed = items.leaves["element"][items.leaves["has_form"] == 1]
    assert sorted(formed) == np.flatnonzero(kind != NO_FORM).tolist()
    rest = items.leaves["element"][items.leaves["has_form"] == 0]
    assert sorted(rest) == sorted(e for e in tables.leaves["element"] if kind[e] == NO_FORM)


def test_a_body_without_forms_has_its_leaves_once() -> None:
    tables = tables_of(cg.Body([cg.shapes.bumpy_plate()]))
    assert tables.items.leaves is tables.leaves
    assert tables.items.tree is tables.tree
