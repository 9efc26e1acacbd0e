"""Bands of a rating protocol."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.criteria import Bands
from contiga.errors import InputError


def test_a_limit_belongs_to_the_band_above_it() -> None:
    bands = Bands([650, 1000], ["good", "fair", "poor"])
    values = (-1.0, 649.999, 650.0, 999.0, 1000.0, 1e9)
    assert [bands.of(v) for v in values] == ["good", "good", "fair", "fair", "poor", "poor"]


@pytest.mark.parametrize(
    ("limits", "names", "message"),
    [
        ([], ["all"], "limits: must rise"),
        ([2, 1], ["a", "b", "c"], "limits: must rise"),
        ([1, 1], ["a", "b", "c"], "limits: must rise"),
        ([1, np.nan], ["a", "b", "c"], "limits: must rise"),
        ([1, 2], ["a", "b"], "names: expected one name more .*allowed: 3 words"),
        ([1], ["a", ""], "names: expected one name more"),
    ],
)
def test_wrong_bands_are_refused(limits, names, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Bands(limits, names)


@pytest.mark.parametrize("value", [np.nan, "green", None, [650.0, 700.0], np.ma.masked, 650j])
def test_what_is_no_number_is_in_no_band(value: object) -> None:
    """NaN was in the worst one, or in the best where that comes last."""
    bands = Bands([650, 1000], ["good", "fair", "poor"])
    assert bands.of(np.inf) == "poor"
    assert bands.of(np.float32(649)) == "good"
    with pytest.raises(InputError, match="bands, value: "):
        bands.of(value)  # type: ignore[arg-type]
