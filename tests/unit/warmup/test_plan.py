"""A plan hands out each kernel once, behind its parts, and what is wanted first."""

from __future__ import annotations

import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.warmup.plan import Plan

DIAMOND = [[], [], [0, 1], [0], [2, 3], []]
"""Kernel 4 is built of 2 and 3, and these of 0 and 1; 5 stands alone."""


def test_what_is_ready_comes_in_the_order_of_the_list() -> None:
    plan = Plan(DIAMOND)
    assert [plan.take(), plan.take(), plan.take()] == [0, 1, 5]
    plan.done(0)
    assert plan.take() == 3
    plan.done(1)
    assert plan.take() == 2
    for row in (2, 3, 5):
        plan.done(row)
    assert plan.take() == 4
    plan.done(4)
    assert plan.take() is None


def test_what_is_wanted_comes_first() -> None:
    plan = Plan([[], [], [], [2], [3]])
    assert plan.take_towards(4) == 2
    assert plan.take_towards(4) == 0  # 2 is being made: rather this than to wait
    plan.done(2)
    assert plan.take_towards(4) == 3
    plan.done(3)
    assert plan.take_towards(4) == 4
    plan.done(4)
    assert plan.take_towards(4) is None


def test_others_take_what_is_wanted_first_too() -> None:
    plan = Plan([[], [], [], [1, 2], []])
    assert [plan.take(), plan.take()] == [0, 1]
    waiting = threading.Thread(target=lambda: [plan.take_towards(3) for _ in range(3)])
    waiting.start()
    end = time.monotonic() + 30.0
    while not plan._urgent and time.monotonic() < end:  # it has taken 2 and 4, and waits for 1
        time.sleep(0.001)
    assert plan._urgent == [3]
    for row in (1, 2):
        plan.done(row)
    waiting.join(30.0)
    assert not waiting.is_alive()
    assert not plan._urgent


@pytest.mark.parametrize("ask", [lambda plan: plan.take(), lambda plan: plan.take_towards(1)])
def test_an_end_lets_go_of_all_who_wait(ask) -> None:
    plan = Plan([[], [0]])
    assert plan.take() == 0
    found: list[int | None] = [7]
    waiting = threading.Thread(target=lambda: found.append(ask(plan)))
    waiting.start()
    plan.end()
    waiting.join(30.0)
    assert found == [7, None]
    assert plan.take() is None


def test_what_is_done_twice_or_by_others_counts_once() -> None:
    plan = Plan([[], [], [0, 1]])
    plan.done(0)
    plan.done(0)
    assert plan.take() == 1
    plan.done(1)
    assert plan.take() == 2


@given(
    st.lists(st.sets(st.integers(1, 8), max_size=4), min_size=1, max_size=40),
    st.integers(0, 1000),
    st.integers(1, 4),
)
def test_several_threads_make_everything_behind_its_parts(
    back: list[set[int]], wanted: int, threads: int
) -> None:
    parts = [sorted({row - k for k in of if k <= row}) for row, of in enumerate(back)]
    plan, made, lock = Plan(parts), [], threading.Lock()

    def make(row: int) -> None:
        with lock:
            assert set(parts[row]) <= set(made)
            made.append(row)
        plan.done(row)

    def work() -> None:
        while (row := plan.take()) is not None:
            make(row)

    team = [threading.Thread(target=work) for _ in range(threads)]
    for one in team:
        one.start()
    target = wanted % len(parts)
    while (row := plan.take_towards(target)) is not None:
        make(row)
    assert target in made
    for one in team:
        one.join(60.0)
    assert sorted(made) == list(range(len(parts)))
