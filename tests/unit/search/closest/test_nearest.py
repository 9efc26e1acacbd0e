"""Closest points that are guessed: never farther than what is searched for, and always the same."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.records import empty_projection
from contiga.search.balls import radii as ball
from contiga.search.closest.kernels import global_nb, global_scope_nb, nearest_nb
from contiga.search.hierarchy.kernels import plates_nb
from contiga.search.tables import tables_of
from contiga.statuses import Feature, Status

from .test_global import rough


@njit
def distances(tables, points):
    """By branch and bound alone."""
    h, found, out = np.empty((4, 6)), np.empty(4), np.empty(len(points))
    for k in range(len(points)):
        point = (points[k, 0], points[k, 1], points[k, 2])
        out[k] = global_nb.closest(tables, point, global_scope_nb.all_patches(), np.inf, found, h)
    return out


@njit
def nearest_leaf(tables, point):
    return nearest_nb.nearest_leaf(tables, point)


@njit
def on_plate(plate, point):
    return plates_nb.on_plate(plate, point)


def folded_sheet():
    """Two layers a fiftieth apart: the leaf of a voxel is as often as not on the wrong one."""
    s, y = np.meshgrid(np.linspace(-1.0, 1.0, 9), np.linspace(0.0, 1.0, 9), indexing="ij")
    net = np.stack([1.0 - s**2, y, 0.01 * np.sign(s) * np.abs(s) ** 0.25], axis=-1)
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, 7), np.ones(3)])
    return cg.Body([cg.NurbsSurface((3, 3), (knots, knots), net)])


BODIES = {
    "rough": lambda: cg.Body([rough(1)]),
    "trimmed": holed_plate,
    "with poles": lambda: cg.Body([cg.shapes.sphere()]),
    "rational": lambda: cg.Body([cg.shapes.torus()]),
    "folded": folded_sheet,
    "creased": lambda: cg.Body([cg.shapes.plane(centre=0.5 * n, axis=n) for n in AXES]),
}
AXES = (*np.eye(3), *-np.eye(3))


def points_about(body, n=400, seed=2):
    """Points on the body, beside it, about it and far off."""
    rng = np.random.default_rng(seed)
    on = np.concatenate([cg.clouds.random_on(p, n, seed=seed) for p in body.patches])
    on = on[rng.permutation(len(on))[:n]]
    middle, size = on.mean(axis=0), body.size
    beside = on + size * 10.0 ** rng.uniform(-12.0, -1.0, (n, 1)) * rng.normal(size=(n, 3))
    far = middle + size * 10.0 ** rng.uniform(-0.5, 3.0, (n, 1)) * rng.normal(size=(n, 3))
    return np.concatenate([on, beside, far])


def asked(body, p, balls=None, rows=None, within=None):
    """Feet by the kernels, with touching balls or without."""
    tables, out = tables_of(body), empty_projection(len(p))
    rows = np.arange(len(p), dtype=np.int32) if rows is None else rows
    within = np.full(len(rows), np.inf) if within is None else within
    if balls is None:
        nearest_nb.project_global(tables, p, rows, within, out, 0, len(rows))
    else:
        nearest_nb.project_proved(tables, balls, p, rows, within, out, 0, len(rows))
    return out


def same(a, b):
    for own, other in zip(a, b, strict=True):
        np.testing.assert_array_equal(own, other)


@pytest.mark.parametrize("name", BODIES)
def test_no_foot_is_farther_than_what_branch_and_bound_finds(name):
    body = BODIES[name]()
    p = points_about(body)
    feet, tables = asked(body, p), tables_of(body)
    away = np.linalg.norm(p - feet.point, axis=1)
    np.testing.assert_allclose(np.abs(feet.gap), away, rtol=1e-9, atol=1e-11 * body.size)
    least = distances(tables, p)
    assert (away <= least * (1.0 + 1e-12) + 2e-11 * body.size).all()
    # Where it ends in a corner, the smallest cells are off it by as much.
    assert (away >= least * (1.0 - 1e-12) - 1e-5 * body.size).all()
    on_face = feet.feature == Feature.FACE
    assert on_face.sum() > 200
    assert feet.certified[on_face].mean() > 0.99


@pytest.mark.parametrize("name", BODIES)
def test_touching_balls_change_no_bit(name):
    body = BODIES[name]()
    p = points_about(body, seed=3)
    same(asked(body, p, ball.balls_of(tables_of(body))), asked(body, p))


def test_feet_do_not_depend_on_who_asked_before_nor_on_what_is_known():
    body = cg.Body([rough(2)])
    p = points_about(body)
    first = asked(body, p)
    backwards = np.arange(len(p), dtype=np.int32)[::-1].copy()
    same(asked(cg.Body([rough(2)]), p, rows=backwards), first)
    away = np.linalg.norm(p - first.point, axis=1)
    told = asked(body, p, within=away)
    np.testing.assert_allclose(told.gap, first.gap, rtol=0, atol=1e-11 * body.size)
    np.testing.assert_array_equal(told.status, first.status)


def test_seeds_are_leaves_nearest_to_the_middles_of_voxels():
    body = cg.Body([rough(3)])
    tables = tables_of(body)
    assert (tables.seeds.leaf == -1).all()
    p = points_about(body)
    asked(body, p)
    at = np.flatnonzero(tables.seeds.leaf >= 0)
    assert 20 < len(at) <= len(p)
    middles = np.stack(np.unravel_index(at, tables.seeds.voxels), axis=-1) + 0.5
    middles = tables.seeds.low + middles / tables.seeds.scale[0]
    for k, middle in zip(at, middles, strict=True):
        away = np.sqrt([on_plate(plate, tuple(middle))[2] for plate in tables.plates])
        # A plate may reach out of the box of its leaf, by which it is looked for.
        assert away[tables.seeds.leaf[k]] <= away.min() + tables.plates["departure"][away.argmin()]
    inside = (np.abs(p - tables.seeds.low) * tables.seeds.scale[0] < tables.seeds.voxels).all(
        axis=1
    )
    nearest = np.abs(p[inside][:, None] - middles).max(axis=2).min(axis=1)
    assert (nearest <= (0.5 + 1e-9) / tables.seeds.scale[0]).sum() > 0.5 * inside.sum()


def test_a_body_without_leaves_of_faces_has_no_seed():
    tables = tables_of(holed_plate())
    curves = tables.leaves.copy()
    curves["element"] = -1
    assert nearest_leaf(tables._replace(leaves=curves), (0.0, 0.0, 0.0)) == -1
    assert nearest_leaf(tables, (0.0, 0.0, 0.0)) >= 0


def test_points_that_are_no_numbers_are_told():
    body = cg.Body([cg.shapes.torus()])
    p = points_about(body, 5)
    p[3, 1], p[7, 0] = np.nan, np.inf
    for balls in (None, ball.balls_of(tables_of(body))):
        feet = asked(body, p, balls)
        wrong = feet.status == Status.NOT_FINITE
        assert np.flatnonzero(wrong).tolist() == [3, 7]
        assert (feet.patch[wrong] == -1).all()


def test_balls_are_worked_out_once_they_are_worth_it(monkeypatch):
    body = cg.Body([cg.shapes.torus()])
    tables = tables_of(body)
    monkeypatch.setattr(ball, "MIN_POINTS", 100)
    assert ball.balls_if_they_pay(tables, 60) is None
    known = ball.balls_if_they_pay(tables, 60)
    assert known is ball.balls_of(tables)
    assert ball.balls_if_they_pay(tables_of(cg.Body([cg.shapes.sphere()])), 60) is None
