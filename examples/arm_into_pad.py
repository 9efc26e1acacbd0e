"""A jointed arm swings its hand into a foam pad: joints by MuJoCo, contact by contiga.

python arm_into_pad.py

The hand is an exact ellipsoid (NURBS), the pad a fine sheet whose law loads and unloads by curves
of their own, with friction. m, kg, s: forces are in N, stresses in Pa, energies in J.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

import contiga as cg
from contiga.couple import MujocoCoupling, MujocoResult

ARM = """
<mujoco model="arm">
  <option timestep="{step!r}" integrator="implicitfast"/>
  <worldbody>
    <body name="upper arm" pos="0 0 0.5">
      <joint name="shoulder" axis="0 1 0" damping="0.3"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.04" mass="2.1"/>
      <body name="forearm" pos="0.3 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.2" stiffness="4" springref="20"/>
        <geom type="capsule" fromto="0 0 0 0.26 0 0" size="0.03" mass="1.3"/>
        <body name="hand" pos="0.26 0 0">
          <joint name="wrist" axis="0 1 0" damping="0.05" stiffness="6"/>
          <geom type="ellipsoid" size="0.075 0.055 0.05" pos="0.08 0 0" mass="0.5"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
JOINTS = ("shoulder", "elbow", "wrist")
SPEED = 4.0
"""Of the shoulder at the start, radians a second."""
TOP, THICK = 0.24, 0.08
LOADING = [[0.0, 0.0], [0.1, 5.0e4], [0.5, 1.2e5], [0.8, 4.0e5]]
UNLOADING = [[0.0, 0.0], [0.3, 1.0e4], [0.5, 4.0e4], [0.8, 2.0e5]]


class Swing(NamedTuple):
    """What a swing gives."""

    result: MujocoResult
    angles: np.ndarray
    """(n, 3) of the joints at each time, degrees."""

    @property
    def error(self) -> float:
        """Largest energy balance error over the energy lost in the pad."""
        history = self.result.history
        lost = history["energy.hysteresis"][-1] + history["energy.friction"][-1]
        return float(np.abs(history["energy.error"]).max() / lost)


def pad(mesh: float, width: float = 0.36, length: float = 0.2) -> cg.Slave:
    """A plane pad of quadrilaterals with sides of about `mesh`, under where the hand comes down."""
    sheet = cg.shapes.plane(width=width, length=length, centre=(0.6, 0.0, TOP))
    n, m = round(width / mesh) + 1, round(length / mesh) + 1
    row = np.arange(n * m).reshape(n, m)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    return cg.Slave(cg.clouds.sample(sheet, n, m), quads.reshape(-1, 4), name="pad")


def swing(mesh: float = 0.008, step: float = 2e-4, end: float = 0.12) -> Swing:
    """Let the arm swing down from the horizontal."""
    model = mujoco.MjModel.from_xml_string(ARM.format(step=step))
    data = mujoco.MjData(model)
    data.joint("shoulder").qvel = SPEED
    shape = cg.shapes.ellipsoid(axes=(0.075, 0.055, 0.05), centre=(0.08, 0.0, 0.0))
    hand = cg.Body([shape], name="hand")
    foam = cg.StressLaw(LOADING, THICK, unloading=UNLOADING, hysteresis_slope=4.0e6)
    sheet = pad(mesh)
    coupling = MujocoCoupling(
        model,
        data,
        masters={"hand": hand},
        slaves={"pad": (sheet, "world")},
        contacts=[cg.Contact(hand, sheet, law=foam, friction=cg.Coulomb(0.4))],
        every=10,
    )
    angles: list[list[float]] = []

    def keep(one: MujocoCoupling) -> None:
        angles.append([math.degrees(one.data.joint(name).qpos[0]) for name in JOINTS])

    return Swing(coupling.run(end, on_step=keep), np.array(angles))


def main() -> None:
    """Swing with two steps, and print what happens."""
    for step in (4e-4, 2e-4):
        course = swing(step=step)
        history, peak = course.result.history, int(np.argmax(course.result.history["force"]))
        bent = ", ".join(
            f"{name} {angle:.1f}°" for name, angle in zip(JOINTS, course.angles[peak], strict=True)
        )
        print(
            f"step {1000 * step:g} ms: {history['force'][peak]:.0f} N at "
            f"{1000 * history['time'][peak]:.1f} ms, {1000 * history['max_penetration'][peak]:.1f} "
            f"mm deep, at {bent}; lost in the pad {history['energy.hysteresis'][-1]:.2f} J, by "
            f"friction {history['energy.friction'][-1]:.2f} J; energy error "
            f"{100 * course.error:.2f} %"
        )


if __name__ == "__main__":
    main()
