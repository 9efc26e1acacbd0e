"""Optimisation: Optuna chooses the next cases and gets their results.

Optuna suggests cases in batches, and gets the results of a batch in the order of their numbers: the
next suggestions depend on the results alone, never on the order in which cases finish or on the
number of workers. A study that is resumed starts from the first suggestion again, and takes the
rows that exist already.
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

_N_RANDOM = 10
"""Number of cases chosen at random before the search begins."""
_EXCESS_OF_MISSING = 1e300
"""Excess of a missing quantity over its limit."""


def optimised(study: StudySpec, engine: Engine, folder: StudyFolder) -> Iterator[Row]:
    """Yield the rows of the cases that Optuna suggests, as they come."""
    goal = study.goal
    assert goal is not None
    optimiser = _optuna_study(study, folder.path / OPTUNA)
    n_suggested = 0
    while n_suggested < goal.trials:
        optimiser.sampler = _sampler(goal.seed + n_suggested)
        batch: dict[int, tuple[Any, StudyCase]] = {}
        last = min(n_suggested + goal.batch, goal.trials)
        for number in range(n_suggested + 1, last + 1):
            trial = optimiser.ask()
            values = {v.label: _suggest(trial, v) for v in study.variable}
            batch[number] = trial, case_of(study, number, values)
        rows: dict[int, Row] = {}
        missing = []
        for _, case in batch.values():
            row = row_of(folder.base, case)
            if row is None:
                missing.append(case)
            else:
                rows[row.number] = row
        yield from rows.values()
        for row in engine.run(missing) if missing else ():
            rows[row.number] = row
            yield row
        for number, (trial, _) in batch.items():
            _tell(optimiser, trial, goal, rows[number])
        n_suggested += len(batch)


def excesses(goal: GoalSpec, row: Row) -> list[float]:
    """Return the excess of a row over each limit of the goal; zero or less is within."""
    values = [(limit, row.collected[limit.quantity]) for limit in goal.limits]
    return [
        _EXCESS_OF_MISSING if value != value else limit.excess(value) for limit, value in values
    ]


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
            n_startup_trials=_N_RANDOM,
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


def _tell(optimiser: Any, trial: Any, goal: GoalSpec, row: Row) -> None:
    """Give Optuna the result of a case, and its excess over each limit."""
    from optuna.trial import TrialState

    value = row.collected[goal.quantity]
    if row.status != DONE or value != value:
        optimiser.tell(trial, state=TrialState.FAIL)
        return
    for text, excess in zip(goal.subject_to, excesses(goal, row), strict=True):
        trial.set_constraint(text, excess)
    trial.set_user_attr("case", row.number)
    optimiser.tell(trial, value)
