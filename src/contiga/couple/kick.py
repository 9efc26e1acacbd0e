"""The second half of a step of MuJoCo, with the forces of contacts, and what work is done in it.

MuJoCo's steps kick velocities by the forces at a time t and then move places by the new ones:
a leapfrog whose velocities stand half a step behind. At t itself the speed is the mean of the two
on both sides of the kick, and with it kinetic energy and powers are of second order in the step.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.records import FloatArray
from contiga.simulation.step import contact_energy
from contiga.simulation.system_state import Energy


class Push(NamedTuple):
    """Force and moment at a point of a body, world axes."""

    body: int
    point: FloatArray
    force: FloatArray
    moment: FloatArray


class Kick(NamedTuple):
    """The effect of the forces at one time."""

    speed: FloatArray
    """(nv,) velocities of the joints at that time."""
    acceleration: FloatArray
    """(nv,) the change of the velocities over the step."""
    kinetic: float
    strain: float
    """Stored in MuJoCo's springs."""
    add_gravity: FloatArray
    """(3,) masses by their places, world axes."""
    gravity: FloatArray
    """(3,) acceleration of all masses in the kick."""
    damped: float
    """Power taken by dampers of joints and tendons and by fluid."""
    supplied: float
    """Power of actuators, applied forces and MuJoCo's own constraints."""


def kick(model: Any, data: Any, pushes: Iterable[Push], gravity: FloatArray) -> Kick:
    """Carry out `mj_step2` with the forces of contacts; `data` are at the next time then.

    Forces that a user applies stay as they are. `gravity` (3,) is that of `mj_step1`, which is the
    one that acts.
    """
    import mujoco

    before, applied = data.qvel.copy(), data.qfrc_applied.copy()
    add_gravity = (model.body_mass[:, None] * data.xipos).sum(axis=0)
    strain = _strain(model, data, add_gravity)
    contact = np.zeros(model.nv)
    for push in pushes:
        mujoco.mj_applyFT(model, data, push.force, push.moment, push.point, push.body, contact)
    data.qfrc_applied += contact
    mujoco.mj_step2(model, data)
    data.qfrc_applied[:] = applied
    speed = 0.5 * (before + data.qvel)
    momentum = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, momentum, speed)
    damping = data.qfrc_damper + data.qfrc_fluid
    # MuJoCo keeps no sum of the forces on bodies (xfrc_applied) on its own.
    others = data.qfrc_smooth + data.qfrc_bias - data.qfrc_spring - damping - contact
    return Kick(
        speed,
        (data.qvel - before) / model.opt.timestep,
        0.5 * float((speed * momentum).sum()),
        strain,
        add_gravity,
        gravity,
        -float((damping * speed).sum()),
        float(((others + data.qfrc_constraint) * speed).sum()),
    )


def gravity_of(model: Any) -> FloatArray:
    """Return (3,) acceleration of all masses, which a user may change."""
    import mujoco

    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    return np.zeros(3) if off else model.opt.gravity.copy()


def bad_states(data: Any) -> int:
    """Return how often MuJoCo has found positions, velocities or accelerations to be bad."""
    import mujoco

    kinds = mujoco.mjtWarning
    which = kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC
    return sum(int(data.warning[int(kind)].number) for kind in which)


def _strain(model: Any, data: Any, add_gravity: FloatArray) -> float:
    """Stored in springs: what MuJoCo counts without its weights."""
    import mujoco

    kept = data.energy.copy()
    mujoco.mj_energyPos(model, data)
    whole = float(data.energy[0])
    data.energy[:] = kept
    return whole + float((add_gravity * gravity_of(model)).sum())


class Account(NamedTuple):
    """The energy that has come in and was lost up to a time."""

    time: float
    kick: Kick
    damped: float = 0.0
    """Taken by MuJoCo's dampers."""
    supplied: float = 0.0
    """Work of what the kick's `supplied` is the power of."""
    fallen: float = 0.0
    """Work of the weights."""
    initial: float = 0.0
    """Kinetic and stored energy at the start."""

    def after(self, time: float, kick: Kick) -> Account:
        """The account at a later time: powers by the trapezoidal rule."""
        half, before = 0.5 * (time - self.time), self.kick
        way, gravity = kick.add_gravity - before.add_gravity, 0.5 * (before.gravity + kick.gravity)
        return self._replace(
            time=time,
            kick=kick,
            damped=self.damped + half * (before.damped + kick.damped),
            supplied=self.supplied + half * (before.supplied + kick.supplied),
            fallen=self.fallen + float((way * gravity).sum()),
        )

    def energy(self, contacts: Mapping[str, State]) -> Energy:
        """The ledger."""
        stored = contact_energy(contacts)
        return stored._replace(
            damping=stored.damping + self.damped,
            kinetic=self.kick.kinetic,
            strain=self.kick.strain,
            external=self.supplied + self.fallen,
            initial=self.initial,
        )


def opened(time: float, kick: Kick, contacts: Mapping[str, State]) -> Account:
    """The account at the start."""
    account = Account(time, kick)
    return account._replace(initial=account.energy(contacts).total)
