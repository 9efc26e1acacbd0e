"""A small catalogue of experiments made up for the tests."""

from __future__ import annotations

import pytest

from contiga_validation import catalogue
from contiga_validation.engine.experiment import Claim, Experiment, Outcome, Picture, Table


def _draw(figure) -> None:
    figure.subplots().plot([0.0, 1.0], [1.0, 0.0])


def good() -> Outcome:
    return Outcome(
        tables=(
            Table(
                "5.9",
                "Counts & areas <beside>",
                ("t", "area", "note"),
                ((1, 0.1 + 0.2, "a, b"), (2, float("nan"), None)),
            ),
        ),
        pictures=(Picture("5.9", "A line <down>", _draw, (2.0, 1.5)),),
        claims=(Claim("One is <one>.", True, "1 & 1"),),
        difference="Nothing differs.",
    )


def broken() -> Outcome:
    return Outcome(claims=(Claim("Pigs fly.", False, "0 of 3 did"),))


def failing() -> Outcome:
    raise ZeroDivisionError("no way")


GOOD = Experiment("5.1-good", "All <well>", "Section 5.1", good, "It says so & so.")
BROKEN = Experiment("6.1-broken", "Not so well", "Section 6.1", broken)
FAILING = Experiment("7.1-failing", "Not at all", "Chapter 7", failing)


@pytest.fixture
def catalogued(monkeypatch: pytest.MonkeyPatch):
    """Puts experiments in the place of those of the thesis."""

    def put(*experiments: Experiment) -> None:
        monkeypatch.setattr(catalogue, "experiments", lambda *_: experiments)

    return put
