"""Meshes and exact geometry beside each other, at a small size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.statuses import Feature
from contiga_validation.engine.experiment import Options
from contiga_validation.rivals import cad_body, comparison
from contiga_validation.rivals.comparison_page import claims, compare, max_triangles
from contiga_validation.rivals.rival_meshes import ERRORS, hausdorff
from contiga_validation.rivals.turning import noise


@pytest.fixture(scope="module")
def rows() -> dict[str, list[comparison.Row]]:
    result = comparison.bodies()
    return {name: comparison.accuracy(name, body, 40_000, 4000) for name, body in result.items()}


@pytest.mark.parametrize("name", ["bumpy plate", "torus"])
def test_exact_penetrations_are_right_to_1e_10_and_those_of_meshes_to_their_error(
    rows: dict[str, list[comparison.Row]], name: str
) -> None:
    """An error of a mesh is at most its Hausdorff distance; of the exact side its feet's miss."""
    exact, *meshes = rows[name]
    assert exact.master == comparison.NURBS
    assert exact.depth_error is not None
    assert exact.depth_error <= 1e-10
    assert [row.target for row in meshes] == list(ERRORS)
    built = [row for row in meshes if row.seconds is not None]
    assert len(built) == 3
    for row in built:
        # measured at samples: a point may come upon a little more
        assert exact.depth_error < row.depth_error <= row.worst_error <= 1.1 * row.error
        assert row.error <= 1.25 * row.target
        assert row.fewest < row.elements
        assert row.exact_seconds > 0.0
    assert all(claim.holds for claim in claims([exact, *meshes]))


def test_meshes_that_are_not_built_are_extrapolated(
    rows: dict[str, list[comparison.Row]],
) -> None:
    """Ten times the triangles and the memory for a tenth of the error, and nothing measured."""
    for found in rows.values():
        *_, last, left, further = [row for row in found if row.target >= 1e-6]
        assert (last.seconds is None, left.seconds, further.seconds) == (False, None, None)
        for coarse, fine in ((last, left), (left, further)):
            assert fine.elements == pytest.approx(10 * coarse.elements, rel=1e-3)
            assert fine.megabytes == pytest.approx(10 * coarse.megabytes, rel=1e-3)
        assert (further.error, further.depth_error, further.peer_seconds) == (None, None, None)


def test_the_points_of_a_trimmed_body_lie_on_its_faces() -> None:
    """Its patches reach beyond: there the distance of a mesh would be that of no surface."""
    actual = cad_body.cad_body(data=Path("nowhere"))
    assert any(loops is not None for loops in actual.body.trims)
    on = comparison.path(actual.body, 3000).on
    assert 2700 < len(on) < 3300
    assert np.abs(actual.body.project(on).gap).max() < 1e-9 * actual.body.size
    assert hausdorff(actual.body.tessellate(1e-2 * actual.body.size), on) < 1e-2 * actual.body.size


def test_a_broken_exact_side_breaks_its_claim(rows: dict[str, list[comparison.Row]]) -> None:
    exact, *meshes = rows["torus"]
    off = exact._replace(depth_error=2e-10, worst_error=2e-10)
    assert [claim.holds for claim in claims([off, *meshes])][:1] == [False]
    coarse = [meshes[0]._replace(error=2.0 * meshes[0].target), *meshes[1:]]
    assert [claim.holds for claim in claims([exact, *coarse])][2:3] == [False]


def test_exact_penetrations_of_a_torus_have_the_closed_form() -> None:
    """|(ρ − R, z)| − r, with the foot tracked over several steps."""
    body = comparison.bodies()["torus"]
    low, high = body.bounds()
    minor = 0.5 * (high[2] - low[2])
    major = high[0] - minor
    tracker = comparison.Tracker(body, comparison.path(body, 2000).places)
    comparison.race([tracker], comparison.STEPS, 1)
    points = tracker.places[-1]
    across = np.hypot(points[:, 0], points[:, 1]) - major
    gap = np.hypot(across, points[:, 2]) - minor
    np.testing.assert_allclose(tracker.feet.gap, gap, rtol=0, atol=1e-12 * body.size)
    assert (gap < 0.0).any()


@pytest.mark.parametrize("name", ["bumpy plate", "torus"])
def test_points_of_the_comparison_have_a_foot_inside_a_face_at_every_step(name: str) -> None:
    """None runs over a border, where distances are to an edge, and few are left out."""
    body = comparison.bodies()[name]
    places = comparison.path(body, 2000).places
    assert 1900 < len(places[0]) <= 2000
    for place in places:
        feet = body.project(place)
        assert (feet.status == cg.Status.OK).all()
        assert (feet.feature == Feature.FACE).all()


def test_points_over_a_crease_are_left_out() -> None:
    """Where two faces are about as near, exact and faceted foot may be on different ones."""
    floor = cg.shapes.plane(width=1.0, length=1.0)
    wall = cg.shapes.plane(width=1.0, length=1.0, centre=(-0.5, 0.0, -0.5), axis="x").flipped()
    body = cg.Body([floor, wall])
    points = comparison.path(body, 2000).places[0]
    assert 1000 < len(points) < 2000
    other = np.abs(points[:, [0, 2]] + [0.5, 0.0]).max(axis=1)
    assert (other > 0.99 * comparison.REACH * body.size).all()


def test_a_turning_torus_has_a_constant_force_and_a_turning_mesh_has_not() -> None:
    """Noise below 1e-9 of the force against more than 1e-4 of a mesh with an error of 1e-3."""
    actual = noise(points=60, turns=31, finest=2)
    assert actual.spread(comparison.NURBS) < 1e-9
    assert actual.force[comparison.NURBS].min() > 0.0
    assert actual.spread("mesh 1e-02") > actual.spread("mesh 1e-03") > 1e-4


def test_the_cad_body_is_the_one_named_else_of_the_data_else_generated(
    data_dir: Path, tmp_path: Path
) -> None:
    named = cad_body.cad_body(data_dir / "dtmb5415_bulbous_bow.iges")
    assert (named.name, len(named.body.patches)) == ("dtmb5415_bulbous_bow", 1)
    public = cad_body.cad_body(data=data_dir)
    assert (public.name, len(public.body.patches)) == ("teapot", 32)
    own = cad_body.cad_body(data=tmp_path)
    assert own.name == "headform"
    assert len(own.body.patches) > 10
    assert own.body.size == pytest.approx(300.0, abs=60.0)


def test_the_page_says_which_cad_body_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data_dir: Path
) -> None:
    """Three bodies in table and picture, six meshes each."""
    monkeypatch.setattr("contiga_validation.rivals.comparison_page.MAX_TRIANGLES", 1000)
    monkeypatch.setattr("contiga_validation.rivals.comparison_page.POINTS", 1000)
    outcome = compare(Options(cad=data_dir / "utah_teapot_32bezier_gismo.xml"))
    assert "utah_teapot_32bezier_gismo.xml, named by the user" in outcome.difference
    (table,) = outcome.tables
    assert len({row[0] for row in table.rows}) == 3
    assert len(table.rows) == 3 * (1 + len(ERRORS))
    assert {len(row) for row in table.rows} == {len(table.columns)}


def test_full_builds_more_than_the_short_run() -> None:
    assert max_triangles(Options(full=True)) > max_triangles(Options())
