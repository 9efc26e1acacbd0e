"""Couple MuJoCo and contiga: joints, actuators and gravity there, contacts here."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from contiga.arrays.ordered import product
from contiga.contact.contact import Contact
from contiga.contact.state import State
from contiga.couple.carriers import (
    carriers,
    check_integrator,
    check_model,
    frame_of,
    motion_of,
    moving_bodies,
)
from contiga.couple.folder import CoupledFolder
from contiga.couple.kick import Account, Kick, Push, bad_states, first_account, gravity_of, kick
from contiga.couple.own_contacts import switch_off
from contiga.couple.parts import parts_of
from contiga.couple.result import MujocoResult, summary_of
from contiga.couple.scene import Carriers, Scene
from contiga.couple.stability import rates_of
from contiga.display import Displayed, Facts
from contiga.errors import ContigaWarning, InputError, RunError
from contiga.extras import require
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.rigid.frames import to_world
from contiga.simulation.critical import Rates
from contiga.simulation.history import BODY_COLUMNS, contact_columns, energy_columns
from contiga.simulation.model import ContactPart
from contiga.simulation.parts import by_name
from contiga.simulation.recorder import as_column
from contiga.simulation.sensor import RelativeSensor, Sensor
from contiga.simulation.sensor_criteria import sensor_summary
from contiga.simulation.signals import filtered_columns
from contiga.slaves.slave import Slave

OnStep = Callable[["MujocoCoupling"], Any]


class MujocoCoupling(Displayed):
    """A MuJoCo model whose bodies carry masters and slaves of contiga.

    A step is ``mj_step2`` with the forces of the contacts, then ``mj_step1`` and the contacts at
    the new time. What stands between is free to be set: ``data.ctrl``, ``data.qfrc_applied``.

    Parameters
    ----------
    model, data : `mujoco.MjModel` and its `mujoco.MjData`, in any units that fit together. Geoms
        of bodies that meet in a contact are switched off in `model` (see `docs/mujoco.md`)
    masters, slaves : by name, each in the axes of the frame of a MuJoCo body (xpos, xmat): that of
        its own name, or of another as ``(master, "body")``; "world" stands still. A master without
        a contact is there for sensors, fields and the report
    contacts : a list, or by name; each made with one of the masters and one of the slaves
    sensors : of points of masters, and between two masters, as a `Simulation` has them: they
        measure acceleration, velocity, displacement and spin; distance, displacement and angle
    units : names of the units of length, mass and time, which filters and criteria need
    every : steps from one measuring of contact areas to the next, and from one set of fields to
        the next; NaN in the history between
    allow_unstable : go on with steps longer than the critical one

    Raises
    ------
    InputError
        Data of another model, the integrator RK4, a body that the model does not have, slaves
        without a contact, contacts of others, both sides on one body, geoms that must
        be excluded in the model.
    MissingPackageError
        mujoco is not installed.

    Examples
    --------
    >>> import contiga as cg
    >>> import mujoco
    >>> model = mujoco.MjModel.from_xml_string('''
    ...     <mujoco><option gravity="0 0 0" timestep="0.01"/><worldbody>
    ...       <body name="ball"><freejoint/>
    ...         <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
    ...     </worldbody></mujoco>''')
    >>> data = mujoco.MjData(model)
    >>> data.qvel[2] = 1.0
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, 1.2]], area=[1.0])
    >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
    >>> coupling = MujocoCoupling(
    ...     model, data, masters={"ball": ball}, slaves={"pad": (pad, "world")}, contacts=[contact]
    ... )
    >>> result = coupling.run(end=1.0)
    >>> round(float(result.history["max_penetration"].max()), 2), round(float(data.qvel[2]), 2)
    (0.1, -1.0)
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        *,
        masters: Mapping[str, Master | tuple[Master, str]],
        slaves: Mapping[str, Slave | tuple[Slave, str]],
        contacts: Mapping[str, Contact] | Sequence[Contact],
        sensors: Sequence[Sensor | RelativeSensor] = (),
        units: tuple[str, str, str] = ("", "", ""),
        every: int = 1,
        allow_unstable: bool = False,
    ) -> None:
        require("MujocoCoupling", "mujoco")
        check_model(model, data)
        if isinstance(every, bool) or not isinstance(every, int) or every < 1:
            raise InputError("must be a whole number", where="every", found=every, allowed=">= 1")
        self.model, self.data, self.every = model, data, every
        self.allow_unstable = allow_unstable
        self._masters = carriers(model, "masters", by_name("masters", masters))
        self._slaves = carriers(model, "slaves", by_name("slaves", slaves))
        self._parts = parts_of(model, self._masters, self._slaves, contacts)
        switch_off(model, map(self._pair, self._parts))
        carrying = [*self._masters.values(), *self._slaves.values()]
        self._moving = moving_bodies(model, [carrier.body for carrier in carrying])
        self._sensors, self._units = tuple(sensors), units
        self._reset()
        self._scene = self._make_scene()  # to raise errors at once

    def _reset(self) -> None:
        self._contacts: dict[str, State] = {}
        self._last_contacts: dict[str, State] = {}
        self._wall_times: dict[str, float] = {}
        self._rows: dict[str, list[float]] = {}
        self._time = math.nan
        self._account: Account | None = None
        self._folder: CoupledFolder | None = None
        self._gravity = gravity_of(self.model)

    def _facts(self) -> Facts:
        return [
            ("masters", ", ".join(self._masters)),
            ("slaves", ", ".join(self._slaves)),
            ("contacts", ", ".join(part.name for part in self._parts)),
            ("time", float(self.data.time)),
        ]

    @property
    def contacts(self) -> dict[str, State]:
        """States of the contacts at the time of MuJoCo's data; empty before the start."""
        return dict(self._contacts)

    @property
    def critical_step(self) -> float:
        """Lower bound of the longest stable step of the present contacts; infinite without any.

        Raises
        ------
        InputError
            Nothing was started.
        """
        self._check_started()
        rates = Rates()
        for part in self._parts:
            state = self._contacts[part.name]
            point = self._reference(part, state)
            rates += rates_of(self.model, self.data, state, point, self._pair(part))
        return rates.critical

    def start(self) -> None:
        """Start the contacts at the time of MuJoCo's data, and reset the history and the energies.

        `mj_step1` is called on the data.
        """
        import mujoco

        self._reset()
        mujoco.mj_step1(self.model, self.data)
        self._scene = self._make_scene()
        self._step_contacts(None)

    def _make_scene(self) -> Scene:
        carriers = Carriers(self._masters, self._slaves, self._moving)
        return Scene((self.model, self.data), carriers, self._parts, self._sensors, self._units)

    def step(self) -> None:
        """Make one step of `model.opt.timestep`, and append the row of its start to the history.

        The coupling is started if it was not.

        Raises
        ------
        InputError
            The integrator was changed to RK4.
        RunError
            The step is longer than the critical one, or MuJoCo has found its state to be bad and
            reset it.
        """
        import mujoco

        if not self._contacts:
            self.start()
        check_integrator(self.model)
        step, critical = float(self.model.opt.timestep), self.critical_step
        if step > critical and not self.allow_unstable:
            raise RunError(
                f"t = {self._time:g}: the step of {step:.4g} is longer than the critical one of "
                f"the contacts, {critical:.4g}: their vibrations would grow without bound. Take a "
                f"timestep below {0.9 * critical:.3g}; allow_unstable lets it pass"
            )
        bad = bad_states(self.data)
        now = kick(self.model, self.data, self._pushes(), self._gravity)
        self._account = self._next_account(now)
        self._write(self.data, now, due=self._is_output_step())
        for name, value in self._row(self.data, now, self._account).items():
            self._rows.setdefault(name, []).append(value)
        mujoco.mj_step1(self.model, self.data)
        if abs(self.data.time - self._time - step) > 0.5 * step or bad_states(self.data) != bad:
            raise RunError(
                f"t = {self._time:g}: MuJoCo found its state to be bad (not finite, or too large), "
                "or it was set back. Take smaller steps, and start() after setting back"
            )
        self._step_contacts(now)

    def run(
        self,
        end: float,
        *,
        on_step: OnStep | None = None,
        out: str | Path | None = None,
        title: str = "MuJoCo and contiga",
    ) -> MujocoResult:
        """Step to `end`, from the start if nothing was started.

        Parameters
        ----------
        end : end time: the run ends at the nearest step
        on_step : called with the coupling after the start and after every step, when its `data`
            may be read and controls set
        out : folder for history, fields of every so many steps, summary and report, as a
            `Simulation` writes them: `contiga.open_result` reads it
        title : of the report

        Returns
        -------
        MujocoResult
            History, contacts and energy.

        Raises
        ------
        InputError
            The end has passed, or is no number.
        RunError
            As in `step`; nothing of the run is then left in the folder.
        OutputError
            The folder has other files, or cannot be written.

        Warns
        -----
        ContigaWarning
            The energy balance error is above 1 % of the largest energy.
        """
        if isinstance(end, bool) or not isinstance(end, int | float) or not math.isfinite(end):
            raise InputError("must be a time", where="end", found=end, allowed="a finite number")
        if end <= self.data.time:
            raise InputError(
                "lies behind",
                where="end",
                found=end,
                allowed=f"> {self.data.time:g}, where MuJoCo's data stand",
            )
        if not self._contacts:
            self.start()
            if on_step is not None:
                on_step(self)
        folder = self._folder = None if out is None else CoupledFolder(Path(out), self._scene.model)
        begin = perf_counter()
        try:
            while self.data.time < end - 0.5 * self.model.opt.timestep:
                self.step()
                if on_step is not None:
                    on_step(self)
            result = self._result(write=True)
            if folder is not None:
                summary = summary_of(result, self._scene.model, title, perf_counter() - begin)
                folder.finish(result.history, summary)
        finally:
            if folder is not None:
                folder.close()
            self._folder = None
        for text in result.warnings:
            warnings.warn(text, ContigaWarning, stacklevel=2)
        return result

    def result(self) -> MujocoResult:
        """Return the result so far, up to the time of MuJoCo's data; nothing is written.

        A copy of the data is kicked by the forces at that time: the coupling stays as it is.

        Raises
        ------
        InputError
            Nothing was started.
        """
        return self._result()

    def _result(self, *, write: bool = False) -> MujocoResult:
        """Return the result so far; with `write`, the fields of its last row are written.

        The last row is that of the present time, which the rows of the coupling do not have yet.
        """
        import mujoco

        self._check_started()
        copy = mujoco.MjData(self.model)
        mujoco.mj_copyData(copy, self.model, self.data)
        now = kick(self.model, copy, self._pushes(), self._gravity)
        account = self._next_account(now)
        self._write(copy, now, due=write)
        last = self._row(copy, now, account)
        history = {n: as_column(n, [*self._rows.get(n, []), value]) for n, value in last.items()}
        history |= filtered_columns(self._scene.model, history)
        sensors = sensor_summary(self._scene.model, history)
        return MujocoResult(history, self.contacts, account.energy(self._contacts), sensors)

    def _check_started(self) -> None:
        if not self._contacts:
            raise InputError("nothing was started", where="coupling", remedy="Call start() first")

    def _pair(self, part: ContactPart) -> tuple[int, int]:
        """Return the numbers of the bodies that carry master and slave."""
        return self._masters[part.master].body, self._slaves[part.slave].body

    def _reference(self, part: ContactPart, state: State) -> FloatArray:
        """Return the reference point (3,) of the wrench on the master, world axes."""
        return product(state.pose[:3, :3], part.contact.master.reference_point) + state.pose[:3, 3]

    def _step_contacts(self, last_kick: Kick | None) -> None:
        """Step all contacts to the positions in `data`; velocities are half a step after the kick.

        If `last_kick` is None they are started anew. The states before are kept for the history, in
        `_last_contacts`; time and gravity are set to those of `data` and the model.
        """
        self._gravity = gravity_of(self.model)
        speed = self.data.qvel.copy()
        if last_kick is not None:
            speed += 0.5 * self.model.opt.timestep * last_kick.acceleration
        dt = float(self.data.time) - self._time
        self._last_contacts = dict(self._contacts)
        for part in self._parts:
            begin = perf_counter()
            master_frame, slave_frame = (
                frame_of(self.model, self.data, b, speed) for b in self._pair(part)
            )
            points = to_world(slave_frame.pose, part.contact.slave.points)
            if last_kick is None:
                state = part.contact.start(points, master_frame.pose)
            else:
                state = part.contact.step(
                    self._contacts[part.name],
                    points,
                    master_frame.pose,
                    dt,
                    velocity=slave_frame.twist.at(slave_frame.pose[:3, 3], points),
                    twist=master_frame.twist,
                )
            self._contacts[part.name] = state
            self._wall_times[part.name] = perf_counter() - begin
        self._time = float(self.data.time)

    def _pushes(self) -> list[Push]:
        """Return the forces of the contacts on both sides, which balance to the bit.

        Contacts without a force are left out.
        """
        pushes = []
        for part in self._parts:
            state = self._contacts[part.name]
            if state.wrench.any():
                point, (first, second) = self._reference(part, state), self._pair(part)
                force, moment = state.wrench[:3], state.wrench[3:]
                pushes += [Push(first, point, force, moment), Push(second, point, -force, -moment)]
        return pushes

    def _next_account(self, now: Kick) -> Account:
        if self._account is None:
            return first_account(self._time, now, self._contacts)
        return self._account.after(self._time, now)

    def _is_output_step(self) -> bool:
        """Return whether areas are measured and fields written in this step."""
        return len(self._rows.get("time", ())) % self.every == 0

    def _write(self, data: Any, now: Kick, *, due: bool) -> None:
        """Write fields if they are due; `data` are after the kick."""
        if self._folder is not None and due:
            physics = self.model, data
            self._folder.append(self._scene.state(physics, now.speed, self._contacts, self._time))

    def _row(self, data: Any, now: Kick, account: Account) -> dict[str, float]:
        """Return a row of the history from `data` after the kick; areas are NaN if not due."""
        row = {"time": self._time}
        is_measured = self._is_output_step()
        for part in self._parts:
            prefix = "" if len(self._parts) == 1 else f"{part.name}."
            state, wall = self._contacts[part.name], self._wall_times[part.name]
            before = self._last_contacts.get(part.name)
            columns = contact_columns(state, before, wall, measured=is_measured)
            row |= {prefix + name: value for name, value in columns.items()}
        for name, body in self._moving.items():
            values = motion_of(self.model, data, body, now.speed, now.acceleration)
            row |= {f"{name}.{c}": float(v) for c, v in zip(BODY_COLUMNS, values, strict=True)}
        if self._sensors:
            physics = self.model, data
            state_now = self._scene.state(physics, now.speed, self._contacts, self._time)
            row |= self._scene.columns(physics, now, state_now)
        return row | energy_columns(account.energy(self._contacts))
