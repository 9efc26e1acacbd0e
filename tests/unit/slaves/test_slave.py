"""The slave record: what it accepts, what it refuses, how it moves."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from contiga.errors import MeshError
from contiga.slaves.mesh_summary import mesh_summary
from contiga.slaves.slave import Slave

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], float)
FACETS = np.array([[0, 1, 2], [0, 2, 3]])


def test_area_comes_from_the_facets_and_loose_points_are_not_active():
    slave = Slave(SQUARE, FACETS)
    assert slave.area == pytest.approx([1 / 3, 1 / 6, 1 / 3, 1 / 6, 0])
    assert slave.active.tolist() == [True, True, True, True, False]
    assert slave.facets.dtype == np.int32


def test_cloud_has_no_area_and_is_active_throughout():
    slave = Slave(SQUARE)
    assert slave.area is None
    assert slave.facets is None
    assert slave.thickness is None
    assert slave.mass is None
    assert slave.active.all()


def test_quadrilateral_facets_are_split():
    slave = Slave(SQUARE, [[0, 1, 2, 3]])
    assert slave.facets.shape == (2, 3)
    assert slave.area.sum() == pytest.approx(1.0)


def test_arrays_are_copies_that_cannot_be_written():
    points = SQUARE.copy()
    slave = Slave(points, FACETS, thickness=np.ones(5), mass=np.ones(5))
    points[0] = 99.0
    assert slave.points[0].tolist() == [0.0, 0.0, 0.0]
    for array in (slave.points, slave.facets, slave.area, slave.thickness, slave.mass):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        slave.active[0] = False
    with pytest.raises(AttributeError, match="immutable"):
        slave.points = points
    with pytest.raises(AttributeError, match="immutable"):
        del slave.area


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"points": np.empty((0, 3))}, "no nodes"),
        ({"points": [[0, 0, 0], [0, np.nan, 0], [np.inf, 0, 0]]}, "2 node.*first row 1"),
        ({"facets": [[0, 1, 5]]}, r"facet 0 names a point.*0 to 4"),
        ({"facets": [[0, 1, 2], [-1, 1, 2]]}, "facet 1 names a point"),
        ({"facets": [[0, 1]]}, "rows of 3 or 4"),
        ({"facets": [[0.0, 1.0, 2.0]]}, "whole numbers"),
        ({"area": np.ones(4)}, r"area must be one number, or one a point.*\(4,\).*\(5,\)"),
        ({"area": [1, 1, 1, 1, -1]}, "area of point 4 is negative"),
        ({"thickness": [1, 1, np.nan, 1, 1]}, "thickness of point 2"),
        ({"thickness": [1, -1e-9, 1, 1, 1]}, "thickness of point 1"),
        ({"mass": ["heavy"] * 5}, "mass must be an array of numbers"),
        ({"active": [1, 0, 1, 0, 1]}, "expected one boolean"),
        ({"active": [True, False]}, "expected one boolean"),
    ],
)
def test_what_does_not_fit_is_refused_with_what_is_allowed(arguments, message):
    with pytest.raises(MeshError, match=message) as caught:
        Slave(**{"points": SQUARE, "name": "pad", **arguments})
    assert str(caught.value).startswith("pad")


def test_rotation_keeps_areas_and_moves_points():
    turn = np.array([[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]], float)
    slave = Slave(SQUARE, FACETS, thickness=np.full(5, 2.0), mass=np.full(5, 3.0))
    moved = slave.transformed(turn)
    assert moved.points[1] == pytest.approx([10, 21, 30])
    assert moved.area == pytest.approx(slave.area)
    assert moved.thickness == pytest.approx(slave.thickness)
    assert moved.active.tolist() == slave.active.tolist()


def test_scaling_scales_lengths_areas_and_thickness_but_not_mass():
    area = np.arange(5.0)
    slave = Slave(SQUARE, area=area, thickness=np.full(5, 2.0), mass=np.full(5, 3.0), unit="m")
    scaled = slave.scaled(1000.0, "mm")
    assert scaled.points == pytest.approx(1000.0 * SQUARE)
    assert scaled.area == pytest.approx(1e6 * area)
    assert scaled.thickness == pytest.approx(2000.0)
    assert scaled.mass == pytest.approx(3.0)
    assert scaled.unit == "mm"
    by_matrix = slave.transformed(np.diag([1000.0, 1000.0, 1000.0, 1.0]))
    assert by_matrix.area == pytest.approx(scaled.area)
    assert by_matrix.thickness == pytest.approx(scaled.thickness)


def test_mirror_keeps_normals_on_the_same_side():
    slave = Slave(SQUARE, FACETS)
    mirrored = slave.transformed(np.diag([-1.0, 1.0, 1.0, 1.0]))
    a, b, c = (mirrored.points[mirrored.facets[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()


@pytest.mark.parametrize(
    "matrix",
    [
        np.diag([1.0, 2.0, 1.0, 1.0]),
        np.diag([0.0, 0.0, 0.0, 1.0]),
        np.eye(3),
        np.full((4, 4), np.nan),
        np.diag([1.0, 1.0, 1.0, 2.0]),
    ],
)
def test_a_transform_that_is_no_similarity_is_refused(matrix):
    with pytest.raises(MeshError):
        Slave(SQUARE, FACETS).transformed(matrix)


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_a_scale_that_is_not_positive_is_refused(factor):
    with pytest.raises(MeshError, match="scale"):
        Slave(SQUARE).scaled(factor)


def test_bounds_are_of_the_active_points():
    assert Slave(SQUARE).bounds().tolist() == [[0, 0, 0], [5, 5, 5]]  # all of a cloud
    assert Slave(SQUARE, FACETS).bounds().tolist() == [[0, 0, 0], [1, 1, 0]]
    nothing = Slave(SQUARE, active=np.zeros(5, dtype=bool))
    assert nothing.bounds().tolist() == [[0, 0, 0], [5, 5, 5]]


def test_a_slave_survives_pickling():
    slave = Slave(SQUARE, FACETS, mass=np.ones(5), name="pad", cells={"quad": 1})
    again = pickle.loads(pickle.dumps(slave))
    assert np.array_equal(again.points, slave.points)
    assert np.array_equal(again.facets, slave.facets)
    assert (again.name, dict(again.cells)) == ("pad", {"quad": 1})


def test_summary_counts_and_measures():
    slave = Slave(SQUARE, FACETS, thickness=[1, 2, 3, 4, 0], mass=np.ones(5), name="pad", unit="m")
    summary = mesh_summary(slave)
    assert summary["nodes"] == 5
    assert summary["active_nodes"] == 4
    assert summary["facets"] == 2
    assert summary["area"] == pytest.approx(1.0)
    assert summary["thickness"] == [1.0, 4.0]  # of the active nodes
    assert summary["mass"] == 5.0
    assert summary["bounds"] == [[0, 0, 0], [1, 1, 0]]  # of the active nodes
    assert summary["unit"] == "m"
    assert mesh_summary(Slave(SQUARE))["area"] is None
