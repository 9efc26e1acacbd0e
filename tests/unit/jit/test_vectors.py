"""A bank of lanes is as wide as a vector."""

from __future__ import annotations

import pytest

from contiga.jit.vectors import numbers_in_vector


@pytest.mark.parametrize(
    ("name", "features", "numbers"),
    [
        ("znver5", "+avx2,+avx512f", 8),
        ("x86-64-v3", "", 4),
        ("x86-64-v4", "", 4),
        ("x86-64-v4", "-prefer-256-bit", 8),
        ("znver3", "+avx2,-avx512f", 4),
        ("sapphirerapids", "+avx2,+avx512f", 4),
        ("apple-m1", "+neon", 4),
    ],
)
def test_so_many_numbers(name, features, numbers):
    assert numbers_in_vector(("", name, features)) == numbers
