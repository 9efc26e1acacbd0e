"""Write into the history why each step was as long as it was."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.reasons import Choice, Cut, Reason

REASON, OF, TRIES, ENERGY_ERROR = "step.reason", "step.of", "step.tries", "step.energy_error"
SINGLE, LAG, LATE = "step.single", "step.lag", "step.late"
COLUMNS = (REASON, OF, TRIES, ENERGY_ERROR, SINGLE, LAG, LATE)
"""Columns of automatic steps: number of the `Reason`, of its part in `names_of` (−1 for none),
steps worked out, energy balance error that no shorter one would have reduced, ω h of single
points that swing and are not followed, radians of phase that they are off by, and the time by which
free nodes hand on a force that they share early or late."""

LAGGED = 0.02
"""Radians of phase, all in all, from on which it is told: 2 % of the largest force in mid-swing."""
SHIFTED = 1e-3
"""Of the run: by so much or by a step, the longer, what is handed on may be early or late."""

FOLLOWED = 0.3
"""ω h up to which a swing is right to about 1 % over half of it."""
RIGHT = 0.01
"""Radians of phase that a swing is right to 1 % with."""


def names_of(model: Model) -> list[str]:
    """Return what asks for short steps, in words, by its number in histories."""
    return [
        *(f"contact {part.name!r}" for part in model.contacts),
        *(f"viscous friction of contact {part.name!r}" for part in model.contacts),
        *(f"spring {name!r}" for name in model.springs),
        *(f"body {name!r}" for name in model.bodies),
    ]


def step_columns(model: Model, choice: Choice | None) -> dict[str, float]:
    """Return the columns of one step; at the start those of none."""
    if choice is None:
        return dict(zip(COLUMNS, (float(Reason.LARGEST), -1.0, *5 * (0.0,)), strict=True))
    names = names_of(model)
    of = names.index(choice.cut.of) if choice.cut.of in names else -1
    cut = float(choice.cut.reason), float(of), float(choice.tries)
    columns = *cut, choice.energy_error, choice.single, choice.lag, choice.late
    return dict(zip(COLUMNS, columns, strict=True))


def single_warnings(history: dict[str, FloatArray]) -> list[str]:
    """Return warnings about single points that steps do not follow.

    They swing faster than steps follow, or so long that their phase is off, or forces on them come
    early or late.
    """
    if SINGLE not in history:
        return []
    warnings: list[str] = []
    time, single, lag, late = (history[name] for name in ("time", SINGLE, LAG, LATE))
    off = float(lag.sum())
    at = int(np.argmax(single if single.any() else lag))
    step = time[at] - time[at - 1]
    if single.any():
        how = f"swing faster than steps follow, most at t = {time[at]:g} (ω h = {single[at]:.2g})"
        largest = step * FOLLOWED / single[at]
    elif off > LAGGED:
        how = f"swing for so long that they are {off:.2g} rad off, most of it at t = {time[at]:g}"
        largest = step * np.sqrt(RIGHT / off)
    if single.any() or off > LAGGED:
        warnings.append(
            f"step: single nodes, or points that share one force, {how}: what one of them does, "
            "and how what stands on them rocks, is stable there and not right to phase; sums and "
            f"ways of whole bodies are. A time.largest of {largest:.2g} follows them"
        )
    # Points that hand on a force early or late by more than a step.
    steps = np.diff(time, prepend=time[0])
    excess = late / np.maximum(steps, SHIFTED * (time[-1] - time[0])) if late.any() else late
    at = int(np.argmax(excess))
    if excess[at] > 1.0:
        largest = float(steps[: at + 1].max()) / np.sqrt(excess[at])
        warnings.append(
            f"step: points that share one force hand it on up to {late[at]:.2g} early or late, "
            f"as at t = {time[at]:g}: by about so much which of them carries it, and its moment, "
            f"is uncertain; sums are not. A time.largest of {largest:.2g} makes them certain"
        )
    return warnings


def steps_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, Any]:
    """Return how often each reason, by its part, determined an automatic step.

    Keys: `least` step and `when`, `tries` worked out, `let_pass` steps with an energy
    balance error that shorter ones would not reduce, its sum `energy_error`, and `reasons`, a list
    with the most frequent first: `number` (as columns have it), `reason`, `of`, `told`, `steps`,
    `time`. Empty of other steps.
    """
    if REASON not in history or len(history["time"]) < 2:
        return {}
    lengths, names = np.diff(history["time"]), names_of(model)
    reasons, of, tries, error = (history[name][1:] for name in (REASON, OF, TRIES, ENERGY_ERROR))
    entries = []
    for reason, who in sorted({*zip(reasons.tolist(), of.tolist(), strict=True)}):
        rows = (reasons == reason) & (of == who)
        cut = Cut(0.0, Reason(int(reason)), names[int(who)] if who >= 0 else "")
        entries.append(
            {
                "number": [int(reason), int(who)],
                "reason": cut.reason.name.lower(),
                "of": cut.of,
                "told": cut.said(),
                "steps": int(rows.sum()),
                "time": float(lengths[rows].sum()),
            }
        )
    least = int(np.argmin(lengths))
    return {
        "least": float(lengths[least]),
        "when": float(history["time"][least + 1]),
        "tries": int(tries.sum()),
        "let_pass": int(np.count_nonzero(error)),
        "energy_error": float(error.sum()),
        "reasons": sorted(entries, key=lambda one: -one["steps"]),
    }
