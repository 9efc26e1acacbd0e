"""The wall that holds a point on open shells and meshes: any path, in any number of steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from tests.sample import FULL, few
from tests.stress import opened
from tests.stress.open_scenes import scene
from tests.stress.tally import Tally

SETTINGS = settings(
    max_examples=60 if FULL else few(8, 1),
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
)
"""Examples are not made smaller: each takes half a second, and says where it went wrong."""
PLACES = 997
SHIFT = np.array([0.37, 0.61, 0.43])
"""Of the grid that corners are drawn from, so that none lies on a wall or half way between two."""
ONE_WALL = ("plate", "plate, mesh", "sphere without its cap", "pipe")
WALLS = (
    "stack",
    "plate with two sides",
    "room",
    "Z fold",
    "gutter 90",
    "lidded pipe",
    "Z fold, mesh",
)

corner = st.tuples(*3 * [st.integers(0, PLACES)])
paths = st.lists(corner, min_size=2, max_size=6)
counts = st.sampled_from([1, 2, 5, 40])


def _ends(name: str, drawn: list[tuple[int, ...]]) -> np.ndarray:
    """(k, 1, 3) corners about a scene."""
    item = scene(name)
    share = (np.array(drawn, dtype=float) + SHIFT) / (PLACES + 1)
    return (item.low - 0.3 + share * (item.high - item.low + 0.6))[:, None]


def _followed(name: str, ends: np.ndarray, steps: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tally = Tally(name)
    opened.follow(scene(name), opened.places(ends, steps), opened.random_frame(rng), rng, tally)
    assert tally.wrong == 0, "\n".join(map(str, [tally.line(), *tally.faults]))


@pytest.mark.parametrize("name", [*ONE_WALL, *WALLS])
@SETTINGS
@given(paths, counts, st.integers(0, 9))
def test_the_wall_that_holds_a_point_is_that_of_the_rule(
    name: str, drawn: list[tuple[int, ...]], steps: int, seed: int
) -> None:
    ends = _ends(name, drawn)
    _followed(name, ends, steps * (len(ends) - 1), seed)
