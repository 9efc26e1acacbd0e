"""Slaves of splines: their patches, how these are refined, and what is refused."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import contiga as cg
from contiga.errors import GeometryError, InputError, MeshError
from contiga.slaves.surfaces import Refinement, patches_of, refined

SQUARE = cg.shapes.plane(width=2.0, length=2.0)


def two_plates(second: float = 2.0) -> list[cg.NurbsSurface]:
    """Squares side by side, the second of another width."""
    return [SQUARE, cg.shapes.plane(width=second, length=2.0, centre=(1.0 + second / 2, 0, 0))]


def test_its_points_lie_on_the_surface_and_have_its_area() -> None:
    tube = cg.Slave(surfaces=refined([cg.shapes.cylinder(radius=3.0, height=2.0)], Refinement()))
    assert np.abs(np.hypot(tube.points[:, 0], tube.points[:, 1]) - 3.0).max() < 1e-12
    assert float(tube.area.sum()) == pytest.approx(12.0 * np.pi, rel=1e-9)


def test_what_moves_it_moves_its_patches_with_their_edges() -> None:
    slave = cg.Slave(surfaces=SQUARE, thickness=0.5)
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    mirror[0, 3] = 5.0
    for moved in (slave.transformed(mirror), slave.scaled(2.0), pickle.loads(pickle.dumps(slave))):
        np.testing.assert_allclose(moved.surfaces.points, moved.points, atol=1e-12)
        np.testing.assert_array_equal(moved.surfaces.edge("u0"), slave.surfaces.edge("u0"))
    assert float(slave.scaled(2.0).area.sum()) == pytest.approx(16.0)


def test_points_beside_surfaces_are_refused() -> None:
    with pytest.raises(MeshError, match="nodes of its surfaces"):
        cg.Slave([[0.0, 0.0, 0.0]], surfaces=SQUARE)
    with pytest.raises(MeshError, match="needs points, or surfaces"):
        cg.Slave()


def test_neighbours_are_cut_alike_where_one_is_longer() -> None:
    """A long plate beside a short one: their joint has the elements of the finer, along it only."""
    patches = refined(two_plates(6.0), Refinement(size=1.0))
    along = [[len(np.unique(knots)) - 1 for knots in one.knots] for one in patches]
    assert along == [[2, 2], [6, 2]]
    assert cg.Slave(surfaces=patches).area.sum() == pytest.approx(16.0)


def test_a_given_number_of_elements_counts_the_lines_that_are_there() -> None:
    (ring,) = refined([cg.shapes.cylinder(radius=1.0, height=2.0)], Refinement(3, (8, 3)))
    assert ring.degrees == (3, 3)
    assert [len(np.unique(knots)) - 1 for knots in ring.knots] == [8, 3]


def test_the_shape_stays() -> None:
    uv = np.random.default_rng(0).uniform(size=(20, 2)) * [2 * np.pi, 1.0]
    ring = cg.shapes.cylinder(radius=1.0, height=1.0)
    (finer,) = refined([ring], Refinement(4, None, 0.2))
    share = uv / [2 * np.pi, 1.0]
    places = [
        [low + (high - low) * t for (low, high), t in zip(ring.domain, row, strict=True)]
        for row in share
    ]
    np.testing.assert_allclose(finer.evaluate(places), ring.evaluate(places), atol=1e-12)


def test_trimmed_faces_and_too_many_elements_are_refused() -> None:
    hole = cg.shapes.circle(radius=0.2, centre=(0.5, 0.5, 0.0))
    (low_u, high_u), (low_v, high_v) = SQUARE.domain
    frame = [
        cg.shapes.line((a, b, 0.0), (c, d, 0.0))
        for a, b, c, d in (
            (low_u, low_v, high_u, low_v),
            (high_u, low_v, high_u, high_v),
            (high_u, high_v, low_u, high_v),
            (low_u, high_v, low_u, low_v),
        )
    ]
    body = cg.Body([SQUARE, SQUARE], trims=[None, [frame, [hole]]])
    with pytest.raises(GeometryError, match=r"1 of 2 faces are trimmed.*face 2"):
        patches_of(body)
    assert patches_of(cg.Body([SQUARE])) == (SQUARE,)
    with pytest.raises(InputError, match="more elements than"):
        refined([SQUARE], Refinement(size=1e-3))
