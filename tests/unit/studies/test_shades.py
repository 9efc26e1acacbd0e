"""Colours of values: a band begins with its lower end, limits change evenly."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from contiga.studies.shades import RATED, Shades

BANDS = (650.0, 1000.0, 1350.0, 1700.0)


def test_a_band_begins_with_its_lower_end() -> None:
    values = np.array([0.0, 649.9, 650.0, 999.0, 1000.0, 1350.0, 1699.0, 1700.0, 9e9])
    actual = [to_hex(colour) for colour in Shades((0.0, 1.0), BANDS).colours(values)]
    assert actual == [RATED[k] for k in (0, 0, 1, 1, 2, 3, 3, 4, 4)]


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_pictures_and_pages_have_the_same_colours(count: int) -> None:
    bands = tuple(np.arange(1.0, count + 1.0))
    shades, values = Shades((0.0, 1.0), bands), np.arange(count + 1.0) + 0.5
    steps = shades.steps
    assert len(set(steps)) == count + 1
    assert [to_hex(c) for c in shades.colours(values)] == steps
    assert [to_hex(c) for c in shades.mappable().to_rgba(shades.places(values))] == steps
    marker = shades.marker(values, "x")
    scale, low, high = marker["colorscale"], marker["cmin"], marker["cmax"]
    places = (np.asarray(marker["color"]) - low) / (high - low)
    assert [next(c for at, c in scale[1::2] if place <= at) for place in places] == steps


def test_limits_change_evenly_and_nothing_is_beyond() -> None:
    shades = Shades((1.0, 3.0))
    a, b, c, d = shades.colours(np.array([0.0, 1.0, 3.0, 9.0]))
    assert a.tolist() == b.tolist() != c.tolist() == d.tolist()
    assert np.isnan(shades.places(np.array([np.nan]))).all()
    assert np.isnan(Shades((0, 1), BANDS).places(np.array([np.nan]))).all()
