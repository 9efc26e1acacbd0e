"""Find penetrations that are too large: beyond a layer, beyond a table, or in one step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.dynamics.deforming import Deforming
from contiga.laws.normal import PenaltyLaw
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.frames import turn_to_world
from contiga.simulation.checks.finding import Finding, Quantities
from contiga.simulation.checks.layers import Layer, layers_of
from contiga.simulation.checks.scene import Pair, Scene
from contiga.slaves.cells import CORNER_EDGES

# Largest increase of penetration in a step, over a layer's thickness, and over the body's extent.
STEP_PER_LAYER = 0.5
STEP_PER_BODY = 0.25
# Largest mean penetration of a penalty contact over the size of elements, and the value after the
# remedy.
_MAX_DEPTH_PER_ELEMENT = 0.1
_REMEDY_DEPTH = 0.05
# Stiffness of matter against an even pressure, over the row sums of the skin's stiffness: these are
# four to five times modulus over height for blocks.
_SKIN_FACTOR = 0.25


def check_depth(scene: Scene) -> Iterator[Finding]:
    """Report prescribed motions that go too deep or too fast.

    Too deep is beyond a layer or table (`deeper_than`). In one step, at most `STEP_PER_LAYER` of a
    layer and `STEP_PER_BODY` of the body's longest side are allowed, at the times of the search.
    """
    for pair in scene.pairs:
        if not pair.free:
            # Penetrations beyond the range of a law.
            deepest = [float(result.penetration.max(initial=0.0)) for result in pair.dry_runs]
            k = int(np.argmax(deepest))
            peak = deepest[k], float(pair.shown_times[k])
            for layer in layers_of(pair.contact):
                yield from deeper_than(layer, pair.where, peak, scene.fmt)
            # Steps with a large increase of penetration.
            fmt = scene.fmt
            planned = pair.model.stepping.planned()
            worst, at = 0.0, 0.0
            for time, result in zip(pair.shown_times.tolist(), pair.dry_runs, strict=False):
                k = int(np.searchsorted(planned, time)) - 1
                if k >= 0 and len(result.rows):
                    # Travel of points along normals since the planned time before.
                    nodes = result.rows < len(pair.slave)
                    rows, depths = result.rows[nodes], result.penetration[nodes]
                    (before, X), (after, Y) = (
                        pair.placement(float(planned[k])),
                        pair.placement(time),
                    )
                    carried_points = pose.apply(pose.compose(Y, pose.invert(X)), before[rows])
                    normal_W = turn_to_world(Y, result.normal_B[nodes])
                    travels = ((carried_points - after[rows]) * normal_W).sum(axis=1)
                    travel = float(np.minimum(travels, depths).max(initial=0.0))
                    worst, at = max((worst, at), (travel, time))
            extent = float(np.ptp(pair.body.bounds(), axis=0).max())
            limits = [(STEP_PER_BODY * extent, f"a body of {fmt(extent)}")]
            limits += [
                (STEP_PER_LAYER * layer.thickness, f"a layer of {fmt(layer.thickness)}")
                for layer in layers_of(pair.contact)
                if layer.thickness is not None
            ]
            limit, extent_text = min(limits)
            if worst > limit:
                yield Finding(
                    "step",
                    pair.where,
                    f"in the one step to t = {fmt(at, 'time')} points go {fmt(worst)} deeper "
                    f"into {extent_text}",
                    f"Take steps {np.ceil(10.0 * worst / limit):.0f} times shorter",
                )


def deeper_than(
    layer: Layer, where: str, peak: tuple[float, float], fmt: Quantities
) -> Iterator[Finding]:
    """Report a penetration beyond a layer's thickness, or beyond the table of its law.

    `peak` is the largest penetration and its time.
    """
    penetration, time = peak
    at, thickness, end = f"at t = {fmt(time, 'time')}", layer.thickness, layer.end
    if thickness is not None and penetration > thickness:
        yield Finding(
            "thickness",
            where,
            f"the penetration reaches {fmt(penetration)} {at}, in a layer that is "
            f"{fmt(thickness)} thick",
            "Look at the motion, the thickness and the law: none of a layer is left there",
        )
    elif end is not None and penetration > end * (1.0 + 1e-9):
        if thickness is None:
            quantity, value, limit = "penetration", fmt(penetration), fmt(end)
        else:
            quantity = "strain"
            value, limit = f"{penetration / thickness:.3g}", f"{end / thickness:.3g}"
        yield Finding(
            "table",
            where,
            f"the {quantity} reaches {value} {at}, and the table of its law ends at {limit}: "
            f"beyond that it is {layer.beyond}",
            "Let the table go as far as the contact does",
        )


def deeper_than_elements(
    pair: Pair, columns: Mapping[str, FloatArray], fmt: Quantities
) -> Iterator[Finding]:
    """Report a penalty on elements whose mean penetration is above a tenth of their size.

    The penetration is that at the greatest force.
    A penalty should prevent penetration: the elements are compressed less by its penetration, and
    resist less. The mean penetration, weighted by forces, is 2 E/F with the stored energy ½ Σ k λ²
    and the force Σ k λ. (A few points of flat facets on a sharp edge are deeper at any stiffness.)
    `columns` are those of the contact. Nothing is reported for clouds of points.
    """
    motion, law = pair.model.slaves[pair.part.slave].motion, pair.contact.law
    if not isinstance(motion, Deforming) or not isinstance(law, PenaltyLaw):
        return
    if pair.slave.facets is None or pair.slave.area is None:
        return
    at = int(np.nanargmax(columns["force"]))
    force, energy, largest = (
        float(columns[k][at]) for k in ("force", "energy_stored", "max_penetration")
    )
    # Opposite forces cancel in the resultant: the mean is at most the largest.
    penetration = min(2.0 * energy / force, largest) if force > 0.0 else largest
    slave = pair.slave
    shortest = [np.zeros(0)]
    for kind, edges in CORNER_EDGES.items():
        if kind in slave.elements:
            cells = slave.elements[kind]
            ends = slave.points[cells[slave.active[cells].any(axis=1)][:, np.array(edges)]]
            lengths = np.sqrt(np.square(ends[:, :, 1] - ends[:, :, 0]).sum(axis=2))
            shortest.append(lengths.min(axis=1))
    lengths_all = np.concatenate(shortest)
    size = float(lengths_all.mean()) if len(lengths_all) else None
    if size is None or not penetration > _MAX_DEPTH_PER_ELEMENT * size:
        return
    unit_stiffness = motion.contact_stiffness(pair.slave)
    area = 1.0 if law.per_area else float(pair.slave.area[pair.slave.active].mean())
    matter = _SKIN_FACTOR * area * unit_stiffness
    # Penalty and matter are springs in series with the same total compression as now.
    stiffness = penetration / (_REMEDY_DEPTH * size) * (law.stiffness + matter) - matter
    times, stiffness = _rounded_up(stiffness / law.stiffness), _rounded_up(stiffness)
    scaled = (
        f"scale = {_rounded_up(stiffness / unit_stiffness):.3g} or "
        if law.per_area and unit_stiffness
        else ""
    )
    remedy = f"Take a penalty {times:.3g} times as stiff: {scaled}stiffness = {stiffness:.3g}"
    yield Finding(
        "deep",
        pair.where,
        f"at the greatest force the penetration is {fmt(penetration)} in the mean and "
        f"{fmt(largest)} at most, and the elements of {pair.part.slave} are {fmt(size)} large: by "
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
