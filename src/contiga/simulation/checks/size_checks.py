"""Find parts in the wrong unit, and places far from the body that they are on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import length
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

# Sizes of the sides of one contact that are odd, one over the other.
_ODD_RATIO = 200.0
# What numbers are too small by where they are in a longer unit than is thought.
_LONGER = {1000.0: "m where mm are thought", 304.8: "ft where mm are thought"}
# m: what nobody strikes with, or looks at by contact.
_LARGEST = 200.0
_SMALLEST = 1e-7
# Sizes of a body that a place on it may be away from its box.
_FAR = 3.0
# Beyond so many a place has lost what its body is about: no lever is meant, and no run ends.
_LOST = 1e6


def check_sizes(scene: Scene) -> Iterator[Finding]:
    """Report sides of a contact so different in size that a unit is most likely wrong."""
    metre = scene.said.si(1, 0, 0)
    for pair in scene.pairs if scene.said.known else []:
        name, size = max(
            (pair.part.master, pair.body.size),
            (pair.part.slave, pair.slave_size),
            key=lambda side: side[1],
        )
        if not _SMALLEST < size * metre < _LARGEST:
            yield Finding(
                "sizes",
                pair.where,
                f"{name}, the larger side, is {scene.said(size)} large, {size * metre:.3g} m",
                "Look at the length unit of the case, and of the files",
            )
    for pair in scene.pairs:
        sizes = {pair.part.master: pair.body.size, pair.part.slave: pair.slave_size}
        small, large = sorted(sizes, key=lambda name: sizes[name])
        if not sizes[small] > 0.0 or sizes[large] < _ODD_RATIO * sizes[small]:
            continue
        ratio = sizes[large] / sizes[small]
        factor = min(_LONGER, key=lambda one: abs(np.log(ratio / one)))
        yield Finding(
            "sizes",
            pair.where,
            f"{large} is {scene.said(sizes[large])} large and {small} {scene.said(sizes[small])}, "
            f"{ratio:.3g} times less: were its numbers in {_LONGER[factor]}, it would be "
            f"{scene.said(sizes[small] * factor)}",
            'Look at the units of both files; unit = "…" beside a file says which it is in',
        )


def check_places(scene: Scene) -> Iterator[Finding]:
    """Report loads, springs and sensors at points far from the body that they are on.

    Raises
    ------
    InputError
        So far that nothing can be made of it.
    """
    model = scene.model
    for i, load in enumerate(model.loads):
        if load.at is not None:
            yield from _far(scene, load.body, load.at, f"load {i}")
    for name, spring in model.springs.items():
        for body, at in zip(spring.between, spring.at, strict=True):
            if body in model.bodies:
                yield from _far(scene, body, at, f"spring {name}")
    for sensor in model.point_sensors:
        if sensor.at is not None:
            yield from _far(scene, sensor.body, sensor.at, f"sensor {sensor.name}")
    for one in model.relative:
        for body, at in zip(one.between, [] if one.at is None else one.at, strict=False):
            yield from _far(scene, body, at, f"sensor {one.name}")


def _far(scene: Scene, body: str, at: FloatArray, where: str) -> Iterator[Finding]:
    model, said = scene.model, scene.said
    master = model.bodies[body].body
    X = model.origins[model.mechanism.index[body]]
    local = X[:3, :3].T @ (np.asarray(at) - X[:3, 3])
    low, high = master.bounds()
    away = length(np.maximum(np.maximum(low - local, local - high), 0.0))
    if away > _LOST * master.size:
        raise InputError(
            f"a point of {body} is {away / master.size:.3g} times its size away from it",
            where=where,
            found=_point(at),
            allowed=f"up to {said(_FAR * master.size)} without a warning",
            remedy="Look at the unit of its coordinates",
        )
    if away > _FAR * master.size:
        yield Finding(
            "far",
            where,
            f"its point {_point(at)} is {said(away)} from {body}, which is {said(master.size)} "
            "large",
            "Look at the unit of its coordinates, and at where the body is placed",
        )


def _point(at: FloatArray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in at) + "]"
