"""The judge judged: what it takes for proved is so."""

from __future__ import annotations

import numpy as np
from tests.stress import fields, truth


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
