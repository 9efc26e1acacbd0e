"""Every experiment of the reproduction: its statements hold, its tables and pictures are whole."""

from __future__ import annotations

import pytest

from contiga_validation.catalogue import experiments
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Experiment

_SEEN: dict[str, str] = {}


@pytest.fixture(autouse=True)
def _no_fine_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the comparison take most of a minute, and show no more than the coarse ones; nor do
    more points."""
    monkeypatch.setattr("contiga_validation.rivals.comparison_page.POINTS", 5_000)
    monkeypatch.setattr("contiga_validation.rivals.comparison_page.MAX_TRIANGLES", 70_000)


@pytest.mark.parametrize(
    "experiment",
    [
        pytest.param(one, marks=[pytest.mark.full] if one.key == "8-accuracy" else [], id=one.key)
        for one in experiments()
    ],
)
def test_experiment_holds(experiment: Experiment) -> None:
    outcome = experiment.run()
    assert outcome.claims
    broken = [f"{claim.text} {claim.measured}" for claim in outcome.claims if not claim.holds]
    assert broken == []
    assert outcome.difference.endswith(".")
    for table in outcome.tables:
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}
    for picture in outcome.pictures:
        # keys are the names of files: safe, and not those of another experiment
        assert not set(picture.key) & set('/\\:*?"<>| ')
        assert _SEEN.setdefault(picture.key, experiment.key) == experiment.key
        assert len(png(picture)) > 5000
