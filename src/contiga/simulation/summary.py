"""Summarise a run: counts, timings and statuses, the content of summary.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.arrays.threads import thread_count
from contiga.io.column_units import column_units
from contiga.records import ContactStatus, FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.joint_checks import joint_notes
from contiga.simulation.checks.layers import thickness_of
from contiga.simulation.checks.matter_checks import added_masses
from contiga.simulation.checks.run_checks import notes_on
from contiga.simulation.checks.surface_checks import OPEN
from contiga.simulation.clock import Clock
from contiga.simulation.energy_balance import energy_summary, energy_warnings
from contiga.simulation.history import STATUS_OF_COLUMN
from contiga.simulation.joints import joint_summary
from contiga.simulation.model import Model, column_prefixes
from contiga.simulation.sensor_criteria import sensor_summary, sensors_without_criteria
from contiga.simulation.settle import Rest
from contiga.simulation.signals import filtered_columns, signal_warnings
from contiga.simulation.springs import slip_ring_summary, spring_summary
from contiga.simulation.step_columns import single_warnings, steps_summary
from contiga.version import __version__

NOTED = (ContactStatus.SLID_OFF, ContactStatus.HELD, ContactStatus.THROUGH)
"""Statuses that may be intended: they are noted."""
WARNED = (
    ContactStatus.LOST,
    ContactStatus.FOUND,
    ContactStatus.NOT_FINITE,
)
REACQUIRED_SHARE = 1e-3
"""Share of reacquired feet up to which there is no warning: points deeper than a nose or a fold is
wide lose their feet."""


def summarise(
    model: Model,
    history: dict[str, FloatArray],
    clock: Clock,
    findings: tuple[Finding, ...] = (),
    ends: tuple[float, ...] = (),
    rest: Rest | None = None,
) -> dict[str, Any]:
    """Return the summary of a finished run with the `findings` about its model.

    `ends` are earlier ends whose steps differ from those of a single run; `rest` is the outcome of
    settling before the run. What may be intended is a note; findings, doubtful statuses, flaws,
    forces that are not finite, energy balance errors and filters that fail are warnings.
    """
    statuses = _statuses(model, history)
    # Feet of points in contact over all steps, and how many of them converged without a proof.
    proved = {
        name: {
            "feet": int(np.sum(history[prefix + "n_contact"])),
            "unproved": int(np.sum(history[prefix + "n_unproved"])),
        }
        for name, prefix in column_prefixes(model).items()
    }
    notes_on_feet: list[str] = []
    warnings_on_feet: list[str] = []
    for name, counts in statuses.items():
        text = _status_texts({name: counts}, (ContactStatus.REACQUIRED,))
        is_rare = counts[ContactStatus.REACQUIRED.name] <= REACQUIRED_SHARE * proved[name]["feet"]
        (notes_on_feet if is_rare else warnings_on_feet).extend(text)
    # Mass added to the parts of each slave by mass scaling.
    scaled: dict[str, list[dict[str, Any]]] = {}
    for name, nodes in model.mechanism.nodes.items():
        if added := added_masses(nodes):
            scaled[name] = [mass._asdict() | {"share": mass.share} for mass in added]
    notes_on_ends = [
        f"the run went on from one to t = {end:g}, and took its steps until then for that end: "
        f"its numbers are not bit for bit those of one run to t = {model.stepping.end:g}"
        for end in ends
    ]
    # Flaws in the joints between faces of bodies, unless a finding reports them.
    places_of_open = {finding.where for finding in findings if finding.rule == OPEN}
    flaws = [
        f"{name}: {text}"
        for name, part in model.bodies.items()
        if f"body {name}" not in places_of_open
        for text in part.body.flaws
    ]
    measured_weights = []
    for part in model.contacts:
        if part.contact.weights == "area":
            prefix = column_prefixes(model)[part.name]
            work, error = (history[prefix + name] for name in ("work", "energy_error"))
            measured_weights.append(
                f'{part.name}: contact areas as they are measured weigh its force (weights = "area"'
                f"), which is the gradient of no energy: of the work of {np.abs(work).max():.3g} "
                f'the balance misses {error[-1]:.3g} at the end; weights = "rest" closes it'
            )
    not_finite = []
    for name, column in history.items():
        contact, _, quantity = name.rpartition(".")
        bad = np.flatnonzero(~np.isfinite(column))
        if quantity == "force" and len(bad):
            not_finite.append(
                f"{contact or model.contacts[0].name}: the force is not finite in {len(bad)} "
                f"steps, first at t = {history['time'][bad[0]]:g}; look at the law's numbers"
            )
    return {
        **_head(model, history, {**clock.seconds, "compile": clock.compiled}),
        "n_points": sum(len(part.slave.points) for part in model.slaves.values()),
        "n_elements": sum(part.body.surface.n_elements for part in model.bodies.values()),
        "threads": thread_count(),
        "statuses": statuses,
        "advice": _advice(statuses),
        "proved": proved,
        "energy": energy_summary(model, history),
        "settled": {} if rest is None else rest._asdict(),
        "mass_scaling": scaled,
        "sensors": sensor_summary(model, history),
        **_parts(model, history),
        "notes": joint_notes(model)
        + _status_texts(statuses, NOTED)
        + notes_on_feet
        + notes_on(model, history)
        + notes_on_ends,
        "findings": [finding._asdict() for finding in findings],
        "warnings": [str(finding) for finding in findings]
        + _status_texts(statuses, WARNED)
        + warnings_on_feet
        + not_finite
        + flaws
        + measured_weights
        + energy_warnings(model, history)
        + single_warnings(history)
        + signal_warnings(model, history),
    }


def summary_so_far(
    model: Model, history: dict[str, FloatArray], clock: Clock, *, stopped: bool
) -> dict[str, Any]:
    """Return the summary of a run that has not ended, with criteria only if it was `stopped`.

    Notes and findings are empty, and the only warning says how far the run has come.
    """
    if stopped:
        history = history | filtered_columns(model, history)
    statuses = _statuses(model, history)
    time, end = float(history["time"][-1]), model.stepping.end
    return {
        **_head(model, history, dict(clock.seconds)),
        "unfinished": {"time": time, "end": end},
        "statuses": statuses,
        "advice": _advice(statuses),
        "energy": energy_summary(model, history),
        "sensors": sensor_summary(model, history)
        if stopped
        else sensors_without_criteria(model, history),
        **_parts(model, history),
        "notes": [],
        "findings": [],
        "warnings": [f"the run has not ended: it stands at t = {time:g} of {end:g}"],
    }


def _head(
    model: Model, history: dict[str, FloatArray], timings: dict[str, float]
) -> dict[str, Any]:
    """Return title, version, units, timings and steps, with which every summary begins."""
    return {
        "title": model.title,
        "version": __version__,
        "units": dict(zip(("length", "mass", "time"), model.units, strict=True)),
        "columns": column_units(history, model.units),
        "timings": timings,
        "steps": len(history["time"]) - 1,
        "step_reasons": steps_summary(model, history),
    }


def _parts(model: Model, history: dict[str, FloatArray]) -> dict[str, Any]:
    """Return the facts about the parts of a model, from springs to bodies and slaves (inputs).

    `layers` has the thickness of the layer of each contact with a stress law. `depths` has the
    channel of the depth of a body in a deforming slave: the penetration of such a contact is only
    the compression of its own law.
    """
    thicknesses = {part.name: thickness_of(part.contact) for part in model.contacts}
    inputs = {name: part.body.facts() for name, part in model.bodies.items()}
    for name, slave_part in model.slaves.items():
        slave = slave_part.slave
        inputs[name] = {
            "kind": "slave",
            "points": len(slave.points),
            "active": int(slave.active.sum()),
            "facets": 0 if slave.facets is None else len(slave.facets),
        }
    return {
        "springs": spring_summary(model, history),
        "slip_rings": slip_ring_summary(model),
        "joints": joint_summary(model),
        "gas": {name: {"slave": chamber.slave} for name, chamber in model.gas.items()},
        "layers": {
            name: thickness for name, thickness in thicknesses.items() if thickness is not None
        },
        "depths": {
            part.name: f"{part.master}.travel"
            for part in model.contacts
            if part.slave in model.mechanism.element_movers and f"{part.master}.x" in history
        },
        "inputs": inputs,
    }


def _statuses(model: Model, history: dict[str, FloatArray]) -> dict[str, dict[str, int]]:
    """Return the number of points with each status, summed over the steps, by contact."""
    return {
        name: {
            status.name: int(np.sum(history[prefix + column]))
            for column, status in STATUS_OF_COLUMN.items()
        }
        for name, prefix in column_prefixes(model).items()
    }


def _status_texts(
    statuses: dict[str, dict[str, int]], reported: tuple[ContactStatus, ...]
) -> list[str]:
    """Return a text with count and advice for each `reported` status that a contact has had."""
    return [
        f"{name}: {counts[status.name]} times {status.name}. {status.advice}"
        for name, counts in statuses.items()
        for status in reported
        if counts[status.name]
    ]


def _advice(statuses: dict[str, dict[str, int]]) -> dict[str, str]:
    """Return advice on all statuses that were counted, by name."""
    counted = {name for counts in statuses.values() for name, n in counts.items() if n}
    return {status.name: status.advice for status in ContactStatus if status.name in counted}
