"""What a run says of its energy: how much of it is nowhere, and why that may be."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.model import Model

LARGE = 0.01
"""Part of the largest energy that may be nowhere without a warning."""


def energy_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, float]:
    """The largest energy of a system that forces move, and what of it is nowhere; else empty.

    Keys: `most` kinetic, stored and lost together, `error` at the end, `worst` the largest
    departure at any step, and `relative`, that over `most`.
    """
    return told_of(history) if model.mechanism.moved else {}


def told_of(history: dict[str, FloatArray]) -> dict[str, float]:
    """The same of any history with the energies of a system."""
    total = history["energy.total"]
    lost = sum(history[f"energy.{name}"] for name in ("friction", "damping", "hysteresis"))
    most = float(np.max(total + lost))
    error = history["energy.error"]
    worst = float(np.max(np.abs(error)))
    return {
        "most": most,
        "error": float(error[-1]),
        "worst": worst,
        "relative": worst / most if most > 0.0 else 0.0,
    }


def energy_warnings(model: Model, history: dict[str, FloatArray]) -> list[str]:
    """Says where energy goes that is nowhere, if it is much."""
    told = energy_summary(model, history)
    if not told or told["relative"] <= LARGE:
        return []
    at = worst_step(history)
    cause = (
        _blamed(model, history, at)
        or 'the step is too long there: take a smaller one, or step = "auto"'
    )
    return [energy_text(told, float(history["time"][at]), cause)]


def worst_step(history: dict[str, FloatArray]) -> int:
    """The row in which most energy came or went that is nowhere."""
    error = history["energy.error"]
    return int(np.argmax(np.abs(np.diff(error, prepend=error[0]))))


def energy_text(told: dict[str, float], time: float, cause: str) -> str:
    """That much energy is nowhere, most of it since a time, and why that may be."""
    return (
        f"energy: {100.0 * told['relative']:.3g} % of the largest energy of {told['most']:.4g} is "
        f"nowhere, most of it at t = {time:g}; {cause}"
    )


def _blamed(model: Model, history: dict[str, FloatArray], at: int) -> str:
    """The contact that is the likely cause, with what about it; empty where none is."""
    several = len(model.contacts) > 1
    for part in model.contacts:
        if part.contact.weights == "area":
            return (
                f'contact {part.name}: its forces are weighed by measured areas (weights = "area"),'
                " which are the gradient of no energy"
            )
    for part in model.contacts:
        prefix = f"{part.name}." if several else ""
        for column, text in (
            ("n_through", "points went right through"),
            ("n_lost", "points were lost"),
            ("n_reacquired", "feet were found again elsewhere"),
            ("n_found", "points were found inside"),
            ("n_slid_off", "points slid off over a border"),
        ):
            count = int(history[prefix + column][max(at - 1, 0) : at + 2].sum())
            if count:
                return f"contact {part.name}: {count} {text} there"
    works = {}
    for part in model.contacts:
        work = history[f"{part.name}.work" if several else "work"]
        works[part.name] = abs(float(work[at] - work[max(at - 1, 0)]))
    if works and max(works.values()) > 0.0:
        name = max(works, key=lambda key: works[key])
        return f'contact {name} works most there: take a smaller step, or step = "auto"'
    return ""
