"""Optimisation: Optuna chooses the next cases and gets their results.

Optuna suggests cases in batches, and gets the results of a batch in the order of their numbers: the
next suggestions depend on the results alone, never on the order in which cases finish or on the
number of workers. A study that is resumed starts from the first suggestion again, and takes the
rows that exist already.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
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
    """Yield the rows of the cases that Optuna suggests, as they come.

    Rows in the folder of the study are yielded instead of running their cases. Optuna's log there
    is replaced. A failed case, or one without the quantity of the goal, is a failed trial.
    """
    import optuna
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    goal = study.goal
    assert goal is not None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    path = folder.path / OPTUNA
    path.unlink(missing_ok=True)
    optimiser = optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(path))),
        study_name=study.title,
        direction="minimize" if goal.minimise is not None else "maximize",
    )
    n_suggested = 0
    while n_suggested < goal.trials:
        # A new sampler for each batch depends on the seed and the earlier results alone.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            optimiser.sampler = optuna.samplers.TPESampler(
                seed=goal.seed + n_suggested,
                n_startup_trials=_N_RANDOM,
                multivariate=True,
                constant_liar=True,
            )
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
            row = rows[number]
            value = row.collected[goal.quantity]
            if row.status != DONE or value != value:
                optimiser.tell(trial, state=optuna.trial.TrialState.FAIL)
                continue
            for text, excess in zip(goal.subject_to, excesses(goal, row), strict=True):
                trial.set_constraint(text, excess)
            trial.set_user_attr("case", row.number)
            optimiser.tell(trial, value)
        n_suggested += len(batch)


def excesses(goal: GoalSpec, row: Row) -> list[float]:
    """Return the excess of a row over each limit of the goal, 1e300 for a missing quantity.

    Zero or less is within the limit.
    """
    values = [(limit, row.collected[limit.quantity]) for limit in goal.limits]
    return [
        _EXCESS_OF_MISSING if value != value else limit.excess(value) for limit, value in values
    ]


def best_of(goal: GoalSpec, rows: Iterable[Row]) -> Row | None:
    """Return the best complete row within all limits, the first of equal ones; None without one."""
    sign = 1.0 if goal.minimise is not None else -1.0
    within = [
        row
        for row in rows
        if row.status == DONE
        and row.collected[goal.quantity] == row.collected[goal.quantity]
        and all(excess <= 0.0 for excess in excesses(goal, row))
    ]
    return min(within, key=lambda row: sign * row.collected[goal.quantity], default=None)


def _suggest(trial: Any, variable: VariableSpec) -> Any:
    """Return the value that Optuna chooses for a variable: between two ends, or from a list."""
    if variable.ranged:
        low, high, log = variable.low, variable.high, variable.scale == "log"
        if variable.whole:
            return trial.suggest_int(variable.label, round(low or 0), round(high or 0), log=log)
        return trial.suggest_float(variable.label, low, high, log=log)
    values = listed_values(variable)
    return values[trial.suggest_categorical(variable.label, list(range(len(values))))]
