"""Volumes, areas and lengths of elements, by themselves and with their shape functions."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.matter.parts import SHAPES
from contiga.matter.shapes import CUBE, measures

CORNERS = {"hex8": range(8), "tet4": (0, 1, 3, 4), "tri3": range(3), "bar2": range(2)}


@pytest.mark.parametrize("kind", CORNERS)
@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_measures_are_those_of_the_shapes_whichever_way_the_corners_run(
    kind: str, turned: float
) -> None:
    rng = np.random.default_rng(0)
    warped = CUBE + 0.3 * rng.uniform(-1.0, 1.0, (100, 8, 3))
    corners = 1e3 + 2.0 * warped[:, CORNERS[kind]] * [turned, 1.0, 1.0]
    whole = SHAPES[kind](2.0 * warped[:, CORNERS[kind]]).measures
    np.testing.assert_allclose(measures(kind, corners), whole, rtol=1e-12)


def test_elements_of_an_unknown_kind_are_not_measured_as_hexahedra() -> None:
    with pytest.raises(InputError, match="wedge6"):
        measures("wedge6", CUBE[None, :6])
