"""The sequences of the thesis, on geometries designed so that every step has a closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contiga.records import ContactStatus as Is

UNITS = '[units]\nlength = "m"\nmass = "kg"\ntime = "s"\n'
FLAT = '[output]\nformats = ["csv"]\nreport = false\n'


def test_cylinder_cloud_through_a_flat_master(run_scene: Callable, physics: Callable) -> None:
    """Table 5.1: 20, 60, 80, 100, 100, 100, 100, 60, 40 points in contact at steps 6 to 14."""
    run = run_scene("cylinder_flat")
    physics(run)
    counts = run.history["n_contact"]
    assert counts[6:15].tolist() == [20, 60, 80, 100, 100, 100, 100, 60, 40]
    assert counts[:6].tolist() == 6 * [0]
    assert counts[15] == 0
    for k, state in enumerate(run.states):
        expected = np.maximum(-run.points(k)[:, 2], 0.0)
        np.testing.assert_allclose(state.penetration, expected, rtol=0, atol=1e-14)
        # Eq. 3.1 and 3.3: half the greatest penetration, shared by penetration and area.
        total = 0.5 * expected.max()
        assert run.history["force"][k] == pytest.approx(total, abs=1e-13)
        if total > 0.0:
            weights = expected * state.area
            shares = total * weights / weights.sum()
            np.testing.assert_allclose(state.force[:, 2], shares, rtol=0, atol=1e-14)


def test_master_with_two_bumps_and_points_beyond_it(run_scene: Callable, physics: Callable) -> None:
    """Fig. 5.20: two groups of feet that stay apart; nothing touches beyond the border."""
    run = run_scene("out_of_boundary")
    physics(run)
    (patch,) = run.body.patches
    side = np.zeros(len(run.points(0)))
    for k, state in enumerate(run.states):
        p, on = run.points(k), state.in_contact
        over = (p[:, 0] > 0.0) & (p[:, 0] < 4.0) & (p[:, 1] > 0.0) & (p[:, 1] < 3.0)
        assert not on[~over].any()
        # a foot and its penetration belong together, and the foot is on the master
        np.testing.assert_allclose(
            state.foot[on] - state.penetration[on, None] * state.normal[on], p[on], atol=1e-11
        )
        np.testing.assert_allclose(patch.evaluate(state.uv[on]), state.foot[on], atol=1e-12)
        now = np.sign(state.foot[:, 0] - 2.0) * on
        assert (now * side >= 0.0).all()
        side = np.where(on, now, side)
    peak = run.states[run.peak]
    x = peak.foot[peak.in_contact, 0]
    assert ((x < 1.7) | (x > 2.3)).all()
    assert min((x < 2.0).sum(), (x > 2.0).sum()) > 100
    assert (run.points(run.peak)[:, 1] < 0.0).sum() > 100


def test_contact_with_two_bumps_begins_where_the_height_says(run_scene: Callable) -> None:
    """Points are in contact exactly while they are below the master's height over them."""
    run = run_scene("out_of_boundary")
    (patch,) = run.body.patches
    u = np.linspace(0.0, 1.0, 4001)
    x_of_u = patch.evaluate(np.column_stack([u, 0.5 + 0.0 * u]))[:, 0]
    for k, state in enumerate(run.states):
        p = run.points(k)
        over = (p[:, 1] > 0.0) & (p[:, 1] < 3.0)
        uv = np.column_stack([np.interp(p[:, 0], x_of_u, u), p[:, 1] / 3.0])[over]
        height = p[over, 2] - patch.evaluate(uv)[:, 2]
        clear = np.abs(height) > 1e-5
        np.testing.assert_array_equal(state.in_contact[over][clear], height[clear] < 0.0)


def test_bumpy_master_with_points_out_of_its_boundary(
    run_case: Callable, physics: Callable
) -> None:
    """Points beside the plate never touch; those over it do when they are below its height."""
    table = [[t, 0.0, 0.0, -0.012 * min(t, 20.0 - t)] for t in np.arange(21.0).tolist()]
    run = run_case(f"""
title = "Cloud pressed into a bumpy plate"
{UNITS}
[time]
end = 20.0
step = 1.0
[[body]]
name = "plate"
geometry = {{ shape = "bumpy_plate", width = 2.0, length = 2.0, amplitude = 0.05, waves = 2 }}
[[slave]]
name = "cloud"
points = {{ sample = {{ shape = "plane", width = 2.6, length = 2.6, nu = 40, nv = 40 }}, \
transform = [{{ translate = [0.003, 0.001, 0.06] }}] }}
motion = {{ kind = "translate", table = {table} }}
[[contact]]
master = "plate"
slave = "cloud"
law = {{ kind = "force", curve = [[0, 0], [1, 0.5]] }}
area = {{ kind = "constant", value = 0.1 }}
{FLAT}""")
    physics(run, slides_off=True)
    (patch,) = run.body.patches
    slope = 2.0 * np.pi * 0.05 * np.sqrt(2.0)
    for k, state in enumerate(run.states):
        p = run.points(k)
        over = (np.abs(p[:, :2]) <= 1.0).all(axis=1)
        assert not state.in_contact[~over].any()
        height = np.full(len(p), np.inf)
        height[over] = p[over, 2] - patch.evaluate(p[over, :2] / 2.0 + 0.5)[:, 2]
        # Feet lie at most slope · depth aside: nearer to the border a point may have slid off.
        margin = 1.0 - np.abs(p[:, :2]).max(axis=1)
        inner = over & (margin > slope * np.maximum(-height, 0.0) + 1e-9)
        np.testing.assert_array_equal(state.in_contact[inner], height[inner] < 0.0)
        # A distance is at most the height and at least its share by the steepest slope.
        on = state.in_contact
        assert (state.penetration[on] <= -height[on] + 1e-12).all()
        lowest = -height[on] / np.sqrt(1.0 + slope**2)
        assert (state.penetration[on] >= 0.9 * lowest).all()
    counts = run.history["n_contact"]
    assert counts[10] > 700
    assert counts[[0, -1]].tolist() == [0, 0]


