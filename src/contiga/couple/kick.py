"""Make the second half of a step of MuJoCo with the forces of contacts, and compute its work.

A step of MuJoCo changes velocities by the forces at a time t, and then positions by the new
velocities: a leapfrog with velocities half a step behind. The velocity at t is the mean of those
before and after the kick, which makes kinetic energy and powers accurate to second order.
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
    """Number of the body."""
    point: FloatArray
    """(3,)."""
    force: FloatArray
    """(3,)."""
    moment: FloatArray
    """(3,) about the point."""


class Kick(NamedTuple):
    """Velocities, energies and powers at the time of a kick."""

    speed: FloatArray
    """(nv,) joint velocities at that time."""
    acceleration: FloatArray
    """(nv,) rate of change of the joint velocities in the step."""
    kinetic: float
    """Kinetic energy by the joint velocities `speed`."""
    strain: float
    """Energy stored in MuJoCo's springs."""
    mass_moment: FloatArray
    """(3,) sum of masses times positions, world axes."""
    gravity: FloatArray
    """(3,) acceleration of all masses in the kick."""
    damped: float
    """Power lost in dampers of joints and tendons and in fluid."""
    supplied: float
    """Power of actuators, applied forces and MuJoCo's own constraints."""


def kick(model: Any, data: Any, pushes: Iterable[Push], gravity: FloatArray) -> Kick:
    """Call `mj_step2` with the forces of contacts, which moves `data` to the next time, in place.

    Returned are values at the time before the move: speeds and powers at the mean of the velocities
    before and after the kick. ``data.qfrc_applied`` is as before afterwards. `gravity` (3,) is that
    of `mj_step1`, which acts in the step.
    """
    import mujoco

    before, applied = data.qvel.copy(), data.qfrc_applied.copy()
    mass_moment = (model.body_mass[:, None] * data.xipos).sum(axis=0)
    strain = _spring_energy(model, data, mass_moment)
    contact_forces = np.zeros(model.nv)
    for push in pushes:
        mujoco.mj_applyFT(
            model, data, push.force, push.moment, push.point, push.body, contact_forces
        )
    data.qfrc_applied += contact_forces
    mujoco.mj_step2(model, data)
    data.qfrc_applied[:] = applied
    speed = 0.5 * (before + data.qvel)
    momentum = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, momentum, speed)
    damping = data.qfrc_damper + data.qfrc_fluid
    # MuJoCo has no separate sum of the forces on bodies (xfrc_applied).
    supplied = data.qfrc_smooth + data.qfrc_bias - data.qfrc_spring - damping - contact_forces
    return Kick(
        speed,
        (data.qvel - before) / model.opt.timestep,
        0.5 * float((speed * momentum).sum()),
        strain,
        mass_moment,
        gravity,
        -float((damping * speed).sum()),
        float(((supplied + data.qfrc_constraint) * speed).sum()),
    )


def gravity_of(model: Any) -> FloatArray:
    """Return the acceleration of gravity (3,), which a user may change; zero if it is disabled."""
    import mujoco

    off = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    return np.zeros(3) if off else model.opt.gravity.copy()


def bad_states(data: Any) -> int:
    """Return the number of warnings so far about bad positions, velocities and accelerations."""
    import mujoco

    kinds = mujoco.mjtWarning
    bad_kinds = kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC
    return sum(int(data.warning[int(kind)].number) for kind in bad_kinds)


def _spring_energy(model: Any, data: Any, mass_moment: FloatArray) -> float:
    """Return the energy stored in springs: MuJoCo's potential energy without gravity.

    ``data.energy`` is as before afterwards.
    """
    import mujoco

    saved_energy = data.energy.copy()
    mujoco.mj_energyPos(model, data)
    potential = float(data.energy[0])
    data.energy[:] = saved_energy
    return potential + float((mass_moment * gravity_of(model)).sum())


class Account(NamedTuple):
    """Energies supplied and lost up to a time."""

    time: float
    kick: Kick
    damped: float = 0.0
    """Energy lost in MuJoCo's dampers."""
    supplied: float = 0.0
    """Work of the power `supplied` of kicks."""
    weight_work: float = 0.0
    """Work of gravity."""
    initial: float = 0.0
    """Kinetic and stored energy at the start."""

    def after(self, time: float, kick: Kick) -> Account:
        """Return the account at a later time; powers are integrated by the trapezoidal rule."""
        half, before = 0.5 * (time - self.time), self.kick
        fall, gravity = kick.mass_moment - before.mass_moment, 0.5 * (before.gravity + kick.gravity)
        return self._replace(
            time=time,
            kick=kick,
            damped=self.damped + half * (before.damped + kick.damped),
            supplied=self.supplied + half * (before.supplied + kick.supplied),
            weight_work=self.weight_work + float((fall * gravity).sum()),
        )

    def energy(self, contacts: Mapping[str, State]) -> Energy:
        """Return the energies of the coupled system: contacts, bodies, springs and work."""
        stored = contact_energy(contacts)
        return stored._replace(
            damping=stored.damping + self.damped,
            kinetic=self.kick.kinetic,
            strain=self.kick.strain,
            external=self.supplied + self.weight_work,
            initial=self.initial,
        )


def first_account(time: float, kick: Kick, contacts: Mapping[str, State]) -> Account:
    """Return the account at the start, whose total energy is the initial one."""
    account = Account(time, kick)
    return account._replace(initial=account.energy(contacts).total)
