"""Labels never lie on one another."""

from __future__ import annotations

import numpy as np

from contiga.report.labels import spread


def test_labels_at_one_place_come_apart_inside_the_picture() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        places = rng.uniform(0.0, [400.0, 300.0], (9, 2)) * rng.choice([0.1, 1.0])
        sizes = rng.uniform([30.0, 10.0], [90.0, 25.0], (9, 2))
        at = spread(places, sizes, np.array([400.0, 300.0]))
        apart = np.abs(at[:, None] - at[None]) >= 0.5 * (sizes[:, None] + sizes[None]) - 1e-9
        assert apart.any(axis=2)[~np.eye(9, dtype=bool)].all()
        assert (at - 0.5 * sizes >= -1e-9).all()
        assert (at + 0.5 * sizes <= [400.0 + 1e-9, 300.0 + 1e-9]).all()


def test_labels_that_are_apart_stay() -> None:
    places = np.array([[50.0, 50.0], [50.0, 90.0]])
    np.testing.assert_array_equal(
        spread(places, np.full((2, 2), 20.0), np.array([100.0, 100.0])), places
    )
