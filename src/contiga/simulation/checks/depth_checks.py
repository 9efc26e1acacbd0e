"""Find contact that goes too deep: beyond a layer, beyond a table, too far in one step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.dynamics.deforming import Deforming
from contiga.laws.normal import PenaltyLaw
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.frames import turn_to_world
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.layers import Layer, layers_of
from contiga.simulation.checks.scene import Pair, Scene

# Of a layer's thickness, and of the largest extent of a body: what one step may go in.
STEP_OF_LAYER = 0.5
_STEP_OF_BODY = 0.25
# Of the size of elements: what a penalty that keeps surfaces apart may be penetrated by in the
# mean, and what a remedy aims at.
_DEEP_IN_ELEMENTS = 0.1
_AIM = 0.05
# Of the row sums of the skin's stiffness: what matter resists an even pressure with at most. Those
# of blocks are four to five times modulus over height.
_YIELDING = 0.25
_CELL_EDGES = {
    "tetra": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "hexahedron": (
        *((0, 1), (1, 2), (2, 3), (3, 0)),
        *((4, 5), (5, 6), (6, 7), (7, 4)),
        *((0, 4), (1, 5), (2, 6), (3, 7)),
    ),
}


def check_depth(scene: Scene) -> Iterator[Finding]:
    """Report prescribed motions that go too deep or too fast."""
    for pair in scene.pairs:
        if not pair.free:
            # Penetrations that a law does not know.
            deepest = [float(seen.penetration.max(initial=0.0)) for seen in pair.dry_runs]
            k = int(np.argmax(deepest))
            reached = deepest[k], float(pair.shown_times[k])
            for layer in layers_of(pair.contact):
                yield from deeper_than(layer, pair.where, reached, scene.said)
            # Steps in which points go in too far at once.
            said = scene.said
            planned = pair.model.stepping.planned()
            worst, at = 0.0, 0.0
            for time, seen in zip(pair.shown_times.tolist(), pair.dry_runs, strict=False):
                k = int(np.searchsorted(planned, time)) - 1
                if k >= 0 and len(seen.rows):
                    # How far points have come in since the planned time before, along normals.
                    nodes = seen.rows < len(pair.slave)
                    rows, deep = seen.rows[nodes], seen.penetration[nodes]
                    (before, X), (after, Y) = pair.standing(float(planned[k])), pair.standing(time)
                    carried = pose.apply(pose.compose(Y, pose.invert(X)), before[rows])
                    normal_W = turn_to_world(Y, seen.normal_B[nodes])
                    ways = ((carried - after[rows]) * normal_W).sum(axis=1)
                    way = float(np.minimum(ways, deep).max(initial=0.0))
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
                    f"in the one step to t = {said(at, 'time')} points go {said(worst)} deeper "
                    f"into {what}",
                    f"Take steps {np.ceil(10.0 * worst / limit):.0f} times shorter",
                )


def deeper_than(
    layer: Layer, where: str, reached: tuple[float, float], said: Said
) -> Iterator[Finding]:
    """Report a penetration beyond a layer's thickness, or beyond the table of its law.

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


def deeper_than_elements(
    pair: Pair, own: Mapping[str, FloatArray], said: Said
) -> Iterator[Finding]:
    """Report a penalty on solid elements that is penetrated by over a tenth of their size.

    It means "do not penetrate": what it gives way by the elements do not, which then are pressed
    and resist less. That is the mean penetration, each point by its force: 2 E/F of the stored
    energy ½ Σ k λ² and the force Σ k λ. (A few points of flat facets on a sharp edge go deeper,
    however stiff it is.) `own` are the columns of the contact.
    """
    motion, law = pair.model.slaves[pair.part.slave].motion, pair.contact.law
    if not isinstance(motion, Deforming) or not isinstance(law, PenaltyLaw):
        return
    if pair.slave.facets is None or pair.slave.area is None:
        return
    at = int(np.nanargmax(own["force"]))
    force, energy, most = (float(own[k][at]) for k in ("force", "energy_stored", "max_penetration"))
    # Forces that face each other are no resultant: no mean is above the largest.
    penetration = min(2.0 * energy / force, most) if force > 0.0 else most
    slave = pair.slave
    shortest = [np.zeros(0)]
    for kind, edges in _CELL_EDGES.items():
        if kind in slave.elements:
            cells = slave.elements[kind]
            ends = slave.points[cells[slave.active[cells].any(axis=1)][:, np.array(edges)]]
            lengths = np.sqrt(np.square(ends[:, :, 1] - ends[:, :, 0]).sum(axis=2))
            shortest.append(lengths.min(axis=1))
    every = np.concatenate(shortest)
    size = float(every.mean()) if len(every) else None
    if size is None or not penetration > _DEEP_IN_ELEMENTS * size:
        return
    unit = motion.contact_stiffness(pair.slave)
    area = 1.0 if law.per_area else float(pair.slave.area[pair.slave.active].mean())
    matter = _YIELDING * area * unit
    # Penalty and matter are springs in series, pressed together by as much as they are now.
    stiffness = penetration / (_AIM * size) * (law.stiffness + matter) - matter
    times, stiffness = _rounded_up(stiffness / law.stiffness), _rounded_up(stiffness)
    scaled = f"scale = {_rounded_up(stiffness / unit):.3g} or " if law.per_area and unit else ""
    remedy = f"Take a penalty {times:.3g} times as stiff: {scaled}stiffness = {stiffness:.3g}"
    yield Finding(
        "deep",
        pair.where,
        f"at the greatest force the penetration is {said(penetration)} in the mean and "
        f"{said(most)} at most, and the elements of {pair.part.slave} are {said(size)} large: by "
        "so much less they are pressed, and the force is too small",
        remedy,
    )


def _rounded_up(number: float) -> float:
    """Round up to two digits.

    >>> _rounded_up(0.01234), _rounded_up(20.0)
    (0.013, 20.0)
    """
    unit = 10.0 ** (np.floor(np.log10(number)) - 1.0)
    return float(f"{np.ceil(number / unit * (1.0 - 1e-9)) * unit:.2g}")
