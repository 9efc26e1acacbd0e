"""Filters and criteria beside those of the package crashmetrics, on 200 random signals.

crashmetrics has no Nij, no BrIC and no VC.
"""

from __future__ import annotations

import numpy as np
import pytest

from contiga.criteria import cfc, clip, hic

pytest.importorskip("crashmetrics")

from crashmetrics.acceleration import clip_3ms
from crashmetrics.pedestrian import calculate_hic
from crashmetrics.signals import cfc_filter

SAME = 1e-3
"""Largest relative difference."""
SIGNALS = 200


def signals() -> list[np.ndarray]:
    """Random sums of half sines over 40 ms at 20 kHz, with noise; never negative; g."""
    rng = np.random.default_rng(63)
    t = np.arange(801) / 20_000.0
    made = []
    for _ in range(SIGNALS):
        whole = np.zeros(len(t))
        for _ in range(int(rng.integers(1, 4))):
            start, width = rng.uniform(0.0, 0.02), rng.uniform(0.004, 0.02)
            phase = np.clip((t - start) / width, 0.0, 1.0)
            whole += rng.uniform(10.0, 100.0) * np.sin(np.pi * phase)
        made.append(np.abs(whole + rng.normal(scale=3.0, size=len(t))))
    return made


TIMES = np.arange(801) / 20_000.0
MADE = signals()


def worst(ours: list[float], theirs: list[float]) -> float:
    """Largest relative difference of two lists."""
    a, b = np.array(ours), np.array(theirs)
    return float((np.abs(a - b) / np.abs(b)).max())


@pytest.mark.parametrize("cls", [60, 180, 600, 1000])
def test_filters_are_the_same(cls: int) -> None:
    """Both extend a signal by 10 ms of its image at each end. They begin each pass settled: theirs
    the way back as well, on the end of what has come forward."""
    away = []
    for a in MADE:
        apart = cfc(a, TIMES[1], cls) - cfc_filter(TIMES, a, cls)
        away.append(float(np.abs(apart).max() / np.abs(a).max()))
    assert max(away) <= SAME


@pytest.mark.parametrize("window", [0.015, 0.036])
def test_hic_is_the_same(window: float) -> None:
    """Of filtered signals, as it is meant. Theirs looks at windows between samples, ours at all:
    it is never below."""
    smooth = [np.abs(cfc(a, TIMES[1], 180)) for a in MADE]
    ours = [hic(a, TIMES, window=window).value for a in smooth]
    theirs = [calculate_hic(TIMES, a, window_ms=1e3 * window).value for a in smooth]
    assert worst(ours, theirs) <= SAME
    assert all(a >= b * (1.0 - 1e-9) for a, b in zip(ours, theirs, strict=True))


@pytest.mark.parametrize("cumulative", [False, True])
def test_the_3_ms_value_is_the_same(cumulative: bool) -> None:
    mode = "cumulative" if cumulative else "continuous"
    ours = [clip(a, TIMES, cumulative=cumulative).value for a in MADE]
    assert worst(ours, [clip_3ms(TIMES, a, mode=mode) for a in MADE]) <= SAME
