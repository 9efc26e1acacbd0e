"""Ratings by ISO/TS 18571 against a second implementation, written from the standard's formulae."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.criteria import iso18571
from contiga.criteria.rating import MAX_SAMPLES, Rating
from contiga.errors import InputError

pytest.importorskip("objective_rating_metrics.rating")

STEP = 1e-4


def corridor_score(test: np.ndarray, signal: np.ndarray) -> float:
    """Clause 5.3: an inner band of 5 % and an outer of 50 % of the greatest value, squared."""
    inner, outer = 0.05 * np.abs(test).max(), 0.5 * np.abs(test).max()
    return float(np.mean(np.clip((outer - np.abs(test - signal)) / (outer - inner), 0, 1) ** 2))


def aligned(test: np.ndarray, signal: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
    """The shift of the greatest correlation, up to a fifth of all, and both shifted by it."""
    n = len(test)
    most = int(0.2 * n)
    tries = [0, *(side * k for k in range(1, most + 1) for side in (1, -1))]
    pairs = [(signal[max(k, 0) : n + min(k, 0)], test[max(-k, 0) : n - max(k, 0)]) for k in tries]
    best = int(np.argmax([np.corrcoef(a, b)[0, 1] for a, b in pairs]))
    return abs(tries[best]), *pairs[best]


def warped_error(signal: np.ndarray, test: np.ndarray) -> float:
    """Relative difference along the path of dynamic time warping inside a band of a tenth."""
    n = len(test)
    width = int(np.ceil(0.1 * n))
    cost = np.full((n + 1, n + 1), np.inf)
    cost[0, 0] = 0.0
    for i in range(n):
        for j in range(max(0, i - width + 1), min(n, i + width)):
            least = min(cost[i, j + 1], cost[i + 1, j], cost[i, j])
            cost[i + 1, j + 1] = (signal[i] - test[j]) ** 2 + least
    i, j = n - 1, n - 1
    path = [(i, j)]
    while (i, j) != (0, 0):
        steps = [(i - 1, j), (i, j - 1), (i - 1, j - 1)]
        i, j = min((s for s in steps if min(s) >= 0), key=lambda s: cost[s[0] + 1, s[1] + 1])
        path.append((i, j))
    rows = np.array(path)
    return float(
        np.abs(signal[rows[:, 0]] - test[rows[:, 1]]).sum() / np.abs(test[rows[:, 1]]).sum()
    )


def slopes(values: np.ndarray) -> np.ndarray:
    """Central differences, averaged over nine samples, near the ends over as many as there are."""
    raw = np.gradient(values, STEP)
    n = len(raw)
    return np.array(
        [raw[i - w : i + w + 1].mean() for i in range(n) for w in [min(4, i, n - 1 - i)]]
    )


def rated(test: np.ndarray, signal: np.ndarray) -> Rating:
    """All scores and their sum."""
    shift, moved, kept = aligned(test, signal)
    limit = 0.2 * len(test)
    magnitude = max(0.0, 1.0 - warped_error(moved, kept) / 0.5)
    error = np.abs(slopes(moved) - slopes(kept)).sum() / np.abs(slopes(kept)).sum()
    scores = corridor_score(test, signal), max(0.0, 1.0 - shift / limit), magnitude
    scores = (*scores, max(0.0, 1.0 - error / 2.0))
    return Rating(*scores, float(np.dot([0.4, 0.2, 0.2, 0.2], scores)))


def pulse(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """A test of two half sines, and a signal that is like it: later, larger, with noise."""
    t = np.arange(n) * STEP
    end = t[-1]

    def at(times: np.ndarray) -> np.ndarray:
        whole = np.sin(np.pi * np.clip(times / end, 0, 1))
        return 50.0 * whole + 20.0 * np.sin(2 * np.pi * np.clip(times / end, 0, 1)) * whole

    late, scale = rng.uniform(-0.1, 0.1) * end, rng.uniform(0.7, 1.3)
    noise = np.convolve(rng.normal(size=n), np.ones(9) / 9, "same")
    return at(t), scale * at(t - late) + rng.uniform(0, 3) * noise


@pytest.mark.parametrize("seed", range(20))
def test_scores_are_those_of_a_second_implementation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    test, signal = pulse(rng, int(rng.integers(60, 160)))
    found = iso18571(test, signal, np.arange(len(test)) * STEP)
    np.testing.assert_allclose(found, rated(test, signal), rtol=0, atol=1e-3)


def test_a_signal_is_rated_best_beside_itself() -> None:
    test, signal = pulse(np.random.default_rng(1), 150)
    t = np.arange(150) * STEP
    assert iso18571(test, test, t) == Rating(1, 1, 1, 1, 1)
    assert iso18571(test, test, t).grade == "excellent"
    assert iso18571(test, signal, t).overall < 1.0
    assert iso18571(test, -test, t).grade == "poor"


def test_both_are_brought_to_the_same_times() -> None:
    """A straight line through every tenth sample is that of all."""
    t = np.arange(301) * STEP
    saw = np.interp(t, t[::100], [0.0, 5.0, -3.0, 0.0])
    other = np.interp(t, t[::100], [0.0, 4.0, -3.5, 0.0])
    whole = iso18571(saw, other, t)
    thinned = iso18571(saw[::10], other[::5], t[::5], t[::10])
    np.testing.assert_allclose(thinned, whole, atol=1e-9)


@pytest.mark.parametrize(
    ("reference", "signal", "times", "message"),
    [
        ([0.0, 1, 0], [0.0, 1], [0.0, 0.01, 0.02], "same length"),
        ([0.0, 1, 0], [0.0, np.nan, 0], [0.0, 0.01, 0.02], "sample 1 is not finite"),
        ([0.0, 1, 0], [0.0, 1, 0], [0.0, 0.01, 0.01], "times must rise"),
        ([0.0, 1, 0], [0.0, 1, 0], [0.0, 1e-4, 2e-4], "cannot be rated"),
        ([0.0, 1, 0], [0.0, 1, 0], [0.0, 0.1, 1.1 * MAX_SAMPLES * STEP], "cannot be rated"),
        ([1.0, 1, 1], [0.0, 1, 0], [0.0, 0.01, 0.02], "constant signal"),
    ],
)
def test_what_cannot_be_rated_is_refused(
    reference: list[float], signal: list[float], times: list[float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        iso18571(reference, signal, times)
