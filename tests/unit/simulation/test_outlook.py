"""A run whose end is out of reach says so, once, with what would help. The clock is made up."""

from __future__ import annotations

from types import SimpleNamespace

from contiga.simulation.outlook import Outlook
from contiga.simulation.reasons import Choice, Cut, Reason


def told(pace: float, seconds: int, cut: Cut | None = None, end: float = 100.0) -> list[str]:
    """What is said in so many seconds of the clock, one step of `pace` each."""
    clock = [0.0]
    outlook = Outlook(end, lambda: clock[0])
    said = []
    for k in range(seconds):
        clock[0] = float(k)
        choice = None if cut is None else Choice(cut)
        stepped = SimpleNamespace(state=SimpleNamespace(time=k * pace), choice=choice)
        text = outlook.after(stepped)  # type: ignore[arg-type]
        if text is not None:
            said.append(text)
    return said


def test_a_run_that_ends_within_the_hour_says_nothing() -> None:
    assert told(0.1, 900) == []


def test_what_makes_steps_short_and_what_would_help_is_said_once() -> None:
    said = told(1e-4, 900, Cut(1e-4, Reason.CROSSING, "contact 'panel'"))
    assert len(said) == 1
    assert said[0].startswith(
        "t = 0.006 of 100: at the pace of the last 60 s the run takes 12 days"
    )
    for part in ("now of 0.0001", "in and out", "contact 'panel'", "Longer ones need a thicker"):
        assert part in said[0]


def test_steps_that_were_given_are_told_as_such() -> None:
    assert "Its steps are as given" in told(1e-4, 100)[0]


def test_a_run_that_stands_still_takes_for_ever() -> None:
    assert "for ever more" in told(0.0, 100)[0]


def test_a_run_that_becomes_slow_says_so_later() -> None:
    clock, time, said = [0.0], 0.0, []
    outlook = Outlook(1e4, lambda: clock[0])
    for k in range(600):
        clock[0], time = float(k), time + (10.0 if k < 300 else 1e-3)
        stepped = SimpleNamespace(state=SimpleNamespace(time=time), choice=None)
        said.append(outlook.after(stepped))  # type: ignore[arg-type]
    at = [k for k, text in enumerate(said) if text]
    assert len(at) == 1
    assert 300 < at[0] < 480
