"""Find parts in a wrong unit, and points far from their body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import length
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

# Largest plausible ratio between the sizes of both sides of a contact.
_MAX_SIZE_RATIO = 200.0
# Factors by which numbers are too small if they are in a longer unit than assumed.
_UNIT_MIXUPS = {1000.0: "m where mm are thought", 304.8: "ft where mm are thought"}
# Largest and smallest plausible size, m.
_MAX_SIZE = 200.0
_MIN_SIZE = 1e-7
# Distance of a point from the box of its body, over the size, from which there is a finding.
_MAX_DISTANCE = 3.0
# Distance over the size that is refused: no lever is that long, and no run would end.
_IMPOSSIBLE_DISTANCE = 1e6


def check_sizes(scene: Scene) -> Iterator[Finding]:
    """Report sides of a contact so large, so small or so different that a unit is likely wrong.

    They may differ by a factor of `_MAX_SIZE_RATIO`; the text names the likelier mix-up of units.
    The larger side must be `_MIN_SIZE` to `_MAX_SIZE`, if the case has units.
    """
    metre = scene.fmt.si(1, 0, 0)
    for pair in scene.pairs if scene.fmt.known else []:
        name, size = max(
            (pair.part.master, pair.body.size),
            (pair.part.slave, pair.slave_size),
            key=lambda side: side[1],
        )
        if not _MIN_SIZE < size * metre < _MAX_SIZE:
            yield Finding(
                "sizes",
                pair.where,
                f"{name}, the larger side, is {scene.fmt(size)} large, {size * metre:.3g} m",
                "Look at the length unit of the case, and of the files",
            )
    for pair in scene.pairs:
        sizes = {pair.part.master: pair.body.size, pair.part.slave: pair.slave_size}
        small, large = sorted(sizes, key=lambda name: sizes[name])
        if not sizes[small] > 0.0 or sizes[large] < _MAX_SIZE_RATIO * sizes[small]:
            continue
        ratio = sizes[large] / sizes[small]
        factor = min(_UNIT_MIXUPS, key=lambda unit_ratio: abs(np.log(ratio / unit_ratio)))
        yield Finding(
            "sizes",
            pair.where,
            f"{large} is {scene.fmt(sizes[large])} large and {small} {scene.fmt(sizes[small])}, "
            f"{ratio:.3g} times less: were its numbers in {_UNIT_MIXUPS[factor]}, it would be "
            f"{scene.fmt(sizes[small] * factor)}",
            'Look at the units of both files; unit = "…" beside a file says which it is in',
        )


def check_places(scene: Scene) -> Iterator[Finding]:
    """Report loads, springs and sensors at points far from the box of their body.

    Far is more than `_MAX_DISTANCE` times the size of the body.

    Raises
    ------
    InputError
        A point farther than `_IMPOSSIBLE_DISTANCE` times the size.
    """
    model = scene.model
    for i, load in enumerate(model.loads):
        if load.at is not None:
            yield from _check_place(scene, load.body, load.at, f"load {i}")
    for name, spring in model.springs.items():
        for body, at in zip(spring.between, spring.at, strict=True):
            if body in model.bodies:
                yield from _check_place(scene, body, at, f"spring {name}")
    for sensor in model.point_sensors:
        if sensor.at is not None:
            yield from _check_place(scene, sensor.body, sensor.at, f"sensor {sensor.name}")
    for pair in model.relative:
        for body, at in zip(pair.between, [] if pair.at is None else pair.at, strict=False):
            yield from _check_place(scene, body, at, f"sensor {pair.name}")


def _check_place(scene: Scene, body: str, at: FloatArray, where: str) -> Iterator[Finding]:
    """Report one point `at` (3,), world axes at the start, as `check_places` describes."""
    model, fmt = scene.model, scene.fmt
    master = model.bodies[body].body
    X = model.origins[model.mechanism.index[body]]
    point_B = X[:3, :3].T @ (np.asarray(at) - X[:3, 3])
    low, high = master.bounds()
    distance = length(np.maximum(np.maximum(low - point_B, point_B - high), 0.0))
    if distance > _IMPOSSIBLE_DISTANCE * master.size:
        raise InputError(
            f"a point of {body} is {distance / master.size:.3g} times its size away from it",
            where=where,
            found=_point_text(at),
            allowed=f"up to {fmt(_MAX_DISTANCE * master.size)} without a warning",
            remedy="Look at the unit of its coordinates",
        )
    if distance > _MAX_DISTANCE * master.size:
        yield Finding(
            "far",
            where,
            f"its point {_point_text(at)} is {fmt(distance)} from {body}, which is "
            f"{fmt(master.size)} large",
            "Look at the unit of its coordinates, and at where the body is placed",
        )


def _point_text(at: FloatArray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in at) + "]"
