"""Certificates of feet on and beside the edges of trimmed faces; branches that end at folds."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full
from tests.unit.search.folds import trimmed_fold

import contiga as cg
from contiga.statuses import Feature, Status

TURNS = [1e-5, 1e-3, 0.1, 1.0, np.pi / 2, 2.5]
JUMP = 100.0
"""A foot that goes so many times as far as its point has jumped."""


def foot_on_fold(p, turn):
    """Feet on the fold of points above it."""
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)
    down = np.maximum(c * np.abs(p[:, 0]) - s * p[:, 2], 0.0)
    return np.column_stack([c * down * np.sign(p[:, 0]), p[:, 1], -s * down])


def above_fold(n, turn, rng):
    """Points above the fold, near its edge: a third over it, a third over either face."""
    height = rng.uniform(0.02, 0.2, n)
    angle = rng.uniform(-0.5, 0.5, n) * turn
    p = np.column_stack([height * np.sin(angle), rng.uniform(-0.5, 0.5, n), height * np.cos(angle)])
    side, half = rng.choice([-1.0, 1.0], n), 0.5 * turn
    out = np.column_stack([side * np.sin(half), 0.0 * height, np.full(n, np.cos(half))])
    down = np.column_stack([side * np.cos(half), 0.0 * height, np.full(n, -np.sin(half))])
    over = rng.random(n) < 0.67
    aside = rng.uniform(0.0, 0.1, (n, 1))
    p[over] = (aside * down + height[:, None] * out + [0.0, 1.0, 0.0] * p)[over]
    return p, height


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("gap", [0.0, 6e-6])
@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.1, 0.4])
def test_feet_over_the_outer_side_of_a_trimmed_edge_are_certified(turn, gap, size):
    """On a face or on the edge, from one to the other, along it: steps to 0.4 of the height."""
    rng = np.random.default_rng(1)
    body = trimmed_fold(turn, gap)
    a, height = above_fold(400, turn, rng)
    way = rng.normal(size=a.shape)
    b = a + size * height[:, None] * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    off = np.linalg.norm(feet.point - foot_on_fold(b, turn), axis=1)
    assert off.max() <= 1e-6 * height.max() + 2.0 * gap
    assert off[feet.certified == 1].max() <= 5e-9 + 2.0 * gap
    assert (feet.status == Status.OK).all()
    assert feet.certified.mean() >= 0.99
    if turn > 0.5:
        assert (start.feature == Feature.EDGE).sum() > 30


@pytest.mark.parametrize("turn", [0.1, 1.0, np.pi / 2])
@pytest.mark.parametrize("steps", [1, 8, 100])
def test_a_foot_that_runs_into_a_trimmed_fold_is_an_event(turn, steps):
    """From below one face of a roof towards the other: there the foot goes on, farther in."""
    body = trimmed_fold(turn)
    half = 0.5 * turn
    down = np.array([np.cos(half), 0.0, -np.sin(half)])
    below = np.array([-np.sin(half), 0.0, -np.cos(half)])
    path = [0.3 * down + 0.1 * below, -0.05 * down + 0.1 * below]
    feet = body.project(path[0][None])
    np.testing.assert_allclose(feet.point, [0.3 * down], atol=1e-10)
    events, proved = [], []
    for t in np.linspace(0.0, 1.0, steps + 1)[1:]:
        p = path[0] + t * (path[1] - path[0])
        feet = body.project(p[None], start=feet, mode="track")
        events.append(feet.status[0] == Status.BRANCH_EVENT)
        proved.append(feet.certified[0] == 1)
    over = int(np.ceil(0.3 / 0.35 * steps)) - 1
    assert [k for k in range(steps) if events[k]] == [over]
    assert [k for k in range(steps) if not proved[k]] == [over]
    assert feet.point[0, 0] < 0.0  # on the other face


@pytest.mark.parametrize("turn", [1e-8, 1e-6, 1e-4])
def test_nearly_smooth_folds_give_no_events(turn):
    body = trimmed_fold(turn)
    rng = np.random.default_rng(2)
    a = np.column_stack(
        [rng.uniform(-0.05, 0.05, 300), rng.uniform(-0.5, 0.5, 300), np.full(300, -0.1)]
    )
    start = body.project(a)
    for size in (1e-3, 0.1):
        way = rng.normal(size=a.shape)
        b = a + size * way / np.linalg.norm(way, axis=1)[:, None]
        feet = body.project(b, start=start, mode="track")
        assert (feet.status == Status.OK).all()
        if turn <= 1e-6:
            assert feet.certified.mean() >= 0.99


@pytest.mark.parametrize("gap", [0.0, 1e-7])
@pytest.mark.parametrize("off", [1e-4, 1e-6, -1e-6, 3e-7, -3e-7, 1e-8, -1e-8])
def test_a_path_that_goes_in_very_near_an_edge_is_not_certified_on_the_wrong_face(gap, off):
    """On which side of the edge it passes decides which of two minima the foot stays on."""
    body = trimmed_fold(np.pi / 2, gap)
    out = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]) / np.sqrt(2.0)  # normals, left and right
    rng = np.random.default_rng(4)
    before, after = rng.uniform(0.001, 0.1, (2, 200, 1)), rng.uniform(-0.1, -0.001, (2, 200, 1))
    share = before[0] / (before[0] - after[0])
    # Past the left plane `off` above the right one.
    before[1] = (off - share * after[1]) / (1.0 - share)
    y = rng.uniform(-0.3, 0.3, (200, 1)) * [0.0, 1.0, 0.0]
    a, b = (p[0] * out[0] + p[1] * out[1] + y for p in (before, after))
    outside = before[1, :, 0] > 0.0
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    on = after[0] * out[0] if off > 0.0 else after[1] * out[1]
    proved = (feet.certified == 1) & outside
    miss = np.linalg.norm(feet.point - on - y, axis=1)
    assert miss[proved].max(initial=0.0) <= 1e-9 + 2.0 * gap
    if abs(off) == 1e-4:
        assert proved[outside].mean() > 0.95


def continued(body, start, a, b, steps=400):
    """Feet after many tiny steps, and which of them never jumped."""
    feet, stays = start, np.ones(len(a), bool)
    for k in range(1, steps + 1):
        new = body.project(a + k / steps * (b - a), start=feet, mode="track")
        way = np.linalg.norm(new.point - feet.point, axis=1)
        stays &= way <= JUMP / steps * np.linalg.norm(b - a, axis=1) + 1e-6 * body.size
        stays &= new.status == Status.OK
        feet = new
    return feet.point, stays


def about_edges(body, n, rng, reach):
    """Points on both sides of a body, near its edges."""
    at = []
    for _ in range(n):
        curve = body.edges[rng.integers(len(body.edges))].curve
        low, high = curve.domain
        at.append(curve.evaluate([rng.uniform(low, high)])[0])
    off = rng.normal(size=(n, 3))
    off /= np.linalg.norm(off, axis=1)[:, None]
    return np.array(at) + reach * 10.0 ** rng.uniform(-3.0, 0.0, (n, 1)) * off


SHARES = {"crossing_bores": 0.9, "cup": 0.9, "slot": 0.9, "lens": 0.9, "link_rod": 0.9}


QUICK = (("lens", 0.1), ("cup", 1e-2), ("slot", 1e-3), ("crossing_bores", 1e-2))
OTHERS = [(name, size) for name in SHARES for size in (1e-3, 1e-2, 0.1)]


@pytest.mark.parametrize(
    ("name", "size"), [*QUICK, *full(*(one for one in OTHERS if one not in QUICK))]
)
def test_what_is_certified_beside_the_edges_of_a_solid_is_where_tiny_steps_lead(
    name, size, solids, tmp_path
):
    body = cg.read_cad(solids.write(solids.SOLIDS[name](), tmp_path / "solid.step"))
    rng = np.random.default_rng(3)
    a = about_edges(body, 300, rng, 0.05 * body.size)
    way = rng.normal(size=a.shape)
    b = a + size * body.size * way / np.linalg.norm(way, axis=1)[:, None]
    start = body.project(a)
    feet = body.project(b, start=start, mode="track")
    proved = (feet.certified == 1) & (feet.status == Status.OK) & (start.status == Status.OK)
    point, stays = continued(body, start, a, b, 200)
    assert stays[proved].all()
    np.testing.assert_allclose(feet.point[proved], point[proved], atol=2e-6 * body.size)
    events = feet.status == Status.BRANCH_EVENT
    assert not stays[events].any()
    if size <= 1e-2:
        assert (proved | events).mean() >= SHARES[name]
