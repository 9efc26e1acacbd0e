"""Evaluate the energy balance of a run: the size of its error, and the likely cause."""

from __future__ import annotations

import numpy as np

from contiga.dynamics.stepping import AutoSteps
from contiga.laws.by_face import FaceLaws
from contiga.records import FloatArray
from contiga.simulation.mechanism import has_energy
from contiga.simulation.model import Model, column_prefixes
from contiga.simulation.step_columns import ENERGY_ERROR

ERROR_TOL = 0.01
"""Energy balance error, over the largest energy, up to which there is no warning."""


def energy_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, float]:
    """Return the largest energy of a dynamic system and the errors of its energy balance.

    The result is empty if forces move nothing.

    Keys: `most` kinetic, stored and lost together, `error` at the end, `worst` the largest
    departure at any step, and `relative`, that over `most`.
    """
    return balance_of(history) if model.mechanism.has_dynamics else {}


def balance_of(history: dict[str, FloatArray]) -> dict[str, float]:
    """Return the numbers of `energy_summary` for any history that has the energies of a system."""
    total = history["energy.total"]
    losses = ("friction", "damping", "hysteresis", "viscosity")
    lost = sum(history[f"energy.{name}"] for name in losses if f"energy.{name}" in history)
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
    """Return one message with the likely cause if the energy balance error is above `ERROR_TOL`.

    The list is empty for a smaller error, or if forces move nothing.
    """
    balance = energy_summary(model, history)
    if not balance or balance["relative"] <= ERROR_TOL:
        return []
    at = worst_step(history)
    cause = (
        _likely_cause(model, history, at)
        or f"the step is too long there: {_advice_on_steps(model)}"
    )
    passed = int(np.count_nonzero(history.get(ENERGY_ERROR, ())))
    if passed:
        cause += f". {passed} steps have an error that shorter ones would not reduce"
    return [energy_text(balance, float(history["time"][at]), cause)]


def _advice_on_steps(model: Model) -> str:
    """Return advice on how to get shorter steps."""
    if isinstance(model.stepping, AutoSteps):
        return 'give shorter ones, as time.largest or a number in place of "auto"'
    return 'take a smaller step, or step = "auto"'


def worst_step(history: dict[str, FloatArray]) -> int:
    """Return the row in which the energy balance error changes most, the first of equals."""
    error = history["energy.error"]
    return int(np.argmax(np.abs(np.diff(error, prepend=error[0]))))


def energy_text(balance: dict[str, float], time: float, cause: str) -> str:
    """Return a message on the error, the time when most of it arose, and its likely cause."""
    return (
        f"energy balance: the error reaches {100.0 * balance['relative']:.3g} % of the largest "
        f"energy of {balance['most']:.4g}, most of it at t = {time:g}; {cause}"
    )


def _likely_cause(model: Model, history: dict[str, FloatArray], at: int) -> str:
    """Return a text on the contact that is the likely cause, with the reason; empty without one.

    It is the first that weighs forces by measured areas, else the first with points that tunnelled,
    were lost or were found again within a step of the row `at`, else the one that works most there.
    """
    prefixes = column_prefixes(model)
    for part in model.contacts:
        if part.contact.weights == "area":
            return (
                f'contact {part.name}: its forces are weighed by measured areas (weights = "area"),'
                " which are the gradient of no energy"
            )
    for part in model.contacts:
        for column, text in (
            ("n_through", "points tunnelled"),
            ("n_lost", "points were lost"),
            ("n_reacquired", "feet were found again elsewhere"),
            ("n_found", "points were found inside"),
            ("n_slid_off", "points slid off over a border"),
        ):
            count = int(history[prefixes[part.name] + column][max(at - 1, 0) : at + 2].sum())
            if count:
                return f"contact {part.name}: {count} {text} there"
    works = {}
    for part in model.contacts:
        work = history[prefixes[part.name] + "work"]
        works[part.name] = abs(float(work[at] - work[max(at - 1, 0)]))
    if works and max(works.values()) > 0.0:
        name = max(works, key=lambda key: works[key])
        cause = _reason_without_energy(model, name) or _advice_on_steps(model)
        return f"contact {name} works most there: {cause}"
    return ""


def _reason_without_energy(model: Model, name: str) -> str:
    """Return the first reason why the forces of a contact conserve no energy at any step.

    The text is empty if there is none.
    """
    part = next(part for part in model.contacts if part.name == name)
    facts, law = part.contact.master.facts(), part.contact.law
    if facts.get("normals") == "vertex":
        return (
            "its master's normals are those of vertices, blended over its facets, which are the "
            'gradient of no depth: normals = "facet", a finer mesh, or the CAD keeps more at any '
            "step"
        )
    if not has_energy(law):
        return "its law's stiffness follows the step, so that it has no energy: a penalty law has"
    if getattr(law, "share", "") == "penetration":
        return (
            "its law shares one force by penetration, which is the gradient of no energy: no step "
            'keeps it; share = "deepest" does'
        )
    if isinstance(law, FaceLaws):
        return (
            "its laws differ from face to face, so that forces jump where points go over from one "
            "to another, which is the gradient of no energy: laws that are alike there keep it"
        )
    if facts.get("normals") == "facet":
        return (
            "its master is of facets, over whose edges normals jump: a finer mesh, or the CAD, "
            "keeps more at any step"
        )
    return ""
