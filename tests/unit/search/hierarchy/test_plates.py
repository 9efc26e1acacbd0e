"""What the plates of leaves say of distances, against samples of the pieces they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.search.hierarchy.kernels import plates_nb
from contiga.search.tables import tables_of


@njit
def no_nearer_than(plate, point):
    return plates_nb.no_nearer_than(plate, point)


@njit
def is_beyond(plate, point, limit):
    return plates_nb.is_beyond(plate, point, limit)


@njit
def no_farther_than(plate, point):
    return plates_nb.no_farther_than(plate, point)


@njit
def on_plate(plate, point):
    return plates_nb.on_plate(plate, point)


BODIES = {
    "trimmed": holed_plate,
    "with poles": lambda: cg.Body([cg.shapes.sphere()]),
    "rational": lambda: cg.Body([cg.shapes.torus()]),
    "far off": lambda: cg.Body([cg.shapes.torus().translated([1e6, -2e6, 5e5])]),
}


def pieces(body):
    """Of every leaf of a face: its plate, and samples (n, 3) of its surface."""
    tables = tables_of(body)
    share = np.linspace(0.0, 1.0, 9)
    for leaf, plate in zip(tables.leaves, tables.plates, strict=True):
        if leaf["element"] < 0:
            continue
        box, e = leaf["box"], tables.elements.table[leaf["element"]]
        s, t = (0.5 + box[a] + share * (box[a + 1] - box[a]) for a in (0, 2))
        u = e["box"][0] + s * (e["box"][1] - e["box"][0])
        v = e["box"][2] + t * (e["box"][3] - e["box"][2])
        uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        yield plate, body.patches[e["patch"]].evaluate(uv)


@pytest.mark.parametrize("name", BODIES)
def test_no_sample_of_a_leaf_is_nearer_than_told_nor_all_of_them_farther(name):
    body = BODIES[name]()
    rng = np.random.default_rng(3)
    tight = []
    for plate, samples in pieces(body):
        width = np.ptp(samples, axis=0).max()
        away = width * 10.0 ** rng.uniform(-3.0, 2.0, (20, 1))
        for point in samples[rng.integers(len(samples), size=20)] + away * rng.normal(size=(20, 3)):
            nearest = np.linalg.norm(samples - point, axis=1).min()
            low = no_nearer_than(plate, tuple(point))
            assert low <= nearest
            assert not is_beyond(plate, tuple(point), nearest)
            assert is_beyond(plate, tuple(point), low - 1e-6 * abs(low) - 1e-9 * width)
            assert no_farther_than(plate, tuple(point)) >= nearest - 0.5 * width
            tight.append((nearest - low) / width)
    assert np.median(tight) < 0.2


def test_middles_lie_on_the_body_or_nowhere():
    body = holed_plate()
    tables = tables_of(body)
    there = np.isfinite(tables.plates["spare"])
    assert there[tables.leaves["element"] < 0].all()
    assert (~there).any()
    np.testing.assert_allclose(body.project(tables.plates["middle"][there]).gap, 0.0, atol=1e-9)


def test_trimming_curves_are_no_nearer_than_their_plates_tell():
    """The hole of the plate, found by its samples in each stretch's own box."""
    body = holed_plate()
    tables = tables_of(body)
    rng = np.random.default_rng(4)
    t = np.linspace(0.0, 2.0 * np.pi, 20_001)
    hole = body.patches[0].evaluate(0.5 + 0.2 * np.stack([np.cos(t), np.sin(t)], axis=-1))
    of_hole = 0
    for plate in tables.plates[tables.leaves["element"] < 0]:
        ends = plate["middle"] + np.outer([-1.0, 1.0], plate["x"])
        first, last = np.sort([np.linalg.norm(hole - x, axis=1).argmin() for x in ends])
        if last - first > 10_000 or np.linalg.norm(hole - plate["middle"], axis=1).min() > 1e-3:
            continue  # over the circle's own start, or a stretch of the outer border
        of_hole += 1
        samples = hole[first : last + 1]
        for point in plate["middle"] + 0.1 * rng.normal(size=(20, 3)):
            nearest = np.linalg.norm(samples - point, axis=1).min()
            assert no_nearer_than(plate, tuple(point)) <= nearest + 1e-7
    assert of_hole >= 8


def test_the_nearest_point_of_a_plate_is_that_of_a_fine_grid():
    x = np.linspace(-1.0, 1.0, 201)
    grid = np.stack(np.meshgrid(x, x), -1).reshape(-1, 2)
    rng = np.random.default_rng(5)
    plates = tables_of(BODIES["rational"]()).plates[:20]
    for plate in plates:
        point = plate["middle"] + rng.normal(size=3)
        on = plate["middle"] + grid @ [plate["x"], plate["y"]]
        exact = np.linalg.norm(on - point, axis=1).min()
        a, b, square = on_plate(plate, tuple(point))
        foot = plate["middle"] + a * plate["x"] + b * plate["y"]
        assert max(abs(a), abs(b)) <= 1.0
        np.testing.assert_allclose(np.linalg.norm(foot - point), np.sqrt(square), rtol=1e-9)
        assert exact - 0.01 <= np.sqrt(square) <= exact + 1e-12


@njit
def is_passed(plate, p, d, span, pad):
    return plates_nb.is_passed(plate, p, d, span, pad)


@pytest.mark.parametrize("name", BODIES)
def test_a_path_that_comes_to_a_sample_of_a_leaf_does_not_pass_it(name):
    body = BODIES[name]()
    rng = np.random.default_rng(6)
    passed = asked = 0
    for plate, samples in pieces(body):
        width = np.ptp(samples, axis=0).max()
        for goal in samples[rng.integers(len(samples), size=10)]:
            d = rng.normal(size=3)
            d /= np.linalg.norm(d)
            before, beyond = width * 10.0 ** rng.uniform(-3.0, 1.0, 2)
            p = tuple(goal - before * d)
            assert not is_passed(plate, p, tuple(d), (0.0, before + beyond), 0.0)
            asked += 1
            passed += is_passed(plate, p, tuple(d), (-beyond, before - width), 0.0)
    assert passed > 0.15 * asked
