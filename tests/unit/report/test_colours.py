"""Colours as numbers are those of matplotlib."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from contiga.report.colours import channels, scale_colours
from contiga.report.style import REGIONS, SCALE, colour_map


@pytest.mark.parametrize("colour", [*SCALE, *REGIONS, "#000000", "#ffffff"])
def test_channels(colour: str) -> None:
    assert tuple(channels(colour)) == to_rgb(colour)


def test_the_scale() -> None:
    share = np.concatenate([np.linspace(-0.1, 1.1, 4001), np.arange(257) / 256])
    ours, theirs = scale_colours(share), colour_map()(share)[:, :3]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-15)


def test_what_is_no_number_has_the_colour_of_an_end() -> None:
    assert scale_colours(np.array([np.nan])).tolist() == [channels(SCALE[0]).tolist()]
