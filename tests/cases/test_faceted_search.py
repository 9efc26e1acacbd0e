"""Search against triangles as MADYMO does it, in whole runs: against windings, distances by every
triangle, and closed forms where a foot leaves the segments."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus
from contiga.statuses import Feature

STIFFNESS, AREA = 2.0, 0.3
CASE = """
title = "Search against triangles"
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = {end}, step = 1.0 }}
[[body]]
name = "master"
geometry = {{ mesh = "{mesh}", normals = "{normals}" }}
motion = {{ kind = "translate", table = {table} }}
[[slave]]
name = "nodes"
points = {{ coordinates = {points} }}
[[contact]]
master = "master"
slave = "nodes"
search = "{search}"
on_edge = "{on_edge}"
law = {{ kind = "penalty", stiffness = 2.0, per_area = true }}
area = {{ kind = "constant", value = 0.3 }}
[output]
report = false
formats = []
"""


@pytest.fixture(scope="module")
def oracle() -> ModuleType:
    path = Path(__file__).parents[1] / "unit" / "triangles" / "oracle.py"
    spec = importlib.util.spec_from_file_location("contiga_test_facet_oracle", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def run(run_case: Callable, tmp_path: Path) -> Callable:
    """A run on a mesh whose motion a table gives."""

    def play(mesh: cg.TriMesh, points: object, table: object, **keys: str):
        path = tmp_path / "master.vtu"
        meshio.write(path, meshio.Mesh(mesh.vertices, [("triangle", mesh.triangles)]))
        options = {"search": "intersection", "on_edge": "release", "normals": "facet"} | keys
        rows = np.asarray(table, dtype=float).tolist()
        nodes = np.asarray(points, dtype=float).tolist()
        return run_case(
            CASE.format(mesh=path, points=nodes, table=rows, end=rows[-1][0], **options)
        )

    return play


@pytest.mark.parametrize("normals", ["facet", "vertex"])
@pytest.mark.parametrize("search", ["intersection", "penetration"])
def test_both_searches_find_what_lies_inside_and_how_deep(
    oracle: ModuleType, run: Callable, search: str, normals: str
) -> None:
    mesh = cg.shapes.ellipsoid(axes=(1.0, 0.8, 0.6)).tessellate(0.01)
    rng = np.random.default_rng(0)
    points = rng.normal(size=(200, 3))
    points *= (1.05 + 0.1 * rng.random((200, 1))) / np.linalg.norm(
        points / [1.0, 0.8, 0.6], axis=1, keepdims=True
    )
    path = 0.2 * np.array([[0, 0, 0], [1, 0.3, 0], [0.4, 1, 0.5], [-0.5, 0.2, 1], [-1, 0, 0]])
    table = np.column_stack([np.arange(len(path)), path])
    result = run(mesh, points, table, search=search, normals=normals)
    actual = 0
    for k, shift in enumerate(path):
        state = result.states[k]
        inside = oracle.windings(mesh, points - shift) > 0.5
        depth = np.where(inside, oracle.distances(mesh, points - shift).min(axis=1), 0.0)
        np.testing.assert_array_equal(state.in_contact, inside)
        # Inside facets there are several local minima close together; the foot keeps to its own.
        excess = state.penetration - depth
        assert excess.min() > -1e-12
        assert excess.max() < 0.01
        assert (excess < 1e-12).mean() > 0.95
        np.testing.assert_array_equal(state.area[inside], AREA)
        size = np.linalg.norm(state.force, axis=1)
        expected = STIFFNESS * AREA * state.penetration
        np.testing.assert_allclose(size, expected, rtol=0, atol=1e-12)
        along = (state.normal[inside] * mesh.normals()[state.patch[inside]]).sum(axis=1)
        assert (along > 0.9).all()
        off = np.abs(along - 1.0)[state.feature[inside] == Feature.FACE]
        assert (off < 1e-12).all() if normals == "facet" else np.median([1.0, *off]) > 1e-6
        actual += inside.sum()
    assert actual > 100


def test_points_that_start_inside_are_seen_by_penetration_only(run: Callable) -> None:
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.02)
    still = [[0, 0, 0, 0], [2, 0, 0, 0]]
    counts = [
        run(ball, [[0.1, 0.2, 0.8]], still, search=search).history["n_contact"]
        for search in ("intersection", "penetration")
    ]
    np.testing.assert_array_equal(counts, [[0, 0, 0], [1, 1, 1]])


def test_a_node_without_a_projection_on_any_segment_maps_to_the_closest_one(
    run: Callable,
) -> None:
    # Below the bottom of a groove z = |x| no segment is square to the node.
    x, y = np.array([-1.0, 0.0, 1.0]), np.array([-1.0, 1.0])
    vertices = [[a, b, abs(a)] for a in x for b in y]
    groove = cg.TriMesh(vertices, [[0, 2, 1], [2, 3, 1], [2, 4, 3], [4, 5, 3]])
    nodes = np.array([[0.02, 0.1, 0.15], [-0.03, -0.2, 0.2], [0.5, 0.0, 0.6]])
    rise = 0.25
    result = run(groove, nodes, [[0, 0, 0, 0], [1, 0, 0, rise], [2, 0, 0, 0]])
    state = result.states[1]
    below = nodes - [0, 0, rise]
    way = np.hypot(below[:2, 0], below[:2, 2])
    assert state.in_contact.all()
    assert state.feature.tolist() == [Feature.EDGE, Feature.EDGE, Feature.FACE]
    np.testing.assert_allclose(state.penetration, [*way, 0.15 / np.sqrt(2)], rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        state.foot, [[0, 0.1, rise], [0, -0.2, rise], [0.425, 0, 0.425 + rise]], rtol=0, atol=1e-12
    )
    toward = -below[:2] / way[:, None] * [1, 0, 1]
    np.testing.assert_allclose(state.normal[:2], toward, rtol=0, atol=1e-12)
    assert not result.states[2].in_contact.any()


@pytest.mark.parametrize("on_edge", ["release", "hold"])
def test_a_node_that_slides_over_the_border_is_released_or_kept_on_the_closest_segment(
    run: Callable, on_edge: str
) -> None:
    sheet = cg.TriMesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]])
    table = [[0, 0, 0, 0], [1, 0, 0, 0.2], [2, -0.6, 0, 0.2]]
    result = run(sheet, [[1.5, 1.0, 0.1]], table, on_edge=on_edge)
    assert result.states[1].penetration[0] == pytest.approx(0.1)
    state = result.states[2]
    if on_edge == "release":
        assert state.status[0] == ContactStatus.SLID_OFF
        return
    assert state.status[0] == ContactStatus.HELD
    np.testing.assert_allclose(state.foot, [[1.4, 1.0, 0.2]], rtol=0, atol=1e-15)
    assert state.penetration[0] == pytest.approx(0.1)
    np.testing.assert_allclose(state.normal, [[0, 0, 1]], rtol=0, atol=1e-15)
