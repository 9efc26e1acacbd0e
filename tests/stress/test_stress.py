"""Samples of `make stress`, and that its judges see what is wrong."""

from __future__ import annotations

import numpy as np
import pytest
from tests.stress import segments, shaking, solids
from tests.stress.tally import Tally


@pytest.fixture(autouse=True)
def _data(data_dir):
    """CAD files count as part of the sample."""


def clean(tally: Tally) -> None:
    assert tally.wrong == 0, "\n".join(map(str, [tally.line(), *tally.faults]))
    assert tally.count > 0


@pytest.mark.parametrize("name", solids.names())
def test_after_each_step_of_shaking_contact_is_inside_and_came_in(name):
    scales = np.geomspace(1e-6, 0.3, 8)
    clean(shaking.shaken(solids.solid(name), scales, n=90, steps=8, seed=11))


@pytest.mark.parametrize("name", solids.names())
def test_segments_of_every_length_and_angle_enter_where_they_do(name):
    clean(segments.shot(solids.solid(name), 5_000, seed=12))
