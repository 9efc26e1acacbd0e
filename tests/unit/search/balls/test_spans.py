"""Ranges hold what they are ranges of."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.search.balls.spans import (
    Span,
    basis,
    elevated,
    less_a_factor,
    quotient,
    restriction,
    spans_of,
)

X = np.linspace(0.0, 1.0, 7)


def random_span(rng, n=50):
    ends = np.sort(rng.normal(size=(2, n)), axis=0)
    return Span(*ends), ends[0] + rng.uniform(size=n) * (ends[1] - ends[0])


@pytest.mark.parametrize("name", ["__add__", "__sub__", "__mul__", "__truediv__"])
def test_results_of_numbers_within_lie_within(name):
    rng = np.random.default_rng(0)
    (a, x), (b, y) = random_span(rng), random_span(rng)
    if name == "__truediv__":
        b, y = Span(b.low + 5.0, b.high + 5.0), y + 5.0
    result, number = getattr(a, name)(b), getattr(x, name)(y)
    assert (result.low <= number + 1e-12).all()
    assert (number <= result.high + 1e-12).all()


@pytest.mark.parametrize("degree", [1, 2, 5])
def test_restricted_and_elevated_coefficients_give_the_same_polynomial(degree):
    net = np.random.default_rng(1).normal(size=degree + 1)
    part = restriction(degree, np.array([0.2]), np.array([0.7]))[0] @ net
    np.testing.assert_allclose(
        basis(degree, X) @ part, basis(degree, 0.2 + 0.5 * X) @ net, atol=1e-12
    )
    higher = elevated(net, degree + 2)
    np.testing.assert_allclose(basis(degree + 2, X) @ higher, basis(degree, X) @ net, atol=1e-12)


def test_a_factor_is_divided_out():
    net = np.array([0.0, 1.0, -2.0, 0.5])
    np.testing.assert_allclose(
        X * (basis(2, X) @ less_a_factor(net)), basis(3, X) @ net, atol=1e-14
    )


def test_ranges_of_a_quotient_are_its_derivatives_over_a_small_box():
    rng = np.random.default_rng(2)
    nets = rng.normal(size=(4, 3)), 1.0 + rng.uniform(size=(4, 3))
    x, y, small = 0.3, 0.6, 1e-3
    parts = [restriction(d, np.array([c]), np.array([c + small]))[0] for d, c in ((3, x), (2, y))]
    wide = np.array(small)
    ranges = quotient(*(spans_of(parts[0] @ net @ parts[1].T, (wide, wide)) for net in nets))

    def value(i, j):
        h = 1e-4
        a, b = basis(3, np.array([x + i * h])), basis(2, np.array([y + j * h]))
        top, bottom = (float(np.squeeze(a @ net @ b.T)) for net in nets)
        return top / bottom

    f = {(i, j): value(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    numbers = (
        f[0, 0],
        0.5e4 * (f[1, 0] - f[-1, 0]),
        0.5e4 * (f[0, 1] - f[0, -1]),
        1e8 * (f[1, 0] - 2.0 * f[0, 0] + f[-1, 0]),
        0.25e8 * (f[1, 1] - f[1, -1] - f[-1, 1] + f[-1, -1]),
        1e8 * (f[0, 1] - 2.0 * f[0, 0] + f[0, -1]),
    )
    for span, number in zip(ranges, numbers, strict=True):
        assert span.low - 1e-5 <= number <= span.high + 1e-5
        assert span.high - span.low < 0.5


def test_ranges_of_small_boxes_are_close():
    net = np.random.default_rng(3).normal(size=(3, 3))
    ends = np.array([0.3]), np.array([0.301])
    part = restriction(2, *ends)[0]
    wide = np.array(0.001)
    for span in spans_of(part @ net @ part.T, (wide, wide)):
        assert span.high - span.low < 0.1
