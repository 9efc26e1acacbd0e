"""Simulate bodies, slaves and contacts through time, step by step or in one run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from contiga.arrays.layout import positive, real
from contiga.contact.contact import Contact
from contiga.dynamics.gas import Chamber
from contiga.dynamics.joints import Joint
from contiga.dynamics.loads import Load
from contiga.dynamics.slip_rings import SlipRing
from contiga.dynamics.springs import Spring
from contiga.dynamics.stepping import AutoSteps, EqualSteps, GivenTimes, Stepping
from contiga.errors import InputError
from contiga.rigid.transform import vector
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.model_checks import check_model
from contiga.simulation.clock import Clock
from contiga.simulation.fingerprint import fingerprint_of
from contiga.simulation.model import AnySensor, ContactPart, Model, OutputOptions
from contiga.simulation.parts import (
    body_part,
    by_name,
    contact_parts,
    gas_parts,
    joint_parts,
    parts_of_kind,
    slave_part,
    slip_ring_parts,
    spring_parts,
)
from contiga.simulation.pyvista_scene import scene_of_state
from contiga.simulation.recorder import Progress
from contiga.simulation.result import Result
from contiga.simulation.run import RunOptions, carry_out
from contiga.simulation.sensor import RelativeSensor, Sensor
from contiga.simulation.settle import Settle
from contiga.simulation.settling import come_to_rest
from contiga.simulation.slave_sensor import NodeSensor, SectionSensor
from contiga.simulation.step import advance
from contiga.simulation.step_size import next_step
from contiga.simulation.system_state import SystemState

if TYPE_CHECKING:
    import pyvista


class Simulation(Model):
    """A simulation of bodies, slaves, contacts and loads over time.

    Parameters
    ----------
    bodies : by name; a body alone is at rest, ``(body, motion)`` moves: as prescribed, by the
        forces on it (`contiga.motion.Free`), or with another body (`contiga.motion.Attached`)
    slaves : by name; a slave alone is at rest, ``(slave, motion)`` moves: with the motion of a
        body, by ``points(t)`` and ``velocities(t)``, attached to a body, or with free nodes
    contacts : a list, or by name; each made with one of the bodies and one of the slaves
    end, step : end time and length of a step; the last one may be shorter. "auto": each step as
        long as contacts, springs and rotations allow
    start : start time
    times : (n,) the times of all steps, in place of start, end and step
    stepping : an object that gives the times, in place of all of these
    safety : largest step of "auto", as a share of the critical one
    gravity : (3,) acceleration of free bodies and nodes
    springs : `contiga.Spring`, a list or by name
    slip_rings : `contiga.belts.SlipRing`, a list or by name: between springs, by their names
    joints : `contiga.Joint`, a list or by name
    loads : a list of `contiga.Load`
    gas : `contiga.gas.Chamber`, a list or by name
    sensors : a list of `contiga.Sensor`, `RelativeSensor`, `NodeSensor` and `SectionSensor`
    allow_unstable : allow steps longer than the critical one
    settling : come to rest first: True, or options as `contiga.Settle`
    title, units : for reports; units are the names of length, mass and time
    output : files that a run writes
    case_text, base_folder : text of the case, and its folder
    findings : findings about its files from reading them; `check` reports them

    Raises
    ------
    InputError
        Times that do not increase, a motion without its velocity, contacts of other bodies or
        slaves, two parts of the same name.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, 1.2]], area=[1.0])
    >>> down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.3]])
    >>> simulation = cg.Simulation(
    ...     bodies={"ball": ball},
    ...     slaves={"pad": (pad, down)},
    ...     contacts=[cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))],
    ...     end=1.0,
    ...     step=0.25,
    ... )
    >>> state = simulation.start()
    >>> state = simulation.step(state)
    >>> state.time, state.slaves["pad"].velocities.tolist()
    (0.25, [[0.0, 0.0, -0.3]])
    >>> simulation.run().history["max_penetration"].round(12).tolist()
    [0.0, 0.0, 0.0, 0.025, 0.1]
    """

    def __init__(
        self,
        *,
        bodies: Mapping[str, Any],
        slaves: Mapping[str, Any],
        contacts: Mapping[str, Contact] | Sequence[Contact | ContactPart],
        end: float | None = None,
        step: float | str | None = None,
        start: float = 0.0,
        times: ArrayLike | None = None,
        stepping: Stepping | None = None,
        safety: float = 0.9,
        gravity: ArrayLike = (0.0, 0.0, 0.0),
        springs: Mapping[str, Spring] | Sequence[Spring] = (),
        slip_rings: Mapping[str, SlipRing] | Sequence[SlipRing] = (),
        joints: Mapping[str, Joint] | Sequence[Joint] = (),
        loads: Sequence[Load] = (),
        gas: Mapping[str, Chamber] | Sequence[Chamber] = (),
        sensors: Sequence[AnySensor] = (),
        allow_unstable: bool = False,
        settling: Settle | bool | None = None,
        title: str = "",
        units: tuple[str, str, str] = ("", "", ""),
        output: OutputOptions | None = None,
        case_text: str = "",
        base_folder: Path | None = None,
        findings: Sequence[Finding] = (),
    ) -> None:
        body_parts = {
            name: body_part(name, part) for name, part in by_name("bodies", bodies).items()
        }
        slave_parts = {
            name: slave_part(name, part) for name, part in by_name("slaves", slaves).items()
        }
        if isinstance(settling, bool):
            settling = Settle() if settling else None
        if settling is not None and not isinstance(settling, Settle):
            raise InputError(
                "must be True, or a Settle",
                where="settling",
                found=settling,
                allowed="contiga.Settle(…)",
            )
        super().__init__(
            bodies=body_parts,
            slaves=slave_parts,
            contacts=contact_parts(contacts, body_parts, slave_parts),
            stepping=_stepping(stepping, times, (start, end, step), safety),
            gravity=vector(gravity, "gravity"),
            springs=spring_parts(springs),
            slip_rings=slip_ring_parts(slip_rings),
            joints=joint_parts(joints),
            loads=parts_of_kind("loads", loads, Load),
            gas=gas_parts(gas),
            sensors=parts_of_kind(
                "sensors", sensors, Sensor, RelativeSensor, NodeSensor, SectionSensor
            ),
            allow_unstable=allow_unstable,
            settling=settling,
            title=title,
            units=units,
            output=OutputOptions() if output is None else output,
            case_text=case_text,
            base_folder=Path() if base_folder is None else base_folder,
            findings=tuple(findings),
        )

    def fingerprint(self) -> str:
        """Return the digest of all that decides the results: see `simulation.fingerprint`."""
        return fingerprint_of(self)

    def check(self) -> tuple[Finding, ...]:
        """Return doubts about the model, as `contiga check` lists them; empty if there are none.

        It checks sizes, units, sides, placement, masses and laws, and follows the motion by the
        search alone, in a few steps, as far as it is known: to the end if it is prescribed, to the
        first touch if bodies are free. `run` begins with this check and adds findings from the run
        itself; see `docs/checks.md`.
        """
        return check_model(self)

    def start(self) -> SystemState:
        """Return the state at the start, with joints closed and contacts started.

        It is not settled: see `settle`.
        """
        return advance(self, None, self.stepping.start, Clock()).state

    def settle(self) -> SystemState:
        """Return the state at the start after settling: see `contiga.Settle`.

        `run` begins with it if the simulation was made with `settling`.

        Raises
        ------
        InputError
            No slave deforms, and no body is to settle.
        RunError
            The model is not at rest after the largest number of steps.

        Examples
        --------
        A spring of rubber under its own weight

        >>> import contiga as cg
        >>> rubber = cg.materials.NeoHooke(young=3.0, poisson=0.3)
        >>> tetra = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1]]
        >>> block = cg.Slave(tetra, [[0, 1, 2]], elements={"tetra": [[0, 2, 1, 3]]})
        >>> hung = cg.motion.Deforming(material=rubber, density=0.01, fixed=[0, 1, 2])
        >>> simulation = cg.Simulation(
        ...     bodies={"ball": cg.Body([cg.shapes.sphere(radius=1.0, centre=(0, 0, -9))])},
        ...     slaves={"block": (block, hung)},
        ...     contacts=[],
        ...     gravity=[0, 0, -10.0],
        ...     end=1.0,
        ...     step="auto",
        ... )
        >>> state = simulation.settle()
        >>> state.rest.residual < 1e-3, state.slaves["block"].points[3].round(3).tolist()
        (True, [0.0, 0.0, -1.006])
        """
        return come_to_rest(self, Clock()).state

    def step(self, state: SystemState, *, dt: float | None = None) -> SystemState:
        """Return the state one step after `state`, which stays as it is.

        Parameters
        ----------
        state : state before the step
        dt : length of the step, > 0, which is taken as it is, stable or not, and also past the end;
            the next step of the simulation if omitted

        Raises
        ------
        InputError
            `state` is of another simulation, this one is at its end, or `dt` is not positive.
        RunError
            The step cannot be computed; without `dt`, also an unstable step.
        """
        names = self.mechanism.sides.keys()
        if not isinstance(state, SystemState) or state.contacts.keys() != names:
            raise InputError(
                "is not a state of this simulation",
                where="state",
                found=state,
                allowed=f"a SystemState with the contacts {', '.join(sorted(names))}",
            )
        if dt is not None:
            return advance(self, state, state.time + positive(dt, "dt"), Clock()).state
        if state.time >= self.stepping.end:
            raise InputError(
                "the simulation is at its end",
                where="state.time",
                found=state.time,
                allowed=f"< {self.stepping.end:g}",
                remedy="Give dt to go on",
            )
        return next_step(self, state, Clock()).state

    def to_pyvista(self, state: SystemState) -> pyvista.MultiBlock:
        """Return bodies and slaves of `state`, a block each, in a `pyvista.MultiBlock`.

        Points of slaves have "penetration" (n,), the deepest of all contacts, and "force" (n, 3),
        their sum, world axes.

        Raises
        ------
        MissingPackageError
            pyvista is not installed.
        """
        return scene_of_state("Simulation.to_pyvista", self, state)

    def run(
        self,
        out: str | Path | None = None,
        *,
        resume: bool = False,
        strict: bool = False,
        settle_only: bool = False,
        keep: int | None = None,
        progress: Progress | None = None,
        on_check: Callable[[tuple[Finding, ...]], Any] | None = None,
        on_step: Callable[[SystemState], Any] | None = None,
        on_slow: Callable[[str], Any] | None = None,
        clock: Clock | None = None,
    ) -> Result:
        """Run to the end, and return history, states and summary.

        Parameters
        ----------
        out : folder for history, fields, checkpoint and summary; None keeps all in memory
        resume : go on from the checkpoint in `out`; the results have the same bits as one run
        strict : refuse a model with findings (see `check`); stop at a point that is not proved
        settle_only : end at the start of the run, at rest
        keep : keep the state of every `keep`-th step in the result, the start counted; None: none
        progress : called with steps done, steps in all, points in contact
        on_check : called before the first step with the findings about the model
        on_step : called with the state of every step
        on_slow : called once with a reason and advice, if the run will take more than an hour at
            the pace of its last minute
        clock : clock with the time spent before (reading, building)

        Raises
        ------
        OutputError
            The folder cannot be written or is somebody else's.
        CheckpointError
            Nothing to resume, or the checkpoint is of another case.
        MissingPackageError
            An output folder is asked for, and h5py is not installed.
        InputError
            With `strict`, findings about the model, before its first step or after the run.
        RunError
            With `strict`, a point that is not certified.

        Notes
        -----
        When the run is stopped (an exception, Ctrl-C) a checkpoint of the last complete step
        remains; before the first one nothing remains.
        """
        options = RunOptions(
            resume=resume,
            strict=strict,
            settle_only=settle_only,
            keep=keep,
            progress=progress,
            on_check=on_check,
            on_step=on_step,
            clock=clock,
            on_slow=on_slow,
        )
        return carry_out(self, out, options)


def _stepping(
    stepping: Stepping | None,
    times: ArrayLike | None,
    interval: tuple[float, float | None, float | str | None],
    safety: float,
) -> Stepping:
    """Return the stepping from exactly one of `stepping`, `times`, or end and step.

    `interval` is (start, end, step). Raises `InputError` for any other choice, a step in words
    other than "auto", and an object without the methods of a stepping.
    """
    start, end, step = interval
    named = {"stepping": stepping, "times": times, "end": end, "step": step}
    names_given = [name for name, value in named.items() if value is not None]
    if stepping is not None and names_given == ["stepping"]:
        missing = [n for n in ("start", "end", "after", "planned") if not hasattr(stepping, n)]
        if missing:
            raise InputError(
                f"has no {missing[0]}",
                where="stepping",
                found=stepping,
                allowed="an object with start, end, after(time) and planned()",
            )
        return stepping
    if times is not None and names_given == ["times"]:
        return GivenTimes(times)
    if end is None or step is None or len(names_given) > 2:
        raise InputError(
            "give one of end+step, times, stepping",
            where="times",
            found=", ".join(names_given) or None,
        )
    if isinstance(step, str):
        if step != "auto":
            raise InputError('must be a number, or "auto"', where="step", found=step)
        return AutoSteps(_number("start", start), _number("end", end), _number("safety", safety))
    return EqualSteps(_number("start", start), _number("end", end), _number("step", step))


def _number(where: str, value: object) -> float:
    try:
        return float(real(value))
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=where, found=value) from error
