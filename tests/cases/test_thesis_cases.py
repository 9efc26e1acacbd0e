"""The sequences of the thesis, on geometries designed so that every step has a closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contiga.records import ContactStatus as Is

UNITS = '[units]\nlength = "m"\nmass = "kg"\ntime = "s"\n'
FLAT = '[output]\nformats = ["csv"]\nreport = false\n'

# Five rows of twenty points on the underside of a cylinder of radius 1, a little turned, so that
# no two rows come through together; the table then takes 1, 3, 4, 5 … 3, 2 of them through.
ANGLES = np.deg2rad([-36.0, -16.0, 4.0, 24.0, 44.0])
ROWS = 1.0 - np.cos(ANGLES)


def _travel(rows_below: list[int]) -> list[float]:
    """Depth of the lowest point that leaves so many rows below the plane."""
    heights = np.sort(ROWS)
    ends = np.concatenate([[heights[0] - 0.1], heights, [heights[-1] + 0.1]])
    return [float(0.5 * (ends[k] + ends[k + 1])) for k in rows_below]


def test_cylinder_cloud_through_a_flat_master(run_case: Callable, physics: Callable) -> None:
    """Table 5.1: 20, 60, 80, 100, 100, 100, 100, 60, 40 points in contact at steps 6 to 14."""
    rows = [0, 0, 0, 0, 0, 0, 1, 3, 4, 5, 5, 5, 5, 3, 2, 0]
    depths = _travel(rows)
    y = np.linspace(-0.95, 0.95, 20)
    x, z = np.sin(ANGLES), 1.0 - np.cos(ANGLES)
    points = [[a, b, c] for a, c in zip(x, z, strict=True) for b in y]
    table = [[t, 0.0, 0.0, -d] for t, d in enumerate(depths)]
    run = run_case(f"""
title = "Cylinder cloud through a flat master"
{UNITS}
[time]
end = 15.0
step = 1.0
[[body]]
name = "plate"
geometry = {{ shape = "plane", width = 4.0, length = 4.0 }}
[[slave]]
name = "cylinder"
points = {{ coordinates = {np.array(points).tolist()} }}
motion = {{ kind = "translate", table = {table} }}
[[contact]]
master = "plate"
slave = "cylinder"
law = {{ kind = "force", curve = 0.5 }}
area = {{ kind = "constant", value = 0.1 }}
{FLAT}""")
    physics(run)
    counts = run.history["n_contact"]
    assert counts[6:15].tolist() == [20, 60, 80, 100, 100, 100, 100, 60, 40]
    assert counts[:6].tolist() == 6 * [0]
    assert counts[15] == 0
    for k, (state, depth) in enumerate(zip(run.states, depths, strict=True)):
        expected = np.maximum(depth - np.repeat(z, 20), 0.0)
        np.testing.assert_allclose(state.penetration, expected, rtol=0, atol=1e-14)
        # Eq. 3.1 and 3.3: half the greatest penetration, shared by penetration.
        total = 0.5 * expected.max()
        assert run.history["force"][k] == pytest.approx(total, abs=1e-13)
        if total > 0.0:
            shares = total * expected / expected.sum()
            np.testing.assert_allclose(state.force[:, 2], shares, rtol=0, atol=1e-14)
    # Widths of the strip in contact, 1 : 3 : 5 rows.
    rows_in = [int((s.penetration > 0).sum()) // 20 for s in run.states]
    assert rows_in == rows


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
    run_case: Callable, physics: Callable
) -> None:
    """Sixty-eight points in contact, then the outermost two leave over the border: 68 → 66."""
    x = -1.0 + 0.04 * np.arange(34.0)
    points = [[a, b, 0.05] for b in (-0.2, 0.2) for a in x.tolist()]
    table = [[0, 0, 0, 0], [1, 0, 0, -0.1], [2, 0, 0, -0.1]]
    table += [[3 + k, 0.69 + 0.04 * k, 0, -0.1] for k in range(4)]
    run = run_case(f"""
title = "Sideways sliding"
{UNITS}
[time]
end = 6.0
step = 1.0
[[body]]
name = "plate"
geometry = {{ shape = "plane", width = 2.0, length = 1.0 }}
[[slave]]
name = "row"
points = {{ coordinates = {points}, transform = [{{ translate = [0.0101, 0, 0] }}] }}
motion = {{ kind = "translate", table = {table} }}
[[contact]]
master = "plate"
slave = "row"
law = {{ kind = "force", curve = 0.5 }}
area = {{ kind = "constant", value = 0.1 }}
{FLAT}""")
    physics(run, slides_off=True)
    expected = [0, 68]
    expected += [2 * int((x + 0.0101 + s <= 1.0).sum()) for s in (0.0, 0.69, 0.73, 0.77, 0.81)]
    assert run.history["n_contact"].tolist() == expected
    assert expected == [0, 68, 68, 66, 64, 62, 60]
    assert run.history["n_slid_off"].tolist() == [0, 0, 0, 2, 2, 2, 2]
    # The force model's total does not depend on how many points carry it.
    np.testing.assert_allclose(run.history["force"][1:], 0.025, rtol=1e-12)


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
