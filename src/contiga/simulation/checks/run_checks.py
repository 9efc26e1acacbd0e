"""Find contacts of a run that never began, went too deep, or have too few nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length
from contiga.laws.force import ForceLaw
from contiga.masters.nearness import nearest
from contiga.records import FloatArray
from contiga.simulation.checks.depth_checks import (
    STEP_PER_LAYER,
    deeper_than,
    deeper_than_elements,
)
from contiga.simulation.checks.facing import two_layers
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import layers_of
from contiga.simulation.checks.matter_ran import check_matter_ran
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.checks.spring_checks import check_springs_ran
from contiga.simulation.checks.turned import met_from_behind
from contiga.simulation.checks.wall_checks import force_jumps, jump_columns
from contiga.simulation.model import Model, column_prefixes
from contiga.simulation.system_state import SystemState
from contiga.slaves.sampling import more_points
from contiga.slaves.skin import facet_width

Columns = Mapping[str, FloatArray]
# Smallest number of facets across a region of contact: with fewer the force depends on the mesh.
_MIN_FACETS_ACROSS = 2.0
# Largest share of a contact's energy that damping may take.
_MAX_DAMPED_SHARE = 0.75
# Penetration of released points, as a share of the greatest, from which they tunnelled.
_RELEASE_DEPTH = 0.4
# First penetration, as a multiple of the largest later increase, from which the mesh is too coarse.
_MAX_STEPS_DEEP = 2.0
# Share of the largest number of points in contact below which their release does not matter.
_LAST_SHARE = 0.1
# Relative error of a reported distance.
_SEARCH_TOL = 1e-3
# Force at the end of an impact, as a share of the peak, at which it is over.
_END_FORCE = 0.2
# Last share of the time since first contact, and the change of penetration in it that counts.
_LATE_SHARE, _CHANGE_TOL = 0.2, 0.01
# Difference between the resultant and the curve's force without a note, relative.
_RESULTANT_TOL = 0.02


def check_run(model: Model, history: Columns, last: SystemState) -> tuple[Finding, ...]:
    """Return findings about contacts, springs and materials from the history and state of a run.

    `last` is the state at its end.
    """
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
    """Return findings about contacts in the state at the greatest force.

    A contact at nodes of fewer than `_MIN_FACETS_ACROSS` facets across is too coarse; see also
    `two_layers`.
    """
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
            n_across = length(np.ptp(contact.points_B[rows], axis=0)) / edge
            if n_across < _MIN_FACETS_ACROSS:
                text = (
                    f"at the greatest force {len(rows)} nodes are in contact, {n_across:.2g} "
                    f"facets of {scene.fmt(edge)} across: the force depends on where the nodes "
                    "happen to lie"
                )
                remedy = f"Take a finer mesh there{more_points(pair.contact.quadrature)}"
                findings.append(Finding("coarse", pair.where, text, remedy))
        findings += two_layers(pair, contact)
    return tuple(findings)


def notes_on(model: Model, history: Columns) -> list[str]:
    """Return notes on forces: a law sets the sum of magnitudes, the history has the resultant.

    A note is made if the sum is larger by more than `_RESULTANT_TOL` at the greatest force, for
    force laws without hysteresis and friction.
    """
    scene, notes = Scene(model), []
    for pair in scene.pairs:
        columns = _columns(model, pair, history)
        law, at = pair.contact.law, int(np.argmax(columns["force"]))
        if not isinstance(law, ForceLaw) or law.hysteresis is not None:
            continue
        resultant = float(law.curve(columns["max_penetration"][at]))
        printed = float(columns["force"][at])
        if (
            printed > 0.0
            and resultant > (1.0 + _RESULTANT_TOL) * printed
            and pair.contact.friction is None
        ):
            remedy = (
                "elements of a tenth of the radius that presses bring it nearer"
                if law.share == "deepest"
                else 'with share = "deepest" it is nearer to what the curve says'
            )
            notes.append(
                f"{pair.part.name}: its curve sets the sum of the nodal forces, "
                f"{scene.fmt(resultant, 'force')} at the peak; printed is their resultant, "
                f"{scene.fmt(printed, 'force')}, as they do not all point one way; {remedy}"
            )
    return notes


def _columns(model: Model, pair: Pair, history: Columns) -> dict[str, FloatArray]:
    """Return the columns of one contact that the checks need, without its prefix, and the times."""
    prefix = column_prefixes(model)[pair.part.name]
    names = (
        *("n_contact", "n_tunnelled", "max_penetration", "force"),
        *("energy_stored", "energy_damping", "energy_hysteresis", "energy_friction"),
    )
    columns = {name: history[prefix + name] for name in names}
    return {"time": history["time"]} | columns | jump_columns(history, prefix)


def _check_contact(
    scene: Scene, pair: Pair, columns: Columns, last: SystemState
) -> Iterator[Finding]:
    """Report contacts without any touch, and open faces that were met or passed from behind."""
    met = bool(columns["n_contact"].any())
    from_behind = list(met_from_behind(pair, last, met=met))
    yield from from_behind
    if met or from_behind:
        return
    rows = np.flatnonzero(pair.slave.active).astype(np.int32)
    points = last.contacts[pair.part.name].points_B
    finite = np.isfinite(points[rows]).all(axis=1)
    if not finite.any():
        return
    distance = nearest(pair.body.surface, points, rows[finite], share=_SEARCH_TOL).gap
    yield Finding(
        "apart",
        pair.where,
        f"no point of {pair.part.slave} came into contact in the whole run; at its end they are "
        f"{scene.fmt(distance)} from {pair.part.master}",
        "Look at where they are placed, at their units and at what moves them",
    )


def _check_depth(
    scene: Scene, pair: Pair, columns: Columns, last: SystemState
) -> Iterator[Finding]:
    """Report penetrations beyond a law's table or of a soft penalty, and steps that go far deeper.

    See `deeper_than_elements` for the penalty. In one step the penetration may increase by
    `STEP_PER_LAYER` of the thinnest layer; only the largest increase is reported.
    """
    at = int(np.nanargmax(columns["max_penetration"]))
    peak = float(columns["max_penetration"][at]), float(columns["time"][at])
    for layer in layers_of(pair.contact):
        yield from deeper_than(layer, pair.where, peak, scene.fmt)
    yield from deeper_than_elements(pair, columns, scene.fmt)
    increases = np.diff(columns["max_penetration"])
    layers = [layer.thickness for layer in layers_of(pair.contact) if layer.thickness]
    if len(increases) == 0 or not layers or not increases.max() > STEP_PER_LAYER * min(layers):
        return
    at = int(np.argmax(increases))
    yield Finding(
        "step",
        pair.where,
        f"in the one step to t = {scene.fmt(columns['time'][at + 1], 'time')} points went "
        f"{scene.fmt(increases[at])} deeper into a layer of {scene.fmt(min(layers))}",
        'Take shorter steps, or step = "auto" where forces move the bodies',
    )


def _check_first_depth(
    scene: Scene, pair: Pair, columns: Columns, last: SystemState
) -> Iterator[Finding]:
    """Report contacts that begin deeper than the width of a facet: the mesh let the body in.

    They must also begin deeper than `_MAX_STEPS_DEEP` times any later increase in a step.
    """
    touched = np.flatnonzero(columns["n_contact"] > 0)
    if pair.slave.facets is None or len(touched) == 0 or touched[0] == 0:
        return
    first = int(touched[0])
    depths, width = columns["max_penetration"], facet_width(pair.slave.points, pair.slave.facets)
    largest_increase = np.diff(depths[first:]).max(initial=0.0)
    if depths[first] > max(width, _MAX_STEPS_DEEP * largest_increase):
        yield Finding(
            "coarse",
            pair.where,
            f"contact begins at t = {scene.fmt(float(columns['time'][first]), 'time')} with points "
            f"{scene.fmt(float(depths[first]))} deep, and facets of {pair.part.slave} are "
            f"{scene.fmt(width)} wide: too coarse, they let {pair.part.master} in before a point "
            "of theirs was touched",
            f"Take a finer mesh there{more_points(pair.contact.quadrature)}; "
            "where one step went so far, shorter steps",
        )


def _check_damping(
    scene: Scene, pair: Pair, columns: Columns, last: SystemState
) -> Iterator[Finding]:
    """Report damping that takes more than `_MAX_DAMPED_SHARE` of the energy of a contact."""
    parts = [columns[f"energy_{name}"] for name in ("stored", "damping", "hysteresis", "friction")]
    most = float(np.max(sum(parts)))
    lost = float(columns["energy_damping"][-1])
    if most > 0.0 and lost > _MAX_DAMPED_SHARE * most:
        yield Finding(
            "damping",
            pair.where,
            f"its damping takes {100.0 * lost / most:.3g} % of the work done on it, "
            f"{scene.fmt(lost, 'energy')}: the curve hardly matters",
            "Look at the unit of the damping; damping_ratio is a share of the critical one",
        )


def _check_end(scene: Scene, pair: Pair, columns: Columns, last: SystemState) -> Iterator[Finding]:
    """Report impacts on free parts that are not over when the run ends.

    The force is still above `_END_FORCE` of its peak, also during the rebound. Parts at rest do not
    count: in the last `_LATE_SHARE` of the time since first contact the penetration changes by at
    most `_CHANGE_TOL` of its largest value. Oscillating parts do not count either: the last
    penetration is above the smallest one since the peak by more than `_CHANGE_TOL` of that.
    """
    deep, force, time = columns["max_penetration"], columns["force"], columns["time"]
    if not pair.free or force[-1] <= _END_FORCE * force.max():
        return
    first_time = float(time[np.argmax(deep > 0.0)])
    late_depths = deep[time >= time[-1] - _LATE_SHARE * (time[-1] - first_time)]
    is_single = deep[-1] <= (1.0 + _CHANGE_TOL) * deep[np.argmax(deep) :].min()
    if is_single and np.ptp(late_depths) > _CHANGE_TOL * deep.max():
        last_force, peak_force = (
            scene.fmt(float(value), "force") for value in (force[-1], force.max())
        )
        yield Finding(
            "unfinished",
            pair.where,
            f"when the run ends the impact is not over: the force is {last_force}, {peak_force} at "
            "its greatest; criteria and peaks are those of a part of the impact",
            "Let the run end later; --resume goes on from here",
        )


def _check_tunnelling(
    scene: Scene, pair: Pair, columns: Columns, last: SystemState
) -> Iterator[Finding]:
    """Report the first step in which at least half of the points leave through another wall.

    Releases of few or shallow points, at the end of a contact, do not count.
    """
    count, depth, tunnelled = (
        columns["n_contact"],
        columns["max_penetration"],
        columns["n_tunnelled"],
    )
    is_lost = (tunnelled[1:] >= 0.5 * count[:-1]) & (
        count[:-1] > _LAST_SHARE * count.max(initial=0.0)
    )
    is_lost &= depth[:-1] > _RELEASE_DEPTH * depth.max()
    if not is_lost.any():
        return
    at = int(np.argmax(is_lost))
    yield Finding(
        "through",
        pair.where,
        f"in the one step to t = {scene.fmt(columns['time'][at + 1], 'time')} "
        f"{int(tunnelled[at + 1])} of {int(count[at])} points leave "
        f"{pair.part.master} from up to {scene.fmt(float(depth[at]))} deep: they went through it, "
        "to another wall than they came in by",
        'Take through = "hold" where they are to be pushed back; else a shorter way or a stiffer '
        "law",
    )


_CHECKS: tuple[Callable[[Scene, Pair, Columns, SystemState], Iterator[Finding]], ...] = (
    _check_contact,
    _check_depth,
    _check_first_depth,
    _check_damping,
    _check_tunnelling,
    force_jumps,
    _check_end,
)
