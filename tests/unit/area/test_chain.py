"""Segments in closed lines: each is gone along once, and lines end where they begin."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from contiga.area.outline import chained


def lines_of(segments):
    order, starts = chained(np.array(segments, np.int64).reshape(-1, 2))
    return [order[a:b].tolist() for a, b in pairwise(starts)]


def around(line):
    """The segments of a closed line, each with its lower end first."""
    return [tuple(sorted(pair)) for pair in pairwise([*line, line[0]])]


def test_no_segment_makes_no_line():
    assert lines_of([]) == []


def test_lines_begin_where_their_first_segment_does():
    assert lines_of([(4, 7), (0, 1), (7, 5), (1, 2), (4, 5), (0, 2)]) == [[4, 7, 5], [0, 1, 2]]


@pytest.mark.parametrize("seed", range(8))
def test_every_segment_is_gone_along_once(seed):
    rng = np.random.default_rng(seed)
    # Rings through the same nodes, some of them more than once: every node has an even number.
    segments = set()
    for _ in range(6):
        ring = rng.permutation(40)[: rng.integers(3, 30)].tolist()
        segments ^= set(around(ring))
    shuffled = rng.permutation(sorted(segments))
    gone = [segment for line in lines_of(shuffled) for segment in around(line)]
    assert sorted(gone) == sorted(segments)


def test_a_line_that_leads_nowhere_is_closed_straight():
    assert lines_of([(0, 1), (1, 2), (2, 3)]) == [[0, 1, 2, 3]]
