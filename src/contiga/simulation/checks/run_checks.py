"""Find in a run contact that never came, went too deep, or lay on few nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length
from contiga.laws.force import ForceLaw
from contiga.masters.nearness import nearest
from contiga.records import FloatArray
from contiga.simulation.checks.depth_checks import (
    STEP_OF_LAYER,
    deeper_than,
    deeper_than_elements,
)
from contiga.simulation.checks.facing import two_layers
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import layers_of
from contiga.simulation.checks.matter_ran import check_matter_ran
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.checks.spring_checks import check_springs_ran
from contiga.simulation.checks.turned import ran_from_behind
from contiga.simulation.checks.wall_checks import jump_columns, jumped
from contiga.simulation.model import Model, column_prefixes
from contiga.simulation.system_state import SystemState
from contiga.slaves.sampling import more_points
from contiga.slaves.skin import facet_width

Columns = Mapping[str, FloatArray]
# Facets across a region of contact below which its forces depend on where the nodes happen to lie.
_ACROSS = 2.0
# Of the largest energy of a contact: what damping may take.
_DAMPED = 0.75
# Of the greatest penetration: what points that are let go have left of it at most.
_DEEP = 0.4
# Times the longest step further in: how deep what was let in is at first.
_STEPS = 2.0
# Of the points in contact at most: the last so many may leave as they like.
_LAST = 0.1
# Of a distance that is told: by how much another point may be nearer.
_SEEN = 1e-3
# Of the force of an impact: what is left of it where it is over.
_PRESSED = 0.2
# Of the time since the first contact: its end, and of the penetration what may change in it.
_LATE, _GROWN = 0.2, 0.01
# Of its curve's force: what the resultant may lack without a word.
_APART = 0.02


def check_run(model: Model, history: Columns, last: SystemState) -> tuple[Finding, ...]:
    """Return what the history and the last state of a run show of its model."""
    scene = Scene(model)
    findings: list[Finding] = []
    for pair in scene.pairs:
        columns = _columns(model, pair, history)
        for check in _CHECKS:
            findings += check(scene, pair, columns, last)
    findings += check_springs_ran(scene, history)
    findings += check_matter_ran(scene, history, last)
    return tuple(findings)


def check_crest(model: Model, state: SystemState) -> tuple[Finding, ...]:
    """Return findings about contacts in the state at the greatest force."""
    scene = Scene(model)
    findings: list[Finding] = []
    for pair in scene.pairs:
        contact = state.contacts[pair.part.name]
        rows = np.flatnonzero(contact.in_contact[: len(pair.slave)])
        facets = pair.slave.facets
        touched: NDArray[np.bool_] = np.zeros(0, np.bool_)
        if facets is not None and pair.contact.quadrature == "nodes":
            touched = np.asarray(np.isin(facets, rows).any(axis=1))
        if facets is not None and touched.any():
            corners = contact.points_B[facets[touched]]
            sides = corners - np.roll(corners, 1, axis=1)
            edge = float(np.sqrt(np.square(sides).sum(axis=2)).mean())
            across = length(np.ptp(contact.points_B[rows], axis=0)) / edge
            if across < _ACROSS:
                text = (
                    f"at the greatest force {len(rows)} nodes are in contact, {across:.2g} facets "
                    f"of {scene.said(edge)} across: the force depends on where the nodes happen to "
                    "lie"
                )
                finer = f"Take a finer mesh there{more_points(pair.contact.quadrature)}"
                findings.append(Finding("coarse", pair.where, text, finer))
        findings += two_layers(pair, contact)
    return tuple(findings)


def notes_on(model: Model, history: Columns) -> list[str]:
    """Return remarks on numbers that a reader may take for something else.

    The force that a law sets is a sum of magnitudes, and what is printed is their resultant.
    """
    scene, notes = Scene(model), []
    for pair in scene.pairs:
        own = _columns(model, pair, history)
        law, at = pair.contact.law, int(np.argmax(own["force"]))
        if not isinstance(law, ForceLaw) or law.hysteresis is not None:
            continue
        resultant = float(law.curve(own["max_penetration"][at]))
        printed = float(own["force"][at])
        if printed > 0.0 and resultant > (1.0 + _APART) * printed and pair.contact.friction is None:
            remedy = (
                "elements of a tenth of the radius that presses bring it nearer"
                if law.share == "deepest"
                else 'with share = "deepest" it is nearer to what the curve says'
            )
            notes.append(
                f"{pair.part.name}: its curve sets the sum of the nodal forces, "
                f"{scene.said(resultant, 'force')} at the peak; printed is their resultant, "
                f"{scene.said(printed, 'force')}, as they do not all point one way; {remedy}"
            )
    return notes


def _columns(model: Model, pair: Pair, history: Columns) -> dict[str, FloatArray]:
    """Return the columns of one contact in the history, and the times."""
    prefix = column_prefixes(model)[pair.part.name]
    names = (
        *("n_contact", "n_tunnelled", "max_penetration", "force"),
        *("energy_stored", "energy_damping", "energy_hysteresis", "energy_friction"),
    )
    columns = {name: history[prefix + name] for name in names}
    return {"time": history["time"]} | columns | jump_columns(history, prefix)


def _no_contact(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report contacts in which nothing ever touched, unless that was known before the run.

    So it reports open faces that were met or passed from behind.
    """
    met = bool(own["n_contact"].any())
    from_behind = list(ran_from_behind(pair, last, met=met))
    yield from from_behind
    if met or from_behind:
        return
    rows = np.flatnonzero(pair.slave.active).astype(np.int32)
    points = last.contacts[pair.part.name].points_B
    finite = np.isfinite(points[rows]).all(axis=1)
    if not finite.any():
        return
    apart = nearest(pair.body.surface, points, rows[finite], share=_SEEN).gap
    yield Finding(
        "apart",
        pair.where,
        f"no point of {pair.part.slave} came into contact in the whole run; at its end they are "
        f"{scene.said(apart)} from {pair.part.master}",
        "Look at where they are placed, at their units and at what moves them",
    )


