"""Optuna over an engine that answers at once: found, within limits, the same for any order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

from contiga.case.schema import load_case
from contiga.studies.cases import StudyCase
from contiga.studies.folder import OPTUNA, StudyFolder
from contiga.studies.one_case import Base
from contiga.studies.optimise import best_of, excesses, optimised
from contiga.studies.row import DONE, FAILED, Row
from contiga.studies.spec import StudySpec

from .conftest import CASE, study_from

TEXT = """
base = "case.toml"
collect = ["steps"]
goal = { minimise = "max(force)", subject_to = ["max(area) <= 0.5"], trials = 40, batch = 4 }
[[variable]]
name = "x"
key = "time.step"
low = -1.0
high = 1.0
[[variable]]
name = "y"
key = "time.end"
values = [0.5, 2.0]
"""


class Answering:
    """An engine that knows: force (x − 0.4)² + y, area x."""

    def __init__(self, order: Callable[[list[StudyCase]], list[StudyCase]] = list) -> None:
        self.order = order
        self.asked: list[int] = []

    def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
        """Rows in any order."""
        for case in self.order(list(cases)):
            self.asked.append(case.number)
            x, y = case.values["x"], case.values["y"]
            told = {"steps": 1.0, "max(force)": (x - 0.4) ** 2 + y, "max(area)": x}
            yield Row(case.number, DONE, "", case.values, told, 0.0)


def opened(study: StudySpec, folder: Path) -> StudyFolder:
    """The folder of the study, begun."""
    base = Base(CASE, str(folder / "case.toml"), str(folder / "out"), study.quantities)
    made = StudyFolder(folder / "out", study, base, load_case(folder / "case.toml"))
    made.open([])
    return made


def test_the_least_is_found(folder: Path) -> None:
    study = study_from(TEXT, folder)
    rows = list(optimised(study, Answering(), opened(study, folder)))
    assert [row.number for row in rows] == list(range(1, 41))
    assert study.goal is not None
    best = best_of(study.goal, rows)
    assert best is not None
    assert best.values["y"] == 0.5
    assert best.values["x"] == pytest.approx(0.4, abs=0.1)
    assert (folder / "out" / OPTUNA).is_file()


def test_limits_are_kept(folder: Path) -> None:
    study = study_from(TEXT.replace("<= 0.5", "<= 0.1"), folder)
    rows = list(optimised(study, Answering(), opened(study, folder)))
    assert study.goal is not None
    best = best_of(study.goal, rows)
    assert best is not None
    assert 0.0 < best.values["x"] <= 0.1
    late = [row.values["x"] for row in rows[20:]]
    assert sum(x <= 0.1 for x in late) > 10  # it does not look for what may not be


def test_what_is_asked_does_not_depend_on_who_answers_first(folder: Path) -> None:
    study = study_from(TEXT, folder)
    orders = (list, lambda cases: cases[::-1])
    actual = [
        {row.number: row for row in optimised(study, Answering(order), opened(study, folder))}
        for order in orders
    ]
    assert actual[0] == actual[1]


def test_an_optimisation_that_was_stopped_goes_on_as_it_would_have(folder: Path) -> None:
    study = study_from(TEXT, folder)
    whole = list(optimised(study, Answering(), opened(study, folder)))
    made = opened(study, folder)
    for row in whole[:17]:
        home = folder / "out" / "cases" / f"{row.number:04d}"
        home.mkdir(parents=True)
        row.write(home)
    engine = Answering()
    assert sorted(optimised(study, engine, made)) == sorted(whole)
    assert engine.asked == list(range(18, 41))


def test_failed_cases_are_passed_over(folder: Path) -> None:
    study = study_from(TEXT.replace("minimise", "maximise").replace("40", "12"), folder)
    assert study.goal is not None

    class Failing(Answering):
        def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
            for row in super().run(cases):
                failed = dict.fromkeys(row.collected, math.nan)
                yield row._replace(status=FAILED, collected=failed) if row.number % 2 else row

    rows = list(optimised(study, Failing(), opened(study, folder)))
    best = best_of(study.goal, rows)
    assert best is not None
    assert best.number % 2 == 0
    within = [r for r in rows if r.status == DONE and excesses(study.goal, r)[0] <= 0.0]
    assert best.collected["max(force)"] == max(r.collected["max(force)"] for r in within)
    assert best_of(study.goal, [row for row in rows if row.status == FAILED]) is None
