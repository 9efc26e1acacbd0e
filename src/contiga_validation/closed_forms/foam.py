"""Foam: what of a cycle comes back."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Case, absolute, order_of, relative
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import compared
from contiga_validation.engine.arrays import FloatArray

HYSTERESIS, SHAPE = 0.2, 4.0
_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def _brick(sides: tuple[float, float, float]) -> cg.Slave:
    """One hexahedron."""
    return cg.Slave(
        np.array(_CORNERS) * np.array(sides),
        [[0, 3, 2, 1], [4, 5, 6, 7]],
        elements={"hexahedron": [list(range(8))]},
    )


def _cycled(step: float) -> dict[str, FloatArray]:
    """History of a cube of foam that is pressed by 40 % and let go."""
    motion = cg.motion.Deforming(
        material=cg.materials.Foam(
            loading=np.array([[0.0, 0.0], [0.9, 0.9]]), hysteresis=HYSTERESIS, shape=SHAPE
        ),
        density=1e-3,
        fixed={"layer": ([0, 0, -1], 0.0)},
        driven={
            "layer": ([0, 0, 1], 0.0),
            "motion": cg.motion.Translate(np.array([[0, 0, 0, 0], [1, 0, 0, -4.0], [2, 0, 0, 0]])),
        },
    )
    simulation = cg.Simulation(
        bodies={},
        slaves={"cube": (_brick((10.0, 10.0, 10.0)), motion)},
        contacts=[],
        end=2.0,
        step=step,
    )
    return dict(simulation.run().history)


def _cycle() -> Answer:
    share = HYSTERESIS + (1.0 - HYSTERESIS) / (SHAPE + 1.0)

    def returned(step: float) -> float:
        given = _cycled(step)["energy.external"]
        return float((given.max() - given[-1]) / given.max())

    history = _cycled(0.005)
    given = history["energy.external"]
    checks = (
        relative("energy given", given.max(), 0.5 * 0.4**2 * 1000.0),
        relative("share that comes back", returned(0.0025), share),
        relative("share that is lost", history["energy.hysteresis"][-1] / given.max(), 1.0 - share),
        absolute("strain energy left, by that given", history["energy.strain"][-1] / given.max(),
                 0.0, 1e-12),
    )  # fmt: skip
    time = history["time"]
    down = 0.04 * np.minimum(time, 2.0 - time) / 0.1
    loading = 0.5 * down**2 * 1000.0
    back = share * 80.0
    exact = [
        ("given, then what comes back of it", np.array([0.0, 2.0]), np.array([80.0, 80.0])),
        ("at the end", np.array([0.0, 2.0]), np.array([80.0 - back, 80.0 - back])),
    ]
    draw = compared(
        ("t", "energy"),
        [*exact, ("½ E ε² V", time[time <= 1.0], loading[time <= 1.0])],
        [("work of what drives it", time, given)],
    )
    order = order_of("share that comes back", 0.02, lambda step: abs(returned(step) - share))
    return Answer(checks, draw, order)


CASES = (
    Case(
        "matter-foam",
        GROUP,
        "A cycle of foam",
        "share that comes back: H + (1 − H)/(S + 1)",
        "One hexahedron of a linear loading curve, pressed by 40 % and let go by what drives its "
        "upper nodes.",
        _cycle,
    ),
)
