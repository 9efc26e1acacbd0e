"""Belts as laid: on their path, as long at rest as asked for, held where they are to be."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
PATH = cg.route(BALL, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], via=[[0.0, 0.0, 1.5]])
ELASTIC = cg.materials.Elastic(young=1e3, poisson=0.3)
LIKE = {"material": ELASTIC, "density": 1.0, "width": 0.2, "thickness": 0.01}


def belt(**changes: object) -> cg.Belt:
    return cg.Belt(**{"path": PATH, **LIKE, **changes})


@pytest.mark.parametrize("kind", ["bars", "ribbon"])
def test_nodes_lie_on_the_path_and_outside(kind: str) -> None:
    slave = belt(kind=kind, segments=60).slave
    gaps = BALL.project(slave.points).gap
    assert gaps.min() > 0.0
    rows = slave.points.reshape(61, -1, 3).mean(axis=1)
    np.testing.assert_allclose(rows, PATH.at(np.linspace(0, PATH.length, 61)), atol=1e-3)


def test_the_width_of_a_ribbon_is_across_the_path_and_along_the_surface() -> None:
    made = belt(kind="ribbon", segments=60, across=2)
    left, _, right = made.slave.points.reshape(61, 3, 3).transpose(1, 0, 2)
    wide = right - left
    np.testing.assert_allclose(np.linalg.norm(wide, axis=1), 0.2, rtol=1e-3)
    arc = np.linspace(0, PATH.length, 61)
    assert np.abs((wide * PATH.normal_at(arc)).sum(axis=1)).max() < 1e-3


def test_facets_of_a_ribbon_face_away_from_the_body() -> None:
    slave = belt(kind="ribbon", segments=30, across=3).slave
    a, b, c = slave.points[slave.facets].transpose(1, 0, 2)
    normals, middles = np.cross(b - a, c - a), (a + b + c) / 3.0
    assert ((normals * BALL.project(middles).normal).sum(axis=1) > 0.0).all()
    assert abs(slave.area.sum() / (0.2 * PATH.length) - 1.0) < 1e-2


@pytest.mark.parametrize("kind", ["bars", "ribbon"])
def test_a_shorter_belt_pulls_by_its_strain(kind: str) -> None:
    material = cg.materials.Elastic(young=1e3)
    made = belt(kind=kind, segments=50, shortening=0.01, material=material)
    simulation = cg.Simulation(
        bodies={},
        slaves={"belt": (made.slave, made.motion)},
        contacts=[],
        end=1.0,
        step="auto",
    )
    force = simulation.start().slaves["belt"].matter["force"][made.ends[0]].sum(axis=0)
    strain = 0.01 / 0.99
    green = strain + 0.5 * strain**2
    stress = 1e3 * green * (1.0 + strain) if kind == "ribbon" else 1e3 * strain
    assert abs(np.linalg.norm(force) / (0.2 * 0.01 * stress) - 1.0) < 1e-2
    assert made.rest_length == pytest.approx(0.99 * PATH.length)


def test_ends_are_held_by_the_ground_or_a_body_or_nothing() -> None:
    made = belt(anchors=("ball", "ground"))
    assert [one["body"] for one in made.motion.attached] == ["ball"]
    assert made.motion.fixed[0]["nodes"].tolist() == [40]
    assert belt(anchors=("free", "free")).motion.fixed is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("width", 0.0),
        ("thickness", -1.0),
        ("density", float("nan")),
        ("segments", 0),
        ("across", 1.5),
        ("shortening", 1.0),
        ("kind", "rope"),
    ],
)
def test_what_no_belt_has_is_named(key: str, value: object) -> None:
    with pytest.raises(cg.errors.InputError) as told:
        belt(**{key: value})
    assert told.value.where == key
