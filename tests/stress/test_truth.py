"""The judge judged: what it takes for proved is so."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.sample import FULL
from tests.stress import fields, open_rule, open_scenes, rule, subjects, truth
from tests.stress.open_rule import Becomes


def test_paths_that_come_out_for_the_smallest_part_of_their_way_do_not_stay_inside():
    """Past the inner corner of a cup and past a thin slot, at heights down to rounding."""
    cube = fields.box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    corner = fields.minus(cube, fields.box((0.0, -2.0, 0.0), (2.0, 2.0, 2.0)))
    out = 10.0 ** np.arange(-8.0, -1.0)[:, None]
    a = [-0.4, 0.1, -0.9] * np.ones((7, 1))
    # Through (out, 0.1, out) and on: outside only within about `out` of the corner.
    b = a + 1.5 * ([0.0, 0.1, 0.0] + out * [1.0, 0.0, 1.0] - a)
    assert not truth.stays_inside(corner, a, b, 1e-9).any()
    b = a + 1.5 * ([0.0, 0.1, 0.0] - out * [1.0, 0.0, 1.0] - a)
    assert truth.stays_inside(corner, a, a + 0.6 * (b - a), 1e-9).all()
    slot = fields.minus(cube, fields.box((-1e-5, -2.0, -2.0), (1e-5, 2.0, 2.0)))
    assert not truth.stays_inside(slot, a, b * [1.0, 0.5, 1.0], 1e-9).any()


def test_paths_well_inside_stay_inside():
    ball = fields.ball((0.0, 0.0, 0.0), 1.0)
    rng = np.random.default_rng(3)
    a, b = (0.5 * rng.uniform(-1.0, 1.0, (100, 3)) for _ in range(2))
    assert truth.stays_inside(ball, a, b, 1e-9).all()


def test_the_nearest_place_of_plane_faces_is_that_of_the_closed_form():
    low, high = (-20.0, -20.0, 0.0), (20.0, 20.0, 20.0)
    block = subjects.Planes(subjects.PLANE["sharp block"])
    p = np.random.default_rng(4).uniform(-25.0, 25.0, (2000, 3))
    height = fields.box(low, high)(p)
    np.testing.assert_array_equal(block.inside(p), height < 0.0)
    np.testing.assert_allclose(block.nearest(p)[0], np.abs(height), rtol=0, atol=1e-12)


def test_in_a_plate_the_far_side_takes_over_only_round_the_end():
    """By hand: 0.3 deep from above, down to 0.8, to the end 0.1 off, back in, and up again."""
    plate = subjects.Planes(subjects.PLANE["plate"])
    way = np.array([[0.0, 0, 1.2], [0, 0, 0.7], [0, 0, 0.2], [19.9, 0, 0.2], [15, 0, 0.2]])
    at, found = rule.Held(np.zeros(1), np.zeros((1, 3))), []
    for a, b in pairwise(way):
        seen = rule.look(plate, rule.straight(a[None], b[None], 1000 if FULL else 200))
        at = rule.follow(plate, seen, at)
        found.append((float(at.depth[0]), *at.guard[0]))
    expected = [(0.3, 0, 0, 1), (0.8, 0, 0, 1), (0.1, 1, 0, 0), (0.2, 0, 0, -1)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", open_scenes.ALL)
def test_feet_on_open_shells_are_as_near_as_the_surface_and_on_its_side(name):
    item = open_scenes.scene(name)
    p = np.random.default_rng(5).uniform(item.low - 0.5, item.high + 0.5, (400, 3))
    found, feet = item.master.project(p), item.shell.feet(p)
    off = np.linalg.norm(found.point - p, axis=1)
    np.testing.assert_allclose(item.shell.nearest(p), off, rtol=0, atol=1e-12)
    first = feet.distance.argmin(axis=1)
    rows = np.flatnonzero(feet.distance.min(axis=1) < feet.border - 1e-9)
    signed = np.where(feet.behind, -1.0, 1.0)[rows, first[rows]] * off[rows]
    np.testing.assert_allclose(signed, found.gap[rows], rtol=0, atol=1e-12)
    assert item.shell.closed == item.master.closed


def _on_open(name, *corners, pieces=400):
    """What the rule says of a point at the corners of its way."""
    shell, held, out = open_scenes.scene(name).shell, open_rule.free(1), []
    for a, b in pairwise(np.array(corners, float)):
        held = open_rule.step(shell, a[None], b[None], held, pieces)
        out.append((Becomes(int(held.became[0])), float(held.depth[0]), *held.guard[0]))
    return out


def test_by_the_rule_a_stack_holds_by_its_first_sheet():
    way = [[1, 1, z] for z in (0.1, -0.1, -0.29, -0.5, 0.2)]
    found = _on_open("stack", *way)
    assert [row[0] for row in found] == [Becomes.NEW, Becomes.OLD, Becomes.OLD, Becomes.RELEASED]
    np.testing.assert_allclose([row[1] for row in found], [0.1, 0.29, 0.5, 0.0], atol=1e-12)


def test_by_the_rule_borders_and_ridges_end_and_turn_a_hold():
    slid = _on_open("plate", [1, 1, 0.1], [1, 1, -0.1], [1, 2.2, -0.1], [1, 1, -0.1])
    assert [row[0] for row in slid] == [Becomes.NEW, Becomes.SLID_OFF, Becomes.FREE]
    # Past the middle of a ridge of 14° the other slope is opposite: the minimum vanishes there.
    knife = _on_open("knife", [0.03, 0.1, 1], [0.03, -0.5, 1], [-0.02, -0.5, 1], [-0.2, 0.6, 1])
    assert knife[0][0] == Becomes.NEW
    assert knife[1][2:] == knife[0][2:]
    assert knife[1][1] > knife[0][1]
    assert knife[2][0] in (Becomes.ENDED, Becomes.RELEASED)
    roof = _on_open("roof 90", [0.1, 0.1, 1], [0.1, -0.3, 1], [-0.1, -0.3, 1])
    s = np.sqrt(0.5)
    np.testing.assert_allclose([row[1] for row in roof], [0.2 * s, 0.2 * s], atol=1e-12)
    np.testing.assert_allclose(roof[1][2:], [-s, s, 0.0], atol=1e-12)
