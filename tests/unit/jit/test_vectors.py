"""A bank of lanes is as wide as a vector."""

from __future__ import annotations

import pytest
from numba.core.registry import cpu_target

from contiga.jit.vectors import numbers_in_vector

CODE = cpu_target.target_context.codegen()


@pytest.mark.parametrize(
    ("name", "features", "numbers"),
    [
        ("znver5", "+avx2,+avx512f", 8),
        ("znver3", "+avx2,-avx512f", 4),
        ("sapphirerapids", "+avx2,+avx512f", 4),
        ("apple-m1", "+neon", 4),
    ],
)
def test_so_many_numbers(monkeypatch, name, features, numbers):
    monkeypatch.setattr(type(CODE), "magic_tuple", lambda _: ("", name, features))
    assert numbers_in_vector() == numbers
