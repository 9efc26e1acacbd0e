"""A point of the body in every leaf."""

from __future__ import annotations

import numpy as np

from contiga.search.tables import tables_of

from .holed import holed_plate


def test_middles_lie_on_the_body_or_nowhere():
    body = holed_plate()
    leaves = tables_of(body).leaves
    middle = leaves["middle"]
    there = np.isfinite(middle).all(axis=1)
    assert there[leaves["element"] < 0].all()
    assert (~there).any()
    np.testing.assert_allclose(body.project(middle[there]).gap, 0.0, atol=1e-9)
