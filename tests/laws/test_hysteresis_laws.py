"""Properties of hysteresis, for any pair of tables, any slope and any path."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sample import FULL

from contiga.curves.characteristic import Characteristic
from contiga.curves.hysteresis import Hysteresis
from contiga.laws.force import ForceLaw
from contiga.laws.stress import StressLaw
from contiga.records import LawInput


@st.composite
def pads(draw, starts=(0.0, 0.7)) -> Hysteresis:
    """Tables on different points, the unloading a share of the loading at each of its own."""
    n = draw(st.integers(1, 5))
    steps = draw(st.lists(st.floats(0.05, 1.0), min_size=n, max_size=n))
    rises = draw(st.lists(st.sampled_from([0.0, 0.5, 3.0, 20.0, -0.3]), min_size=n, max_size=n))
    x = np.append(0.0, np.cumsum(steps))
    y = np.maximum(np.append(draw(st.sampled_from(starts)), np.cumsum(rises)), 0.0)
    loading = Characteristic(np.column_stack([x, y]), extrapolation="constant")
    inner = draw(st.lists(st.floats(0.0, float(x[-1])), max_size=4, unique=True))
    nodes = np.union1d(x, np.round(inner, 6))
    shares = draw(st.lists(st.floats(0.0, 1.0), min_size=len(nodes), max_size=len(nodes)))
    unloading = Characteristic(
        np.column_stack([nodes, shares * loading(nodes)]), extrapolation="constant"
    )
    slopes = [np.diff(c.y) / np.diff(c.x) for c in (loading, unloading)]
    steepest = max(float(s.max()) for s in slopes)
    factor = draw(st.sampled_from([1.0, 1.2, 7.0]))
    return Hysteresis(loading, unloading, max(steepest, 0.5) * factor)


def follow(pad: Hysteresis, path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force, stored and lost after each step of one point along `path` from zero."""
    x, force, rows = np.zeros(1), np.zeros(1), []
    for value in path:
        moved = pad.move(x, force, np.array([value]))
        x, force = np.array([value]), moved.force
        rows.append([moved.force[0], moved.stored[0], moved.lost[0]])
    table = np.array(rows)
    return table[:, 0], table[:, 1], table[:, 2]


def area_of_cycle(pad: Hysteresis, top: float) -> float:
    """∫ L − max(line, U) over [0, top] of the functions themselves, cut where two lines cross."""
    nodes = np.concatenate([pad.loading.x, pad.unloading.x, [0.0, top]])
    nodes = np.unique(nodes[(nodes >= 0.0) & (nodes <= top)])
    peak = pad.loading(top)
    total = 0.0
    for a, b in pairwise(nodes):
        above = [peak - pad.slope * (top - x) - pad.unloading(x) for x in (a, b)]
        cuts = [a, b]
        if above[0] * above[1] < 0.0:
            cuts.insert(1, a + (b - a) * above[0] / (above[0] - above[1]))
        for p, q in pairwise(cuts):
            height = [
                pad.loading(x) - max(peak - pad.slope * (top - x), pad.unloading(x)) for x in (p, q)
            ]
            total += 0.5 * (q - p) * sum(height)
    return float(total)


def scale_of(pad: Hysteresis, top: float) -> float:
    return float(pad.loading(np.linspace(0.0, top, 50)).max() * top + pad.slope * top**2)


@settings(deadline=None, max_examples=40 if FULL else 15)
@given(pads(starts=(0.0,)), st.floats(0.05, 6.0), st.sampled_from([1, 7, 1000]))
def test_a_closed_cycle_loses_the_area_between_the_curves(pad, top, steps) -> None:
    ways = np.linspace(0.0, top, steps + 1)[1:], np.linspace(top, 0.0, steps + 1)[1:]
    _, stored, lost = follow(pad, np.concatenate(ways))
    area = area_of_cycle(pad, top)
    tiny = 1e-13 * scale_of(pad, top)
    assert abs(lost.sum() - area) <= 1e-10 * abs(area) + tiny
    assert stored[-1] == 0.0
    assert lost.min() >= -tiny


@settings(deadline=None, max_examples=60 if FULL else 15)
@given(pads(), st.lists(st.floats(0.0, 3.0), min_size=2, max_size=8), st.integers(2, 40))
def test_any_path_with_small_cycles_inside_is_the_same_in_one_step_a_leg_or_many(
    pad, turns, pieces
) -> None:
    legs = np.concatenate([[0.0], turns])
    fine = np.concatenate([np.linspace(a, b, pieces + 1)[1:] for a, b in pairwise(legs)])
    force, stored, lost = follow(pad, turns)
    many_force, many_stored, many_lost = follow(pad, fine)
    tiny = 1e-12 * (scale_of(pad, 3.0) + 1e-6)
    np.testing.assert_allclose(many_force[pieces - 1 :: pieces], force, rtol=1e-10, atol=tiny)
    np.testing.assert_allclose(many_stored[pieces - 1 :: pieces], stored, rtol=1e-10, atol=tiny)
    by_leg = many_lost.reshape(-1, pieces).sum(axis=1)
    np.testing.assert_allclose(by_leg, lost, rtol=1e-10, atol=tiny)
    assert min(lost.min(), many_lost.min()) >= -tiny


@settings(deadline=None, max_examples=30 if FULL else 15)
@given(pads(), st.lists(st.floats(0.0, 3.0), min_size=1, max_size=5))
def test_the_work_done_is_what_is_stored_and_lost(pad, turns) -> None:
    """Work by the trapezoidal rule, whose error falls with the square of the step."""
    legs = np.concatenate([[0.0], turns])
    path = np.concatenate([np.linspace(a, b, 201)[1:] for a, b in pairwise(legs)])
    force, stored, lost = follow(pad, path)
    first = max(float(pad.unloading(0.0)), 0.0)
    forces, x = np.append(first, force), np.append(0.0, path)
    work = float((0.5 * (forces[1:] + forces[:-1]) * np.diff(x)).sum())
    # A kink within a step costs a quarter of slope times step squared at most.
    allowed = 0.25 * pad.slope * (3.0 / 200) ** 2 * 20 * len(turns)
    assert abs(work - stored[-1] - lost.sum()) <= allowed + 1e-12 * scale_of(pad, 3.0)


@settings(deadline=None, max_examples=40 if FULL else 15)
@given(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=8), st.floats(1.0, 30.0))
def test_unloading_by_the_loading_curve_is_elastic(turns, factor) -> None:
    table = [[0, 0], [0.3, 1], [0.7, 1], [1, 4]]
    plain = StressLaw(table, 0.8), ForceLaw(table)
    pair = {"unloading": table, "hysteresis_slope": 10.0 * factor}
    alike = StressLaw(table, 0.8, **pair), ForceLaw(table, **pair)
    for law, other in zip(plain, alike, strict=True):
        memory = np.zeros((0, 0))
        for depth in turns:
            one = np.ones(1)
            inp = LawInput(depth * one, 0.0 * one, one, None, None, 0.1)
            a, b = law.respond(inp), other.respond(inp._replace(memory=memory))
            memory = b.memory
            for name in ("force", "stored"):
                np.testing.assert_allclose(getattr(b, name), getattr(a, name), rtol=1e-12)
            assert b.hysteresis is not None
            assert abs(b.hysteresis[0]) <= 1e-11 * max(depth, 1.0) * factor
