"""Optimisation: Optuna chooses the next cases and gets their results.

Cases are asked for in batches, and each batch is told in the order of its numbers: what is asked
for next depends on what was found, never on which case was done first or by how many workers. A
study that goes on is asked all over again, and answered from the rows that are there.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from contiga.studies.cases import StudyCase, case_of, listed_values
from contiga.studies.engines import Engine
from contiga.studies.folder import OPTUNA, StudyFolder
from contiga.studies.one_case import row_of
from contiga.studies.row import DONE, Row
from contiga.studies.spec import GoalSpec, StudySpec, VariableSpec

_RANDOM = 10
"""Number of cases chosen at random before the search begins."""
_NONE = 1e300
"""Excess of a missing quantity over its limit."""


def optimised(study: StudySpec, engine: Engine, folder: StudyFolder) -> Iterator[Row]:
    """Yield the rows of the cases that Optuna asks for, as they come."""
    goal = study.goal
    assert goal is not None
    sampler = _optuna_study(study, folder.path / OPTUNA)
    asked = 0
    while asked < goal.trials:
        sampler.sampler = _sampler(goal.seed + asked)
        batch: dict[int, tuple[Any, StudyCase]] = {}
        for number in range(asked + 1, min(asked + goal.batch, goal.trials) + 1):
            trial = sampler.ask()
            values = {v.label: _suggest(trial, v) for v in study.variable}
            batch[number] = trial, case_of(study, number, values)
        rows: dict[int, Row] = {}
        for row in _run(engine, folder, [case for _, case in batch.values()]):
            rows[row.number] = row
            yield row
        for number, (trial, _) in batch.items():
            _tell(sampler, trial, goal, rows[number])
        asked += len(batch)


def excesses(goal: GoalSpec, row: Row) -> list[float]:
    """Return the excess of a row over each limit of the goal; zero or less is within."""
    values = [(limit, row.collected[limit.quantity]) for limit in goal.limits]
    return [_NONE if value != value else limit.excess(value) for limit, value in values]


def best_of(goal: GoalSpec, rows: Iterable[Row]) -> Row | None:
    """Return the best row within all limits, the first of equal ones; None if there is none."""
    sign = 1.0 if goal.minimise is not None else -1.0
    within = [
        row
        for row in rows
        if row.status == DONE
        and row.collected[goal.quantity] == row.collected[goal.quantity]
        and all(excess <= 0.0 for excess in excesses(goal, row))
    ]
    return min(within, key=lambda row: sign * row.collected[goal.quantity], default=None)


def _run(engine: Engine, folder: StudyFolder, cases: list[StudyCase]) -> Iterator[Row]:
    """Yield the rows of a batch: existing ones, and those of the cases that are run."""
    known = [row_of(folder.base, case) for case in cases]
    yield from (row for row in known if row is not None)
    missing = [case for case, row in zip(cases, known, strict=True) if row is None]
    if missing:
        yield from engine.run(missing)


def _optuna_study(study: StudySpec, path: Path) -> Any:
    """Return a new study of Optuna, stored in a file."""
    import optuna
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    assert study.goal is not None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    path.unlink(missing_ok=True)
    return optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(path))),
        study_name=study.title,
        direction="minimize" if study.goal.minimise is not None else "maximize",
    )


def _sampler(seed: int) -> Any:
    """Return the sampler of a batch; it depends on the seed and the earlier results alone."""
    import optuna

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        return optuna.samplers.TPESampler(
            seed=seed,
            n_startup_trials=_RANDOM,
            multivariate=True,
            constant_liar=True,
        )


def _suggest(trial: Any, variable: VariableSpec) -> Any:
    """Return the value that Optuna chooses for a variable: between two ends, or from a list."""
    if variable.ranged:
        low, high, log = variable.low, variable.high, variable.scale == "log"
        if variable.whole:
            return trial.suggest_int(variable.label, round(low or 0), round(high or 0), log=log)
        return trial.suggest_float(variable.label, low, high, log=log)
    values = listed_values(variable)
    return values[trial.suggest_categorical(variable.label, list(range(len(values))))]


def _tell(sampler: Any, trial: Any, goal: GoalSpec, row: Row) -> None:
    from optuna.trial import TrialState

    value = row.collected[goal.quantity]
    if row.status != DONE or value != value:
        sampler.tell(trial, state=TrialState.FAIL)
        return
    for text, excess in zip(goal.subject_to, excesses(goal, row), strict=True):
        trial.set_constraint(text, excess)
    trial.set_user_attr("case", row.number)
    sampler.tell(trial, value)
