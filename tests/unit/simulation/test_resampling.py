"""Even times, and means about them."""

from __future__ import annotations

import numpy as np

from contiga.simulation.resampling import MAX_SAMPLES, even_times, means


def test_means_have_the_integral_and_are_those_of_straight_lines() -> None:
    rng = np.random.default_rng(0)
    times = np.sort(np.concatenate([[0.0, 10.0], rng.uniform(0.0, 10.0, 40)]))
    signal = rng.normal(size=(42, 3))
    steps = np.diff(times)[:, None]
    straight = 0.5 * steps * (signal[1:] + signal[:-1])
    for grid in (np.linspace(0.0, 10.0, 7), np.linspace(0.0, 10.0, 3001), times):
        for impulses in (straight, straight + rng.normal(size=straight.shape)):
            actual = means(grid, times, signal, impulses)
            np.testing.assert_allclose(
                np.trapezoid(actual, grid, axis=0), impulses.sum(axis=0), atol=1e-12
            )
    fine = np.linspace(0.0, 10.0, 200_001)
    actual = means(fine, times, signal, straight)[:, 0]
    np.testing.assert_allclose(actual[1:-1], np.interp(fine, times, signal[:, 0])[1:-1], atol=0.01)


def test_even_times_are_kept_and_others_made() -> None:
    even = np.linspace(1.0, 2.0, 11)
    assert even_times(even, 0.01) is even
    assert even_times(even[:1], 0.01).tolist() == [1.0]
    times = np.array([0.0, 1.0, 2.0, 2.5, 4.0])
    np.testing.assert_allclose(even_times(times, np.inf), [0.0, 1.0, 2.0, 3.0, 4.0])
    np.testing.assert_allclose(even_times(times, 0.5), np.linspace(0.0, 4.0, 9))
    assert len(even_times(times, 1e-9)) == MAX_SAMPLES + 1
