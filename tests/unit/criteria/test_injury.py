"""BrIC, Nij, VC and femur force, beside closed forms and numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import KroghInterpolator

from contiga.criteria import bric, femur_force, nij, vc
from contiga.criteria.neck import HYBRID_III_5, HYBRID_III_50
from contiga.errors import InputError

T = np.linspace(0.0, 0.1, 1001)


def test_bric_takes_the_maximum_of_each_axis_whenever_it_is() -> None:
    w = np.stack([30.0 * np.sin(50 * T), -20.0 * np.cos(70 * T), 10.0 * np.sin(90 * T)], axis=1)
    actual = bric(w)
    np.testing.assert_allclose(actual.greatest, [30, 20, 10], rtol=1e-4)
    assert actual.value == pytest.approx(
        np.sqrt((30 / 66.25) ** 2 + (20 / 56.45) ** 2 + (10 / 42.87) ** 2), rel=1e-4
    )
    # A head that turns about one axis only, and twice as fast.
    assert bric(2.0 * w).value == pytest.approx(2.0 * actual.value, rel=1e-14)
    assert bric(-w).value == actual.value


@pytest.mark.parametrize(
    ("force", "moment", "mode", "value"),
    [
        (6806.0, 0.0, "NTF", 1.0),
        (-6160.0, 0.0, "NCF", 1.0),
        (0.0, 310.0, "NTF", 1.0),
        (0.0, -135.0, "NTE", 1.0),
        (3403.0, 155.0, "NTF", 1.0),
        (3403.0, -33.75, "NTE", 0.75),
        (-3080.0, 77.5, "NCF", 0.75),
        (-1540.0, -67.5, "NCE", 0.75),
    ],
)
def test_nij_is_the_sum_of_two_shares(force: float, moment: float, mode: str, value: float) -> None:
    shape = np.sin(np.pi * T / 0.1)
    actual = nij(force * shape, moment * shape)
    assert actual.value == pytest.approx(value, rel=1e-12)
    assert (actual.mode, actual.sample) == (mode, 500)


def test_nij_of_another_dummy_has_its_intercepts() -> None:
    assert nij([4287.0], [0.0], HYBRID_III_5).value == 1.0
    assert nij([0.0], [-67.0], HYBRID_III_5).value == 1.0
    assert nij([4287.0], [0.0], HYBRID_III_50).value == pytest.approx(4287.0 / 6806.0)


def test_vc_is_exact_for_a_parabola() -> None:
    """D = d (1 − (t/T)²): V C is largest in magnitude as it comes back; going in, at t = −T/√3."""
    depth, half = 0.05, 0.02
    t = np.linspace(-half, half, 4001)
    actual = vc(depth * (1 - (t / half) ** 2), t[1] - t[0])
    # max of 2 d² x (1 − x²) / T at x = 1/√3.
    expected = 1.3 / 0.229 * depth**2 / half * 4.0 / (3.0 * np.sqrt(3.0))
    assert actual.value == pytest.approx(expected, rel=1e-6)
    assert actual.time - half == pytest.approx(-half / np.sqrt(3.0), abs=2e-5)
    assert vc(np.full(9, 0.03), 1e-3).value == 0.0
    other = vc(depth * (1 - (t / half) ** 2), t[1] - t[0], scale=1.0, depth=0.14)
    assert other.value == pytest.approx(expected * (0.229 / 1.3) / 0.14, rel=1e-6)


def smooth(rng: np.random.Generator, columns: int) -> np.ndarray:
    """(201, columns) random sums of sines over 0.1 s."""
    t, rates = np.linspace(0.0, 0.1, 201), rng.uniform(20.0, 200.0, size=(5, columns))
    sizes, phases = rng.normal(size=(2, 5, columns))
    return np.asarray((sizes * np.sin(rates * t[:, None, None] + phases)).sum(axis=1))


def test_bric_nij_and_vc_of_200_signals_are_those_of_formulas_sample_by_sample() -> None:
    rng = np.random.default_rng(63)
    for _ in range(200):
        w = 40.0 * smooth(rng, 3)
        shares = [max(abs(row[k]) for row in w) / (66.25, 56.45, 42.87)[k] for k in range(3)]
        assert bric(w).value == pytest.approx(math.hypot(*shares), rel=1e-12)
        neck = smooth(rng, 2) * [3000.0, 90.0]
        loads = [
            force / (6806.0 if force > 0.0 else -6160.0)
            + moment / (310.0 if moment > 0.0 else -135.0)
            for force, moment in neck.tolist()
        ]
        assert nij(*neck.T).value == pytest.approx(max(loads), rel=1e-12)
        chest = 0.02 * smooth(rng, 1)[:, 0]
        # Speeds are slopes of the polynomial through five samples.
        windows = np.lib.stride_tricks.sliding_window_view(chest, 5)
        speeds = KroghInterpolator(5e-4 * np.arange(-2, 3), windows.T).derivative(0.0)
        expected = float((1.3 * speeds * chest[2:-2] / 0.229).max())
        assert vc(chest, 5e-4).value == pytest.approx(expected, rel=1e-9)


def test_femur_force_of_a_triangle() -> None:
    """Rises to P in 10 ms and falls in 10 ms: P (1 − d / 20 ms) is held for d."""
    actual = femur_force([0.0, -8000.0, 0.0], [0.0, 0.01, 0.02])
    assert (actual.peak, actual.held) == (8000.0, pytest.approx(4000.0))
    assert actual.ratio == pytest.approx(8000.0 / 9070.0)


def test_femur_force_that_lasts_is_judged_by_the_lower_limit() -> None:
    actual = femur_force([-7580.0, -7580.0], [0.0, 0.03])
    assert (actual.peak, actual.held, actual.ratio) == (7580.0, 7580.0, 1.0)
    two = [0.0, 0.006, 0.0061, 0.0099, 0.01, 0.016]
    force = [-7000.0, -7000.0, 0.0, 0.0, -7000.0, -7000.0]
    assert femur_force(force, two).held == pytest.approx(7000.0, rel=0.02)
    assert femur_force(force, two, cumulative=False).held < 1.0
    # Tension is none of it, nor is what is shorter than 10 ms held.
    assert femur_force([9000.0, 9000.0], [0.0, 0.02]) == (0.0, 0.0, 0.0)
    assert femur_force([-4535.0, -4535.0], [0.0, 1e-4]).held == 0.0
    assert femur_force([-4535.0, -4535.0], [0.0, 1e-4]).ratio == pytest.approx(0.5, rel=1e-2)


def test_intercepts_may_be_four_numbers() -> None:
    """They ended in an AttributeError."""
    signals = [0.0, 3403.0], [0.0, -67.5]
    for limits in (tuple(HYBRID_III_5), list(HYBRID_III_5), np.array(HYBRID_III_5)):
        assert nij(*signals, limits) == nij(*signals, HYBRID_III_5)
    assert nij(*signals, limits=HYBRID_III_5).value != nij(*signals).value


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: bric([1.0, 2.0, 3.0]), "bric, w: must have a row of three"),
        (lambda: bric([[1.0, 2.0, np.nan]]), "bric, w: sample 0 is not finite"),
        (lambda: bric([[1.0, 2.0, 3.0]], [1.0, 0.0, 1.0]), "bric, critical: must be positive"),
        (lambda: nij([1.0, 2.0], [1.0]), "nij: force and moment must have the same length"),
        (lambda: nij([1.0], [1.0], HYBRID_III_5._replace(tension=0.0)), "limits.tension"),
        (lambda: nij([1.0], [1.0], (1.0, 2.0, 3.0)), "nij, limits: must be four intercepts"),
        (lambda: nij([1.0], [1.0], 4.0), "nij, limits: must be four intercepts"),
        (lambda: nij([1.0], [1.0], (1.0, 2.0, "x", 4.0)), "nij, limits.flexion: must be a number"),
        (lambda: vc([1.0, 2.0], 0.1), "vc, deflection: five samples"),
        (lambda: vc(np.zeros(9), 0.0), "vc, dt: must be positive"),
        (lambda: femur_force([1.0, 2.0], [0.0]), "the same length"),
        (lambda: femur_force([1.0, 2.0], [1.0, 0.0]), "times must rise"),
    ],
)
def test_wrong_input_is_refused(call, said: str) -> None:
    with pytest.raises(InputError, match=said):
        call()
