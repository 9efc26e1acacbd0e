"""Belts as laid: on their path, as long at rest as asked for, held where they are to be."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import contiga as cg
from contiga.belts import BeltEnd, LoadLimiter

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
PATH = cg.route(BALL, [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], via=[[0.0, 0.0, 1.5]])
ELASTIC = cg.materials.Elastic(young=1e3, poisson=0.3)
LIKE = {"material": ELASTIC, "density": 1.0, "width": 0.2, "thickness": 0.01}


def belt(**changes: object) -> cg.Belt:
    return cg.Belt(**{"path": PATH, **LIKE, **changes})


@pytest.mark.parametrize("kind", ["bars", "ribbon", "membrane"])
def test_nodes_lie_on_the_path_and_outside(kind: str) -> None:
    slave = belt(kind=kind, segments=60).slave
    gaps = BALL.project(slave.points).gap
    assert gaps.min() > 0.0
    count = 181 if kind == "membrane" else 61
    rows = slave.points.reshape(count, -1, 3).mean(axis=1)
    off, _ = cKDTree(PATH.at(np.linspace(0, PATH.length, 20_000))).query(rows)
    assert off.max() < 1e-3
    np.testing.assert_allclose(rows[[0, -1]], PATH.points[[0, -1]], atol=1e-3)


def test_the_width_of_a_ribbon_is_across_the_path_and_along_the_surface() -> None:
    made = belt(kind="ribbon", segments=60, across=2)
    left, _, right = made.slave.points.reshape(61, 3, 3).transpose(1, 0, 2)
    wide = right - left
    np.testing.assert_allclose(np.linalg.norm(wide, axis=1), 0.2, rtol=1e-3)
    arc = np.linspace(0, PATH.length, 61)
    assert np.abs((wide * PATH.normal_at(arc)).sum(axis=1)).max() < 1e-3


@pytest.mark.parametrize("kind", ["ribbon", "membrane"])
def test_facets_face_away_from_the_body(kind: str) -> None:
    slave = belt(kind=kind, segments=30, across=3).slave
    a, b, c = slave.points[slave.facets].transpose(1, 0, 2)
    normals, middles = np.cross(b - a, c - a), (a + b + c) / 3.0
    assert ((normals * BALL.project(middles).normal).sum(axis=1) > 0.0).all()
    assert abs(slave.area.sum() / (0.2 * PATH.length) - 1.0) < 1e-2


@pytest.mark.parametrize("kind", ["bars", "ribbon", "membrane"])
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
    surfaces = made.slave.surfaces
    end = made.ends[0] if surfaces is None else surfaces.net.edge("u0")
    force = simulation.start().slaves["belt"].matter["force"][end].sum(axis=0)
    strain = 0.01 / 0.99
    green = strain + 0.5 * strain**2
    stress = 1e3 * strain if kind == "bars" else 1e3 * green * (1.0 + strain)
    assert abs(np.linalg.norm(force) / (0.2 * 0.01 * stress) - 1.0) < 1e-2
    assert made.rest_length == pytest.approx(0.99 * PATH.length)


@pytest.mark.parametrize("kind", ["ribbon", "membrane"])
def test_rows_in_a_crease_stay_straight_and_turn_slowly(kind: str) -> None:
    bodies = [
        cg.Body([cg.shapes.ellipsoid(axes=(1.15, 1.65, 2.1), centre=(0, 0, 1.5))], name="chest"),
        cg.Body([cg.shapes.ellipsoid(axes=(1.2, 1.6, 1.4), centre=(0.1, 0, -0.6))], name="belly"),
    ]
    way = [-2.6, -1.7, 3.3], [-1.5, 2.3, -1.2], [[1.4, -0.4, 1.5], [1.5, 0.6, 0.0]]
    path = cg.route(bodies, *way)
    slave = belt(path=path, kind=kind, segments=60, width=0.46, across=2).slave
    rows = slave.points.reshape(181 if kind == "membrane" else 61, -1, 3)
    wide = rows[:, -1] - rows[:, 0]
    np.testing.assert_allclose(np.linalg.norm(wide, axis=1), 0.46, rtol=2e-2)
    wide /= np.linalg.norm(wide, axis=1)[:, None]
    assert (wide[1:] * wide[:-1]).sum(axis=1).min() > np.cos(np.radians(15.0))
    assert all(body.project(slave.points).gap.min() > 0.0 for body in bodies)


@pytest.mark.parametrize("kind", ["bars", "ribbon", "membrane"])
def test_webbing_at_an_end_is_a_straight_spring_to_the_last_row(kind: str) -> None:
    made = belt(
        kind=kind,
        anchors=("ball", "ground"),
        start=BeltEnd(length=0.5, curve=10.0, limiter=LoadLimiter(3.0)),
        shortening=0.01,
    )
    (spring,) = made.springs.values()
    assert (spring.name, spring.between) == ("belt start", ("ball", "belt"))
    assert spring.length == pytest.approx(0.495)
    assert spring.devices.limiter is not None
    np.testing.assert_allclose(spring.at, PATH.at([0.0, 0.5]), atol=1e-3)
    nodes, shares = spring.spread[1]
    np.testing.assert_array_equal(nodes, made.ends[0])
    np.testing.assert_allclose(shares @ made.slave.points[nodes], spring.at[1], atol=1e-12)
    assert shares.sum() == pytest.approx(1.0)
    assert made.laid_length == pytest.approx(PATH.length - 0.5)
    assert made.motion.attached == []
    assert made.motion.fixed is not None


def test_webbing_at_an_end_of_bars_is_as_stiff_as_these() -> None:
    webbing = cg.materials.Belt(
        loading=[[0.0, 0.0], [0.1, 30.0]], unloading=[[0.0, 0.0], [0.1, 10.0]],
        hysteresis_slope=400.0,
    )  # fmt: skip
    (spring,) = belt(material=webbing, start=BeltEnd(length=0.5)).springs.values()
    assert spring.curve(0.05) == pytest.approx(30.0)
    ends = np.array([[0.0, 0.0, 0.0], [0.525, 0.0, 0.0]])
    assert spring.start(ends, np.zeros((2, 3))).force == pytest.approx(15.0)
    (spring,) = belt(end=BeltEnd(length=0.5)).springs.values()
    assert spring.curve(0.5) == pytest.approx(1e3 * 0.2 * 0.01)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"start": BeltEnd(length=2.0)}, "start.length: this webbing would lie on a body"),
        ({"end": BeltEnd(length=1.8)}, "end.length: this webbing would lie on a body"),
        (
            {"start": BeltEnd(length=3.0), "end": BeltEnd(length=3.0)},
            "leaves nothing of the belt between",
        ),
        ({"start": BeltEnd(length=0.5), "anchors": ("free", "ground")}, r"anchors\[0\]: webbing"),
    ],
)
def test_webbing_that_is_nowhere_is_refused(changes: dict[str, object], said: str) -> None:
    with pytest.raises(cg.errors.InputError, match=said):
        belt(**changes)


def test_webbing_without_a_curve_is_for_bars() -> None:
    with pytest.raises(cg.errors.InputError, match=r"start.curve: is missing"):
        assert belt(kind="ribbon", start=BeltEnd(length=0.5)).springs
    with pytest.raises(cg.errors.InputError, match="curve: is missing: an unloading"):
        BeltEnd(length=0.5, unloading=1.0)


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
