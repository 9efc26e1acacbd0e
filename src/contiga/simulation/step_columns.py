"""Write the reasons for the lengths of automatic steps into the history and the summary."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.reasons import Choice, Cut, Reason

REASON, OF, TRIES, ENERGY_ERROR = "step.reason", "step.of", "step.tries", "step.energy_error"
SINGLE, LAG, LATE = "step.single", "step.lag", "step.late"
COLUMNS = (REASON, OF, TRIES, ENERGY_ERROR, SINGLE, LAG, LATE)
"""Columns of automatic steps: number of the `Reason`, number of its part in `names_of` or −1,
steps computed, energy balance error that shorter steps have not reduced, ω h of single points whose
swing is not followed, their phase error in radians, and the time by which free nodes hand over a
shared force early or late."""

LAG_TOL = 0.02
"""Total phase error, radians, up to which there is no warning: 2 % of the force in mid-swing."""
LATE_TOL = 1e-3
"""Allowed error of the time of a hand-over, as a share of the run; at least one step."""

FOLLOWED_SWING = 0.3
"""ω h up to which half a swing is accurate to about 1 %."""
PHASE_TOL = 0.01
"""Phase error, radians, with which a swing is accurate to 1 %."""


def names_of(model: Model) -> list[str]:
    """Return the parts that may limit steps, in words; their indices are the numbers in histories.

    Elements, gas and joints have no number.
    """
    return [
        *(f"contact {part.name!r}" for part in model.contacts),
        *(f"viscous friction of contact {part.name!r}" for part in model.contacts),
        *(f"spring {name!r}" for name in model.springs),
        *(f"body {name!r}" for name in model.bodies),
    ]


def step_columns(model: Model, choice: Choice | None) -> dict[str, float]:
    """Return the columns of one step; default values at the start, whose `choice` is None.

    The part that limits the step has its number in `names_of`, or −1.
    """
    if choice is None:
        return dict(zip(COLUMNS, (float(Reason.LARGEST), -1.0, *5 * (0.0,)), strict=True))
    names = names_of(model)
    of = names.index(choice.cut.of) if choice.cut.of in names else -1
    cut = float(choice.cut.reason), float(of), float(choice.tries)
    columns = *cut, choice.energy_error, choice.single, choice.lag, choice.late
    return dict(zip(COLUMNS, columns, strict=True))


def single_warnings(history: dict[str, FloatArray]) -> list[str]:
    """Return warnings about single points that steps do not follow; none without automatic steps.

    The points swing too fast for the steps, or so long that their phase is wrong by `LAG_TOL` in
    all, or forces on them come early or late by more than a step and than `LATE_TOL` of the run.
    """
    if SINGLE not in history:
        return []
    warnings: list[str] = []
    time, single, lag, late = (history[name] for name in ("time", SINGLE, LAG, LATE))
    total_lag = float(lag.sum())
    at = int(np.argmax(single if single.any() else lag))
    step = time[at] - time[at - 1]
    if single.any():
        text = f"swing faster than steps follow, most at t = {time[at]:g} (ω h = {single[at]:.2g})"
        largest = step * FOLLOWED_SWING / single[at]
    elif total_lag > LAG_TOL:
        text = f"swing for so long that they are {total_lag:.2g} rad off, "
        text += f"most of it at t = {time[at]:g}"
        largest = step * np.sqrt(PHASE_TOL / total_lag)
    if single.any() or total_lag > LAG_TOL:
        warnings.append(
            f"step: single nodes, or points that share one force, {text}: what one of them does, "
            "and how what stands on them rocks, is stable there and not right to phase; sums and "
            f"ways of whole bodies are. A time.largest of {largest:.2g} follows them"
        )
    # Points that hand over a force early or late by more than a step.
    steps = np.diff(time, prepend=time[0])
    excess = late / np.maximum(steps, LATE_TOL * (time[-1] - time[0])) if late.any() else late
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
    """Return how often each reason, with its part, determined an automatic step.

    Keys: `least`, the length of the shortest step, and `when` it ended, `tries` computed,
    `let_pass`, the number of steps with an energy balance error that shorter ones would not reduce,
    `energy_error`, the sum of these errors, and `reasons`, a list with the most frequent first:
    `number` (as in the columns), `reason`, `of`, `told` (both in words), `steps`, `time`. The
    result is empty for steps that are not automatic.
    """
    if REASON not in history or len(history["time"]) < 2:
        return {}
    lengths, names = np.diff(history["time"]), names_of(model)
    reasons, of, tries, error = (history[name][1:] for name in (REASON, OF, TRIES, ENERGY_ERROR))
    entries = []
    for reason, part in sorted({*zip(reasons.tolist(), of.tolist(), strict=True)}):
        rows = (reasons == reason) & (of == part)
        cut = Cut(0.0, Reason(int(reason)), names[int(part)] if part >= 0 else "")
        entries.append(
            {
                "number": [int(reason), int(part)],
                "reason": cut.reason.name.lower(),
                "of": cut.of,
                "told": cut.text(),
                "steps": int(rows.sum()),
                "time": float(lengths[rows].sum()),
            }
        )
    shortest = int(np.argmin(lengths))
    return {
        "least": float(lengths[shortest]),
        "when": float(history["time"][shortest + 1]),
        "tries": int(tries.sum()),
        "let_pass": int(np.count_nonzero(error)),
        "energy_error": float(error.sum()),
        "reasons": sorted(entries, key=lambda entry: -entry["steps"]),
    }