def _deep(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report penetrations beyond a law's table, and steps in which points went in too far."""
    at = int(np.nanargmax(own["max_penetration"]))
    reached = float(own["max_penetration"][at]), float(own["time"][at])
    for layer in layers_of(pair.contact):
        yield from deeper_than(layer, pair.where, reached, scene.said)
    yield from deeper_than_elements(pair, own, scene.said)
    ways = np.diff(own["max_penetration"])
    layers = [layer.thickness for layer in layers_of(pair.contact) if layer.thickness]
    if len(ways) == 0 or not layers or not ways.max() > STEP_OF_LAYER * min(layers):
        return
    at = int(np.argmax(ways))
    yield Finding(
        "step",
        pair.where,
        f"in the one step to t = {scene.said(own['time'][at + 1], 'time')} points went "
        f"{scene.said(ways[at])} deeper into a layer of {scene.said(min(layers))}",
        'Take shorter steps, or step = "auto" where forces move the bodies',
    )


def _sudden(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report contacts that begin deeper than a facet is wide: the mesh had let the body in."""
    touched = np.flatnonzero(own["n_contact"] > 0)
    if pair.slave.facets is None or len(touched) == 0 or touched[0] == 0:
        return
    first = int(touched[0])
    deep, width = own["max_penetration"], facet_width(pair.slave.points, pair.slave.facets)
    further = np.diff(deep[first:]).max(initial=0.0)
    if deep[first] > max(width, _STEPS * further):
        yield Finding(
            "coarse",
            pair.where,
            f"contact begins at t = {scene.said(float(own['time'][first]), 'time')} with points "
            f"{scene.said(float(deep[first]))} deep, and facets of {pair.part.slave} are "
            f"{scene.said(width)} wide: too coarse, they let {pair.part.master} in before a point "
            "of theirs was touched",
            f"Take a finer mesh there{more_points(pair.contact.quadrature)}; "
            "where one step went so far, shorter steps",
        )


def _damped(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report damping that does most of the work of a contact."""
    parts = [own[f"energy_{name}"] for name in ("stored", "damping", "hysteresis", "friction")]
    most = float(np.max(sum(parts)))
    lost = float(own["energy_damping"][-1])
    if most > 0.0 and lost > _DAMPED * most:
        yield Finding(
            "damping",
            pair.where,
            f"its damping takes {100.0 * lost / most:.3g} % of the work done on it, "
            f"{scene.said(lost, 'energy')}: the curve hardly matters",
            "Look at the unit of the damping; damping_ratio is a share of the critical one",
        )


def _unfinished(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report impacts that are cut off before the free side comes back.

    What rests does not move, and what swings to and fro has come back before.
    """
    deep, force, time = own["max_penetration"], own["force"], own["time"]
    if not pair.free or force[-1] <= _PRESSED * force.max():
        return
    began = float(time[np.argmax(deep > 0.0)])
    late = deep[time >= time[-1] - _LATE * (time[-1] - began)]
    once = deep[-1] <= (1.0 + _GROWN) * deep[np.argmax(deep) :].min()
    if once and np.ptp(late) > _GROWN * deep.max():
        left, most = (scene.said(float(value), "force") for value in (force[-1], force.max()))
        yield Finding(
            "unfinished",
            pair.where,
            f"when the run ends the impact is not over: the force is {left}, {most} at its "
            "greatest; criteria and peaks are those of a part of the impact",
            "Let the run end later; --resume goes on from here",
        )


def _let_go(scene: Scene, pair: Pair, own: Columns, last: SystemState) -> Iterator[Finding]:
    """Report steps in which most points in contact leave through another wall."""
    count, deep, gone = own["n_contact"], own["max_penetration"], own["n_tunnelled"]
    lost = (gone[1:] >= 0.5 * count[:-1]) & (count[:-1] > _LAST * count.max(initial=0.0))
    lost &= deep[:-1] > _DEEP * deep.max()
    if not lost.any():
        return
    at = int(np.argmax(lost))
    yield Finding(
        "through",
        pair.where,
        f"in the one step to t = {scene.said(own['time'][at + 1], 'time')} "
        f"{int(gone[at + 1])} of {int(count[at])} points leave "
        f"{pair.part.master} from up to {scene.said(float(deep[at]))} deep: they went through it, "
        "to another wall than they came in by",
        'Take through = "hold" where they are to be pushed back; else a shorter way or a stiffer '
        "law",
    )


_CHECKS: tuple[Callable[[Scene, Pair, Columns, SystemState], Iterator[Finding]], ...] = (
    _no_contact,
    _deep,
    _sudden,
    _damped,
    _let_go,
    jumped,
    _unfinished,
)
