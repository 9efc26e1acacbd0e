"""Masters that breathe, twist and fold, against brute force: samples of `make stress`."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import FULL
from tests.stress import deforming

from contiga.contact.shape import Shape


@pytest.mark.parametrize("name", deforming.MASTERS)
def test_contact_with_a_shape_that_changes_is_that_of_its_closest_points(name: str) -> None:
    rates = np.geomspace(2e-3, 0.3, 8 if FULL else 2)
    tally = deforming.deformed(name, rates, n=60, steps=20 if FULL else 6, seed=21)
    assert tally.wrong == 0, "\n".join(map(str, [tally.line(), *tally.faults]))
    assert tally.notes["in contact"] > 0.05 * tally.count


@pytest.mark.parametrize(("name", "kind"), [
    ("breathing torus, thick", "within reach without contact"),
    ("breathing ball", "inside without contact"),
])  # fmt: skip
def test_a_shape_whose_way_does_not_count_is_found_out(
    name: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The judge itself."""
    monkeypatch.setattr(Shape, "travel", 0.0)
    tally = deforming.deformed(name, np.array([0.02]), n=200, steps=8, seed=21)
    assert tally.notes[kind] > 0
