"""Linear algebra in a fixed order gives what LAPACK does."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.ordered import length, principal_axes, product, row_products, solve


@pytest.mark.parametrize("shapes", [((3, 3), (3,)), ((7, 3), (3, 3)), ((4,), (4,)), ((5,), (5, 2))])
def test_products_are_those_of_matrices(shapes):
    rng = np.random.default_rng(0)
    a, b = (rng.normal(size=shape) for shape in shapes)
    np.testing.assert_allclose(product(a, b), a @ b, rtol=0, atol=1e-14)


def test_products_of_rows_are_summed_in_the_order_of_columns():
    a, b = np.random.default_rng(4).normal(size=(2, 500, 3))
    expected = [
        x * u + y * v + z * w for (x, y, z), (u, v, w) in zip(a.tolist(), b.tolist(), strict=True)
    ]
    assert row_products(a, b).tolist() == expected
    turned = [
        z * w + y * v + x * u for (x, y, z), (u, v, w) in zip(a.tolist(), b.tolist(), strict=True)
    ]
    assert turned != expected


def test_a_length_is_the_norm():
    vector = np.random.default_rng(1).normal(size=(3, 4))
    assert length(vector) == pytest.approx(np.linalg.norm(vector), rel=1e-15)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200, 1e308, 0.0, np.inf])
def test_a_length_is_as_large_as_numbers_go(size):
    assert length([0.6 * size, 0.0, -0.8 * size]) == pytest.approx(size, rel=1e-3)


@pytest.mark.parametrize("columns", [(), (2,)])
def test_systems_are_solved_with_pivots(columns):
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(9, 9)), rng.normal(size=(9, *columns))
    a[0, 0] = 0.0
    np.testing.assert_allclose(solve(a, b), np.linalg.solve(a, b), rtol=1e-11)


@pytest.mark.parametrize("stretch", [(1.0, 1.0, 1.0), (5.0, 1.0, 1e-9), (2.0, 1e-12, 0.0)])
def test_principal_axes_are_those_of_the_singular_values(stretch):
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    vectors = rng.normal(size=(50, 3)) * stretch @ turn
    sizes, axes = principal_axes(vectors)
    np.testing.assert_allclose(
        sizes, np.linalg.svd(vectors, compute_uv=False), rtol=1e-9, atol=1e-15 * sizes[0]
    )
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        np.linalg.norm(vectors @ axes.T, axis=0), sizes, rtol=1e-6, atol=1e-14 * sizes[0]
    )


def test_axes_across_one_vector_are_at_right_angles_to_it():
    vector = np.array([[1.0, 2.0, 3.0]])
    _, axes = principal_axes(vector)
    np.testing.assert_allclose(product(axes[1:], vector[0]), 0.0, rtol=0, atol=1e-14)
