"""What a run was: counts, timings, statuses. The content of summary.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.num.threads import thread_count
from contiga.records import ContactStatus, FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.model import Model
from contiga.simulation.step import COUNTED
from contiga.version import __version__


def summarise(
    model: Model,
    history: dict[str, FloatArray],
    clock: Clock,
) -> dict[str, Any]:
    """The summary of a finished run."""
    several = len(model.contacts) > 1
    statuses = {
        part.name: _statuses(history, f"{part.name}." if several else "") for part in model.contacts
    }
    return {
        "title": model.title,
        "version": __version__,
        "units": dict(zip(("length", "mass", "time"), model.units, strict=True)),
        "timings": {**clock.seconds, "compile": clock.compiled},
        "steps": len(history["time"]),
        "n_points": sum(len(part.slave.points) for part in model.slaves.values()),
        "n_elements": sum(part.body.surface.n_elements for part in model.bodies.values()),
        "threads": thread_count(),
        "statuses": statuses,
        "proved": {
            part.name: _proved(history, f"{part.name}." if several else "")
            for part in model.contacts
        },
        "inputs": _inputs(model),
        "warnings": _warnings(statuses) + _not_finite(model, history) + _flaws(model),
    }


def _statuses(history: dict[str, FloatArray], prefix: str) -> dict[str, int]:
    """Points that took each status, summed over the steps."""
    return {
        status.name: int(np.sum(history[prefix + column])) for column, status in COUNTED.items()
    }


def _proved(history: dict[str, FloatArray], prefix: str) -> dict[str, int]:
    """Feet of points in contact over all steps, and how many of them were merely converged."""
    return {
        "feet": int(np.sum(history[prefix + "n_contact"])),
        "unproved": int(np.sum(history[prefix + "n_unproved"])),
    }


def _inputs(model: Model) -> dict[str, dict[str, Any]]:
    inputs: dict[str, dict[str, Any]] = {}
    for name, body_part in model.bodies.items():
        inputs[name] = body_part.body.facts()
    for name, slave_part in model.slaves.items():
        slave = slave_part.slave
        inputs[name] = {
            "kind": "slave",
            "points": len(slave.points),
            "active": int(slave.active.sum()),
            "facets": 0 if slave.facets is None else len(slave.facets),
        }
    return inputs


def _flaws(model: Model) -> list[str]:
    """What is wrong with how the faces of bodies meet."""
    return [f"{name}: {text}" for name, part in model.bodies.items() for text in part.body.flaws]


def _not_finite(model: Model, history: dict[str, FloatArray]) -> list[str]:
    texts = []
    for name, column in history.items():
        contact, _, what = name.rpartition(".")
        bad = np.flatnonzero(~np.isfinite(column))
        if what == "force" and len(bad):
            texts.append(
                f"{contact or model.contacts[0].name}: the force is not finite in {len(bad)} "
                f"steps, first at t = {history['time'][bad[0]]:g}; look at the law's numbers"
            )
    return texts


def _warnings(statuses: dict[str, dict[str, int]]) -> list[str]:
    texts = []
    for name, counts in statuses.items():
        lost = counts[ContactStatus.LOST.name]
        if lost:
            texts.append(
                f"{name}: {lost} times a point in contact could not be solved and was left out of "
                "the forces; take smaller steps"
            )
        found = counts[ContactStatus.FOUND.name]
        if found:
            texts.append(
                f"{name}: {found} times a point lay inside without having been seen to come in; it "
                "was taken into contact at its closest point. Please report the case"
            )
        anew = counts[ContactStatus.REACQUIRED.name]
        if anew:
            texts.append(
                f"{name}: {anew} times the foot of a point in contact vanished and was found again "
                "elsewhere; take smaller steps to see where"
            )
        bad = counts[ContactStatus.NOT_FINITE.name]
        if bad:
            texts.append(f"{name}: {bad} times a point had no finite position")
    return texts
