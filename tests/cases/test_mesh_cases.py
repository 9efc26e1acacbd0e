"""Real meshes against shapes and patches: tyre, soft torus, occupant."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

UNITS = '[units]\nlength = "m"\nmass = "kg"\ntime = "s"\n'
QUIET = "[output]\nevery = 10\nreport = false\n"


def test_lugged_tyre_rolls_over_a_plane(
    run_case: Callable, physics: Callable, data_dir: Path
) -> None:
    """Twelve thousand surface nodes: in contact is what lies below the road, depth its height."""
    path = data_dir / "hmmwv_lugged_tyre_c3d10.inp"
    run = run_case(f"""
title = "Tyre rolls"
{UNITS}
[time]
end = 1.0
step = 0.05
[[body]]
name = "road"
geometry = {{ shape = "plane", width = 6.0, length = 3.0, centre = [0, 0, -0.69] }}
[[slave]]
name = "tyre"
points = {{ file = "{path}" }}
[slave.motion]
kind = "combine"
motions = [
  {{ kind = "rotate", axis = "x", table = [[0, 0], [1, 40]] }},
  {{ kind = "translate", table = [[0, 0, 0, 0.04], [0.3, 0, -0.149, 0], [1, 0, -0.497, 0]] }},
]
[[contact]]
master = "road"
slave = "tyre"
law = {{ kind = "stress", elastic = 2e5, thickness = 0.05, damping = 100.0 }}
area = {{ kind = "tributary" }}
{QUIET}""")
    physics(run)
    slave = run.simulation.slaves["tyre"].slave
    for k, state in enumerate(run.states):
        height = run.points(k)[:, 2] + 0.69
        below = slave.active & (height < 0.0)
        np.testing.assert_array_equal(state.in_contact, below)
        np.testing.assert_allclose(state.penetration[below], -height[below], rtol=0, atol=1e-13)
        np.testing.assert_array_equal(state.area[below], slave.area[below])
    assert run.history["n_contact"][0] == 0
    assert run.history["n_contact"][6:].min() > 100
    # Rolling, the pressed patch changes but not its order of size; the road is pushed down.
    force = run.history["force_z"][7:]
    assert force.min() > 0.3 * force.max() > 0.0


def test_soft_torus_dropped_on_the_teapot(
    run_case: Callable, physics: Callable, data_dir: Path
) -> None:
    """Thirty-two patches with collapsed sides, hit from above on the knob, the lid and the rim."""
    table = [[0, 0, 0, 0], [10, 0, 0, -0.9], [20, 0, 0, 0]]
    run = run_case(f"""
title = "Torus on the teapot"
{UNITS}
[time]
end = 20.0
step = 0.5
[[body]]
name = "teapot"
geometry = {{ file = "{data_dir / "utah_teapot_32bezier_gismo.xml"}" }}
[[slave]]
name = "torus"
points = {{ file = "{data_dir / "torus_tet4.vtk"}", \
transform = [{{ scale = 9.0 }}, {{ translate = [0.03, 0.02, 3.45] }}] }}
motion = {{ kind = "translate", table = {table} }}
[[contact]]
master = "teapot"
slave = "torus"
law = {{ kind = "penalty", stiffness = 2.0 }}
{QUIET}""")
    physics(run, slides_off=True, corners=True)
    counts = run.history["n_contact"]
    assert counts.max() >= 10
    assert counts[[0, -1]].tolist() == [0, 0]
    # The teapot stands below: on the whole it is pushed down, the torus up.
    assert (run.history["force_z"][counts > 0] > 0.0).all()
    for state in run.states:
        on = state.in_contact
        offset = state.points_B[on] - state.foot[on]
        gap = -state.penetration[on, None] * state.normal[on]
        np.testing.assert_allclose(offset, gap, rtol=0, atol=1e-9)


def test_occupant_nodes_driven_into_a_bolster(
    run_case: Callable, physics: Callable, data_dir: Path
) -> None:
    """The dummy's segments against a cylinder across its way: counts and depths in closed form."""
    run = run_case(f"""
title = "Occupant and bolster"
{UNITS}
[time]
end = 40.0
step = 2.0
[[body]]
name = "bolster"
geometry = {{ shape = "cylinder", radius = 0.25, height = 3.0, axis = "y", \
centre = [1.25, 0.0, 0.1] }}
[[slave]]
name = "dummy"
points = {{ file = "{data_dir / "belted_dummy.k"}", unit = "m", \
parts = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] }}
motion = {{ kind = "translate", table = [[0, 0, 0, 0], [20, 0.2, 0, 0], [40, 0, 0, 0]] }}
[[contact]]
master = "bolster"
slave = "dummy"
law = {{ kind = "force", curve = [[0, 0], [0.05, 2000], [0.2, 4000]], share = "penetration" }}
{QUIET}""")
    physics(run)
    slave = run.simulation.slaves["dummy"].slave
    axis = np.array([1.25, 0.1])
    for k, state in enumerate(run.states):
        radius = np.linalg.norm(run.points(k)[:, [0, 2]] - axis, axis=1)
        inside = slave.active & (radius < 0.25)
        np.testing.assert_array_equal(state.in_contact, inside)
        np.testing.assert_allclose(state.penetration[inside], 0.25 - radius[inside], atol=1e-12)
        deepest = float(state.penetration.max())
        scale = np.interp(deepest, [0.0, 0.05, 0.2], [0.0, 2000.0, 4000.0])
        np.testing.assert_allclose(
            np.linalg.norm(state.force, axis=1).sum(), scale, rtol=1e-12, atol=1e-9
        )
    assert run.history["n_contact"].max() >= 10
    # The bolster stops the occupant.
    assert (run.history["force_x"][run.history["n_contact"] > 0] <= 0.0).all()
