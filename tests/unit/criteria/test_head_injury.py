"""HIC: against a search by zooming, invariants, and bad input. Closed forms: tests/reference."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.criteria import HIC, hic, hicd
from contiga.criteria.head_injury import _best_window, _inner_windows
from contiga.criteria.pairs import likely_pairs
from contiga.criteria.samples import line_through
from contiga.errors import InputError


def value_of(a, t, start, end):
    """Of windows, by the trapezoids of every piece they reach into."""
    area = np.zeros(np.broadcast_shapes(np.shape(start), np.shape(end)))
    for k in range(len(t) - 1):
        low, high = np.clip(start, t[k], t[k + 1]), np.clip(end, t[k], t[k + 1])
        ends = np.interp(low, t, a) + np.interp(high, t, a)
        area = area + 0.5 * ends * np.maximum(high - low, 0.0)
    length = np.maximum(np.asarray(end) - start, 1e-300)
    return length * (area / length) ** 2.5


def zoomed(a, t, limit, count=60, most=6):
    """The largest value over a grid of (start, length), its best places looked at ever closer."""
    longest = min(limit, t[-1] - t[0])
    s, w = np.meshgrid(np.linspace(t[0], t[-1], count), np.linspace(0, longest, count + 1)[1:])
    values = np.where(s + w <= t[-1], value_of(a, t, s, np.minimum(s + w, t[-1])), 0.0)
    best = 0.0
    for k in np.argsort(values.ravel())[::-1][:: max(1, count // 10)][:most]:
        place, reach = (s.ravel()[k], w.ravel()[k]), np.array([t[-1] - t[0], longest]) / count
        for _ in range(24):
            fine = np.linspace(-1.5, 1.5, 13)
            x, y = np.meshgrid(place[0] + reach[0] * fine, place[1] + reach[1] * fine)
            x, y = np.clip(x, t[0], t[-1]), np.clip(y, 0.0, longest)
            result = np.where(x + y <= t[-1] + 1e-15, value_of(a, t, x, x + y), 0.0)
            m = int(np.argmax(result))
            place, reach = (x.ravel()[m], y.ravel()[m]), 0.5 * reach
        best = max(best, float(result.max()))
    return best


def signal(seed: int, kind: str):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 30))
    t = np.cumsum(rng.uniform(0.2, 1.0, n)) * 1e-3 + rng.uniform(-1, 1)
    a = {
        "rough": lambda: rng.uniform(0.0, 100.0, n),
        "spiky": lambda: 100.0 * rng.random(n) ** 5 + rng.choice([0.0, 8.0]),
        "steps": lambda: np.repeat(rng.integers(0, 5, n) * 20.0, 2)[:n],
        "smooth": lambda: 90.0 * np.abs(np.sin(np.linspace(0.0, rng.uniform(1, 9), n))),
    }[kind]()
    return a, t


@pytest.mark.parametrize("kind", ["rough", "spiky", "steps", "smooth"])
@pytest.mark.parametrize("limit", [0.0015, 0.006, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_no_window_is_better(seed, limit, kind):
    a, t = signal(seed, kind)
    found, other = hic(a, t, limit), zoomed(a, t, limit)
    assert t[0] <= found.start <= found.end <= t[-1]
    assert found.end - found.start <= limit * (1.0 + 1e-12)
    assert found.value == pytest.approx(float(value_of(a, t, found.start, found.end)), rel=1e-9)
    assert found.value >= other * (1.0 - 1e-9)
    # The other search may miss the best of many alike, but not by much.
    assert found.value <= other * 1.1 + 1e-12


@pytest.mark.parametrize("seed", range(8))
def test_pairs_that_are_left_out_hold_nothing_better(seed):
    """Signals with steps that differ a lot: bounds are tight where blocks are long and low."""
    rng = np.random.default_rng(seed)
    for _ in range(300):
        n = int(rng.integers(5, 20))
        a = np.where(rng.random(n) < 0.3, 0.0, rng.uniform(0.0, 100.0, n)).round()
        t = np.cumsum(rng.choice([1.0, 3.0, 30.0], n))
        limit = rng.choice([3.0, 20.0, 1000.0])
        line = line_through(a, t - t[0])
        i, j = np.triu_indices(len(line.slope), 1)
        everything = _best_window(line, *_inner_windows(line, i, j, limit)).value
        assert everything <= hic(a, t, limit).value * (1.0 + 1e-12)


@pytest.mark.parametrize(
    "pulse", [[50.0, 62.0, 160.0], [160.0, 62.0, 50.0], [10.0, 90.0, 5.0, 80.0, 30.0], [7.0]]
)
def test_it_does_not_matter_where_blocks_begin(pulse):
    """The bounds are those of blocks of 2^k pieces."""
    values = set()
    for before in range(17):
        a = np.concatenate([np.zeros(before + 1), pulse, np.zeros(40 - before)])
        values.add(float(f"{hic(a, np.arange(len(a)) * 1e-3).value:.10g}"))
    assert len(values) == 1


def test_ends_between_samples_are_better_than_those_at_samples():
    """A sample each 2 ms: the best window of samples is 4 % less."""
    t = np.arange(0.0, 0.03, 0.002)
    a = 80.0 * np.maximum(np.sin(np.pi * t / 0.02), 0.0) * (t <= 0.02)
    i, j = np.triu_indices(len(t), 1)
    short = t[j] - t[i] <= 0.009
    at_samples = value_of(a, t, t[i[short]], t[j[short]]).max()
    assert hic(a, t, 0.009).value > 1.04 * at_samples


def test_a_plateau_has_its_first_window():
    actual = hic(np.full(2001, 40.0), np.linspace(1.0, 1.2, 2001), 0.015)
    assert actual == HIC(pytest.approx(0.015 * 40.0**2.5, rel=1e-12), 1.0, pytest.approx(1.015))


@pytest.mark.filterwarnings("error")
def test_slopes_of_rounding_do_no_harm():
    a = 40.0 + 5e-15 * np.random.default_rng(0).integers(0, 3, 500)
    a[200:230] = 300.0
    t = np.arange(500) * 1e-4
    tiny = np.array([0.0, 5e-324, 1.0, 2e-320, 1e-310, 0.0])
    assert hic(a, t).value == pytest.approx(hic(np.round(a, 9), t).value, rel=1e-12)
    assert hic(tiny, t[:6]).value == pytest.approx(hic(np.round(tiny), t[:6]).value, rel=1e-12)


def test_a_signal_of_nothing_is_nothing():
    assert hic(np.zeros(9), np.arange(9.0)).value == 0.0


def test_a_long_fast_signal_is_searched_at_once():
    """1e5 samples; all pairs would be 1e9: what counts is how few are left."""
    t = np.linspace(0.0, 0.2, 100_001)
    line = line_through(50.0 + 50.0 * np.sin(2.0 * np.pi * t / 4e-4), t)
    pairs = likely_pairs(line, 0.015, hic(line.a, t).value * (1.0 - 1e-12))
    assert len(pairs.i) < 10_000


def test_a_headform_in_free_motion():
    assert hicd(1000.0) == pytest.approx(920.86)
    assert hicd(0) == 166.4


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, None, "1000"])
def test_a_hicd_is_of_a_hic(value):
    with pytest.raises(InputError, match="hicd, hic: must be a value of HIC"):
        hicd(value)


@pytest.mark.parametrize("window", [0.0, -1.0, np.nan, "long"])
def test_windows_are_positive(window):
    with pytest.raises(InputError, match="hic, window: must be"):
        hic([1.0, 2.0], [0.0, 1.0], window)


def test_a_window_may_have_no_limit():
    a, t = [0.0, 100.0, 0.0], [0.0, 1.0, 2.0]
    assert hic(a, t, np.inf) == hic(a, t, 2.0)


BAD = [
    ([1.0, np.nan], [0.0, 1.0], "a_g: sample 1 is not finite"),
    ([1.0, 2.0], [0.0, np.inf], "t_s: sample 1 is not finite"),
    ([1.0, 2.0, 3.0], [0.0, 1.0, 1.0], "t_s: times must rise, from sample 1 to 2"),
    ([1.0, 2.0], [1.0, 0.0], "t_s: times must rise"),
    ([1.0, 2.0, 3.0], [0.0, 1.0], r"the same length; found \(\(3,\), \(2,\)\)"),
    (np.ones((3, 3)), [0.0, 1.0, 2.0], r"the same length.*np.linalg.norm\(components, axis=1\)"),
    ([1.0], [0.0], "two samples at least"),
    ([], [], "two samples at least"),
    ([1.0, -0.5], [0.0, 1.0], "a_g: a resultant is never negative.*found -0.5.*Filter the comp"),
    (["a", "b"], [0.0, 1.0], "a_g: must be an array of numbers"),
]


@pytest.mark.parametrize(("a", "t", "says"), BAD, ids=range(len(BAD)))
@pytest.mark.parametrize("criterion", [cg.criteria.hic, cg.criteria.clip])
def test_bad_signals_are_refused(criterion, a, t, says):
    with pytest.raises(InputError, match=rf"^{criterion.__name__}.*{says}"):
        criterion(a, t)