def test_points_that_slide_sideways_out_of_the_boundary(
    run_scene: Callable, physics: Callable
) -> None:
    """Fig. 5.21: 68 points in contact, then the outermost two leave over the border: 68 → 66."""
    run = run_scene("sideways_sliding")
    physics(run, slides_off=True)
    below = [run.points(k)[:, 2] < 0.0 for k in range(17)]
    over = [run.points(k)[:, 0] >= -1.0 for k in range(17)]
    expected = [int((b & o).sum()) for b, o in zip(below, over, strict=True)]
    assert run.history["n_contact"].tolist() == expected
    assert expected == 3 * [0] + 11 * [68] + [66, 64, 64]
    assert run.history["n_slid_off"].tolist() == 14 * [0] + [2, 2, 0]
    # The force model's total does not depend on how many points carry it.
    np.testing.assert_allclose(run.history["force"][4:], 0.025, rtol=1e-12)


def test_nodes_through_a_curve_follow_their_local_minimum(
    run_scene: Callable, physics: Callable
) -> None:
    """Fig. 5.14 to 5.17: none, two, three nodes; at t = 6 the other branch is closer to some."""
    run = run_scene("curve_sequence")
    physics(run)
    assert run.history["n_contact"].tolist() == [0, 0, 0, 2, 3, 5, 5, 2, 0, 0]
    turned = []
    for k, state in enumerate(run.states):
        on = state.in_contact
        assert (state.normal[on, 1] < -0.9).all()
        normal = run.body.project(run.points(k)).normal
        turned.append(int((on & (normal[:, 1] > 0.0)).sum()))
    assert turned == [0, 0, 0, 0, 0, 0, 2, 0, 0, 0]


def test_point_in_space_follows_the_side_it_came_in_by(
    run_scene: Callable, physics: Callable
) -> None:
    """Fig. 5.18: the foot stays below while the closest point goes over to the top."""
    run = run_scene("point_in_space")
    physics(run)
    top = []
    for k, state in enumerate(run.states):
        if state.n_contact:
            assert state.normal[0, 2] < -0.9
            x, y, z = state.foot[0] / (2.0, 1.4, 0.4)
            assert x * x + y * y + z * z == pytest.approx(1.0, abs=1e-13)
            top.append(run.body.project(run.points(k)).normal[0, 2] > 0.0)
    assert top == 4 * [False] + 4 * [True]


def test_a_profile_keeps_its_local_minimum_where_the_global_one_jumps(
    run_case: Callable, physics: Callable
) -> None:
    """Fig. 5.16: past the middle of a thin part the closest side is the other one."""
    heights = [0.3, 0.25, 0.15, 0.05, -0.05, -0.1, -0.15, -0.19, -0.1, 0.05, 0.3]
    table = [[t, 0.1 * h, h, 0.0] for t, h in enumerate(heights)]
    run = run_case(f"""
title = "A point pressed into a thin profile"
{UNITS}
[time]
end = {len(heights) - 1}.0
step = 1.0
[[body]]
name = "blade"
geometry = {{ profile = {{ shape = "ellipse", axes = [2.0, 0.2] }}, depth = 1.0 }}
[[slave]]
name = "tip"
points = {{ coordinates = [[0.0, 0.0, 0.0]] }}
motion = {{ kind = "translate", table = {table} }}
[[contact]]
master = "blade"
slave = "tip"
law = {{ kind = "penalty", stiffness = 3.0 }}
area = {{ kind = "constant", value = 0.1 }}
{FLAT}""")
    physics(run)
    body = run.body
    for k, (state, h) in enumerate(zip(run.states, heights, strict=True)):
        jumped = body.project(run.points(k))
        inside = h < 0.2
        assert state.in_contact[0] == inside
        if not inside:
            continue
        # The foot stays above, with the normal up; the whole way down counts.
        assert state.normal[0, 1] > 0.99
        np.testing.assert_allclose(state.foot[0, 1], 0.2, rtol=0, atol=1e-3)
        assert state.penetration[0] == pytest.approx(0.2 - h, abs=1e-3)
        # On the ellipse, and the foot of its own normal.
        x, y = state.foot[0, :2]
        assert (x / 2.0) ** 2 + (y / 0.2) ** 2 == pytest.approx(1.0, abs=1e-12)
        across = (run.points(k)[0, 0] - x) * (-y / 0.04) + (run.points(k)[0, 1] - y) * (x / 4.0)
        assert abs(across) < 1e-10
        # The closest point is the other side's as soon as the middle is passed.
        assert (jumped.normal[0, 1] < 0.0) == (h < 0.0)
    statuses = [int(state.status[0]) for state in run.states]
    assert statuses == [Is.FREE, Is.FREE, Is.NEW] + 7 * [Is.OLD] + [Is.RELEASED]
