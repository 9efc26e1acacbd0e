"""Checks of how deep contact goes: beyond a layer, beyond a table, too far in one step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.contact.dry_run import DryRun
from contiga.rigid import pose
from contiga.rigid.frames import turn_to_world
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.layers import Layer, layers_of
from contiga.simulation.checks.scene import Pair, Scene

# Of a layer's thickness, and of the largest extent of a body: what one step may go in.
STEP_OF_LAYER = 0.5
_STEP_OF_BODY = 0.25


def check_depth(scene: Scene) -> Iterator[Finding]:
    """Where motions that nothing stops go too deep or too fast."""
    for pair in scene.pairs:
        if not pair.free:
            yield from _too_deep(pair, scene.said)
            yield from _too_fast(pair, scene.said)


def _too_deep(pair: Pair, said: Said) -> Iterator[Finding]:
    """Penetrations that a law does not know."""
    deepest = [float(seen.penetration.max(initial=0.0)) for seen in pair.dry_runs]
    k = int(np.argmax(deepest))
    for layer in layers_of(pair.contact):
        yield from deeper_than(layer, pair.where, (deepest[k], float(pair.shown_times[k])), said)


def deeper_than(
    layer: Layer, where: str, reached: tuple[float, float], said: Said
) -> Iterator[Finding]:
    """A penetration beyond a layer's thickness, or beyond the table of its law.

    `reached` is how deep it goes, and when.
    """
    penetration, time = reached
    at, thickness, end = f"at t = {said(time, 'time')}", layer.thickness, layer.end
    if thickness is not None and penetration > thickness:
        yield Finding(
            "thickness",
            where,
            f"the penetration reaches {said(penetration)} {at}, in a layer that is "
            f"{said(thickness)} thick",
            "Look at the motion, the thickness and the law: none of a layer is left there",
        )
    elif end is not None and penetration > end * (1.0 + 1e-9):
        if thickness is None:
            what, number, last = "penetration", said(penetration), said(end)
        else:
            what = "strain"
            number, last = f"{penetration / thickness:.3g}", f"{end / thickness:.3g}"
        yield Finding(
            "table",
            where,
            f"the {what} reaches {number} {at}, and the table of its law ends at {last}: beyond "
            f"that it is {layer.beyond}",
            "Let the table go as far as the contact does",
        )


def _too_fast(pair: Pair, said: Said) -> Iterator[Finding]:
    """Steps in which points go in too far at once."""
    planned = pair.model.stepping.planned()
    worst, at = 0.0, 0.0
    for time, seen in zip(pair.shown_times.tolist(), pair.dry_runs, strict=False):
        k = int(np.searchsorted(planned, time)) - 1
        if k >= 0 and len(seen.rows):
            way = _way_in(pair, (float(planned[k]), time), seen)
            worst, at = max((worst, at), (way, time))
    extent = float(np.ptp(pair.body.bounds(), axis=0).max())
    limits = [(_STEP_OF_BODY * extent, f"a body of {said(extent)}")]
    limits += [
        (STEP_OF_LAYER * layer.thickness, f"a layer of {said(layer.thickness)}")
        for layer in layers_of(pair.contact)
        if layer.thickness is not None
    ]
    limit, what = min(limits)
    if worst > limit:
        yield Finding(
            "step",
            pair.where,
            f"in the one step to t = {said(at, 'time')} points go {said(worst)} deeper into {what}",
            f"Take steps {np.ceil(10.0 * worst / limit):.0f} times shorter",
        )


def _way_in(pair: Pair, times: tuple[float, float], seen: DryRun) -> float:
    """The greatest way in that points have come between two times, along their normals."""
    nodes = seen.rows < len(pair.slave)
    rows, deep = seen.rows[nodes], seen.penetration[nodes]
    (before, X), (after, Y) = pair.standing(times[0]), pair.standing(times[1])
    carried = pose.apply(pose.compose(Y, pose.invert(X)), before[rows])
    ways = ((carried - after[rows]) * turn_to_world(Y, seen.normal_B[nodes])).sum(axis=1)
    return float(np.minimum(ways, deep).max(initial=0.0))
