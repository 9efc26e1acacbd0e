"""Piecewise linear curves in kernels: values, slopes and integrals, one curve or several."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.layout import locked
from contiga.curves.characteristic import Characteristic
from contiga.curves.curve_records import joined, piecewise
from contiga.curves.hysteresis import elastic_move
from contiga.curves.kernels import curve_nb

pytestmark = pytest.mark.interpreted
TABLES = {
    "line": [[0.0, 0.0], [1.0, 2.0]],
    "from below zero": [[-1.0, -0.4], [0.5, 0.3], [2.0, 0.9]],
    "falls through zero": [[0.0, 1.0], [1.0, 0.2], [1.5, -0.2], [2.0, 0.5]],
    "falls behind its end": [[0.0, 0.3], [1.0, 0.9], [1.2, 0.1]],
}


@pytest.mark.parametrize("extrapolation", ["linear", "constant"])
@pytest.mark.parametrize("name", TABLES)
def test_an_elastic_table_is_its_curve(name: str, extrapolation: str) -> None:
    curve = Characteristic(TABLES[name], extrapolation=extrapolation)
    x = np.concatenate(
        [[0.0], np.random.default_rng(1).uniform(0.0, 4.0, 60), curve.x[curve.x > 0]]
    )
    force, stiffness, stored, lost = elastic_move(curve, x)
    np.testing.assert_allclose(force, curve.carried(x), rtol=0, atol=1e-14)
    np.testing.assert_allclose(stored, curve.energy(x), rtol=0, atol=1e-14)
    between = np.abs(x[:, None] - curve.carried_pieces.x).min(axis=1) > 1e-9
    expected = np.where(curve.carried(x) > 0.0, curve.slope(x), 0.0)
    np.testing.assert_allclose(stiffness[between], expected[between], rtol=1e-13)
    assert not lost.any()


def test_curves_of_one_record_are_those_of_several() -> None:
    """Each at its own knots, with slopes beyond its ends and the integral from zero."""
    rng = np.random.default_rng(3)
    tables = [rng.normal(size=(n, 2)) for n in (2, 5, 3)]
    for table in tables:
        table[:, 0].sort()
        table[0, 0] = min(table[0, 0], -0.5)
    curves = [Characteristic(table) for table in tables]
    record = joined(*(curve.pieces for curve in curves))
    x = np.concatenate([rng.uniform(-4.0, 4.0, 50), [0.0], *(table[:, 0] for table in tables)])
    for c, curve in enumerate(curves):
        out = np.empty((3, len(x)))
        curve_nb.points(record, c, locked(x), out)
        first, last = curve.end_slopes
        expected = np.interp(x, curve.x, curve.y)
        expected += first * np.minimum(x - curve.x[0], 0.0)
        expected += last * np.maximum(x - curve.x[-1], 0.0)
        np.testing.assert_allclose(out[0], expected, rtol=0, atol=1e-12)
        for k, end in enumerate(x):
            low, high = sorted((0.0, float(end)))
            s = np.array([low, *curve.x[(curve.x > low) & (curve.x < high)], high])
            y = curve(s)
            whole = np.sign(end) * np.sum(0.5 * np.diff(s) * (y[1:] + y[:-1]))
            assert out[2, k] == pytest.approx(whole, rel=1e-12, abs=1e-12)
        slope = np.append(np.diff(curve.y) / np.diff(curve.x), last)
        right = np.searchsorted(curve.x, x, side="right")
        expected = np.append(first, slope)[right]
        np.testing.assert_allclose(out[1], expected, rtol=1e-9, atol=1e-12)


def test_a_curve_of_one_knot_holds_its_value() -> None:
    record = piecewise(np.array([2.0]), np.array([3.0]), 0.0, 0.0)
    for x in (-1.0, 2.0, 7.0):
        assert curve_nb.point(record, 0, x) == (3.0, 0.0, 3.0 * (x - 2.0))
