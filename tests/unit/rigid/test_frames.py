"""Products of vectors are NumPy's to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.rigid.frames import cross

SHAPES = [((3,), (3,)), ((3,), (1, 3)), ((1, 3), (3,)), ((1, 3), (1, 3)), ((3,), (7, 3)),
          ((7, 3), (3,)), ((7, 3), (7, 3)), ((1, 3), (7, 3)), ((0, 3), (0, 3))]  # fmt: skip


@pytest.mark.parametrize(("first", "second"), SHAPES)
def test_it_is_numpys_product(first: tuple[int, ...], second: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        a = rng.normal(size=first) * 10.0 ** rng.integers(-9, 9)
        b = rng.normal(size=second)
        np.testing.assert_array_equal(cross(a, b), np.cross(a, b), strict=True)
