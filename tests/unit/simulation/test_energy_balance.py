"""What a run says of an energy balance error."""

from __future__ import annotations

import numpy as np
from tests.scenes import box

import contiga as cg
from contiga.simulation.energy_balance import energy_warnings


def test_laws_that_jump_between_faces_are_named_as_the_cause() -> None:
    block = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    pad = cg.Slave([[0.5, 0.5, -0.1]], area=[1.0], thickness=[1.0])
    law = cg.FaceLaws(cg.StressLaw(4.0, 0.5), {1: cg.StressLaw(8.0, 0.5)})
    simulation = cg.Simulation(
        bodies={"block": (block, cg.motion.Free(block.mass_properties(1.0)))},
        slaves={"pad": pad},
        contacts=[cg.Contact(block, pad, law=law)],
        end=1.0,
        step=0.1,
    )
    none = np.zeros(3)
    history = {
        "time": np.arange(3.0),
        "energy.total": np.ones(3),
        "energy.error": np.array([0.0, 0.5, 0.5]),
        "work": np.array([0.0, 0.5, 0.5]),
        **{f"energy.{name}": none for name in ("friction", "damping", "hysteresis")},
        **{f"n_{name}": none for name in ("through", "lost", "reacquired", "found", "slid_off")},
    }
    (warning,) = energy_warnings(simulation, history)
    assert "its laws differ from face to face" in warning
