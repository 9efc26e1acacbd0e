"""What an element departs from its Taylor polynomial by, over a cell."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.unit.search import plain

import contiga as cg
from contiga.search.certify.kernels import remainder_nb

pytestmark = pytest.mark.interpreted


@njit
def remainder_of(elements, e, cell, h, rest):
    return remainder_nb.remainder_of(elements, e, cell, h, rest)


@njit
def sums_over(elements, e, cell, a, h, normal, sums):
    p, q = remainder_nb.centred_coefficients(elements, e, cell, a)
    remainder_nb.taylor(a, h)
    return remainder_nb.sums_of(a, p, q, h, normal, sums)


def rough(seed):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, 4)], indexing="ij")
    net = np.stack([x, y, 0 * x], axis=-1) + 0.1 * rng.normal(size=(4, 4, 3))
    knots = np.repeat([0.0, 1.0], 4)
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.6, 1.6, (4, 4)))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [0.3, 0.05])
def test_the_rest_is_bounded_and_the_bound_is_no_waste(seed, size):
    patch = rough(seed)
    elements = plain.elements(cg.Body([patch]))
    rng, h, rest = np.random.default_rng(seed), np.zeros((4, 6)), np.empty((2, 5))
    low = rng.uniform(-0.5, 0.5 - size, 2)
    cell = (low[0], low[0] + size, low[1], low[1] + size)
    assert remainder_of(elements, 0, cell, h, rest)
    xy = rng.uniform(-1.0, 1.0, (500, 2))
    uv = low + 0.5 + 0.5 * size * (xy + 1.0)
    half = 0.5 * size
    D = patch.derivatives(uv, 2)
    x, y = xy.T[:, :, None]
    v = h[:3].T
    # the derivatives by x and y of what the polynomial of second order leaves
    left = [
        D[:, 1, 0] * half - (v[1] + x * v[3] + y * v[4]),
        D[:, 0, 1] * half - (v[2] + x * v[4] + y * v[5]),
        D[:, 2, 0] * half**2 - v[3],
        D[:, 1, 1] * half**2 - v[4],
        D[:, 0, 2] * half**2 - v[5],
    ]
    most = np.array([np.linalg.norm(d, axis=1).max() for d in left])
    assert (most <= rest[0] * (1.0 + 1e-9) + 1e-13).all()
    if size < 0.1:
        assert (rest[0] <= 6.0 * most).all()


@pytest.mark.parametrize("cell", [(-0.5, 0.5, -0.5, 0.5), (-0.1, 0.2, 0.3, 0.4)])
def test_sums_are_those_of_the_products_of_polynomials(cell):
    elements = plain.elements(cg.Body([rough(5)]))
    a, h, sums = np.empty((8, 8, 4)), np.zeros((4, 6)), np.empty((3, 6))
    normal = np.array([0.6, 0.0, 0.8])
    least = sums_over(elements, 0, cell, a, h, normal, sums)
    # the same polynomials, by another way: shifted by their values at 16 places
    row = elements.table[0]
    monomials = elements.coefs[row["monomial"] :][:64].reshape(4, 4, 4)
    x = np.linspace(-1.0, 1.0, 4)
    s = 0.5 * (cell[0] + cell[1]) + 0.5 * (cell[1] - cell[0]) * x
    t = 0.5 * (cell[2] + cell[3]) + 0.5 * (cell[3] - cell[2]) * x
    values = np.polynomial.polynomial.polygrid2d(s, t, monomials)
    back = np.linalg.inv(np.vander(x, increasing=True))
    own = np.einsum("im,jn,cmn->ijc", back, back, values)
    np.testing.assert_allclose(a[:4, :4], own, atol=1e-13)
    assert not a[4:].any()
    assert not a[:, 4:].any()
    # B = A - w T, T of second order
    T = np.zeros((3, 3, 3))
    T[0, 0], T[1, 0], T[0, 1] = h[:3, 0], h[:3, 1], h[:3, 2]
    T[2, 0], T[1, 1], T[0, 2] = 0.5 * h[:3, 3], h[:3, 4], 0.5 * h[:3, 5]
    B = np.zeros((6, 6, 3))
    B[:4, :4] = own[..., :3]
    for i in range(3):
        for j in range(3):
            B[i : i + 4, j : j + 4] -= own[..., 3:] * T[i, j]
    i, j = np.indices((6, 6))
    assert np.abs(B[i + j < 3]).max() < 1e-13
    B[i + j < 3] = 0.0
    factors = np.stack([1 + 0 * i, i, j, i * (i - 1), i * j, j * (j - 1)])
    w = np.zeros((6, 6))
    w[:4, :4] = np.abs(own[..., 3])
    w[0, 0] = 0.0
    for k, size in enumerate((np.linalg.norm(B, axis=2), np.abs(B @ normal), w)):
        np.testing.assert_allclose(sums[k], (factors * size).sum(axis=(1, 2)), rtol=1e-11)
    assert least == pytest.approx(own[0, 0, 3] - w.sum())
