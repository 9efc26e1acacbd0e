"""Which rows of tables steps have to end at."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.dynamics.kinks import SKIP_TOL, bends_of, jumps_of, merge_kinks
from contiga.dynamics.prescribed import kinks_in

PUSH = [[0.0, 0.0], [20.13, 0.0], [20.18, 1e4], [20.23, 0.0], [100.0, 0.0]]
"""A triangle a thousandth as long as its table."""


def rows_of(table) -> tuple[np.ndarray, np.ndarray]:
    rows = np.array(table)
    return rows[:, 0], rows[:, 1:]


def test_a_short_spike_is_kept_and_a_line_of_many_rows_is_not() -> None:
    t, f = rows_of(PUSH)
    np.testing.assert_array_equal(bends_of(t, f), t)
    line = np.linspace(0.0, 3.0, 500)
    np.testing.assert_array_equal(bends_of(line, 2.0 * line[:, None] - 1.0), [0.0, 3.0])


@pytest.mark.parametrize("seed", range(4))
def test_what_passed_rows_leave_out_is_at_most_twice_their_share(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.exponential(1.0, 400))
    f = np.cumsum(rng.normal(size=(400, 3)), axis=0) * (rng.random(400) < 0.5)[:, None]
    kept = bends_of(t, f)
    fine = np.union1d(np.linspace(t[0], t[-1], 200_001), t)
    whole, few = (
        np.stack([np.interp(fine, at, np.interp(at, t, f[:, k])) for k in range(3)], axis=1)
        for at in (t, kept)
    )
    size = np.sqrt((whole**2).sum(axis=1))
    off = np.sqrt(((whole - few) ** 2).sum(axis=1))
    assert np.trapezoid(off, fine) <= 2.001 * SKIP_TOL * np.trapezoid(size, fine)
    assert len(kept) < len(t)


def test_even_rates_are_one_piece_and_a_turn_is_seen() -> None:
    t = np.linspace(0.0, 1.0, 11)
    rates = np.full((10, 1), 3.0)
    rates[7:] = -3.0
    np.testing.assert_allclose(jumps_of(t, rates), [0.0, 0.7, 1.0])


def test_times_between_start_and_end_once_each() -> None:
    some = [0.0, 1.0, 1.0 + 1e-12, 2.0, 5.0], [1.0, 3.0], ()
    assert merge_kinks(some, 0.0, 5.0) == (1.0, 2.0, 3.0)


HAMMER = [[0.0, 0, 0, 0], [2.0, 0, 0, 0], [2.1, 0, 0, -1.0], [2.2, 0, 0, 0], [9.0, 0, 0, 0]]
ROWS = [0.0, 2.0, 2.1, 2.2, 9.0]
MOVERS = {
    "translate": (cg.motion.Translate(HAMMER), ROWS),
    "rotate": (cg.motion.Rotate([row[:1] + row[3:] for row in HAMMER]), ROWS),
    "velocity": (cg.motion.Velocity(HAMMER), ROWS),
    "acceleration": (cg.motion.Accelerated(HAMMER), ROWS),
    "load": (cg.Load("ball", moment=HAMMER), ROWS),
    "constant load": (cg.Load("ball", force=[1.0, 0.0, 0.0]), []),
    "one after the other": (
        cg.motion.Combine([cg.motion.Translate(HAMMER), cg.motion.Rotate([[0, 0], [4, 1]])]),
        [*ROWS, 0.0, 4.0],
    ),
    "one's own": (object(), []),
}


@pytest.mark.parametrize("name", MOVERS)
def test_every_mover_says_where_its_table_bends(name: str) -> None:
    mover, rows = MOVERS[name]
    np.testing.assert_allclose(kinks_in(mover), rows)


def test_smooth_tables_are_looked_at_between_their_rows() -> None:
    push = [[0.0, 0, 0, 0], [1.0, 0, 0, 1.0], [2.0, 0, 0, 0]]
    kinks = cg.Load("ball", force=push, smooth=True).kinks
    assert {0.0, 1.0, 2.0} <= set(kinks.tolist())
    assert 6 < len(kinks) <= 17
