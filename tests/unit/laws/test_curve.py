"""Kernels of tables give what the curves say, and what brackets of the same curves find."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.laws.characteristic import Characteristic
from contiga.laws.hysteresis import Hysteresis, elastic_move

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
    between = np.abs(x[:, None] - curve.polyline[0]).min(axis=1) > 1e-9
    expected = np.where(curve.carried(x) > 0.0, curve.slope(x), 0.0)
    np.testing.assert_allclose(stiffness[between], expected[between], rtol=1e-13)
    assert not lost.any()


def test_tables_with_hysteresis_do_what_functions_of_the_same_shape_do() -> None:
    up, down = [[0, 0], [0.3, 1.0], [1.0, 1.4], [2.0, 4.0]], [[0, 0], [0.4, 0.0], [2.0, 2.0]]
    exact = Hysteresis(Characteristic(up), Characteristic(down), 8.0)
    functions = [
        Characteristic(lambda x, c=curve: np.interp(x, c.x, c.y))
        for curve in (exact.loading, exact.unloading)
    ]
    bracketed = Hysteresis(*functions, 8.0)
    rng = np.random.default_rng(2)
    x_old, x = rng.uniform(0.0, 1.9, (2, 25))
    low, high = exact.unloading.carried(x_old), exact.loading.carried(x_old)
    f_old = low + rng.uniform(0.0, 1.0, 25) * (high - low)
    x_old[:3], f_old[:3] = 0.0, [-1.0, 0.0, 5.0]  # without a past
    one, other = exact.move(x_old, f_old, x), bracketed.move(x_old, f_old, x)
    np.testing.assert_allclose(one.force, other.force, rtol=0, atol=1e-12)
    # Gauss's rule over kinks is good to a few thousandths.
    np.testing.assert_allclose(one.stored, other.stored, rtol=0, atol=5e-3)
    np.testing.assert_allclose(one.lost, other.lost, rtol=0, atol=5e-3)
    assert one.lost.max() > 0.1
    assert set(np.round(one.stiffness, 9)) > {8.0}
