"""Write and read the checkpoint of a run: one HDF5 file to go on from with the same bits."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.belt_devices import DeviceState
from contiga.dynamics.gas import GasState
from contiga.dynamics.linkage import JointStates
from contiga.dynamics.nodes import ElementState, SlaveState
from contiga.dynamics.slip_rings import SlipRingState
from contiga.dynamics.springs import SpringState
from contiga.errors import CheckpointError, InputError
from contiga.io.out.hdf5 import is_sealed, whole_file
from contiga.io.out.stored import SUMMARY_KEY, unsealed_message
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.fingerprint import fingerprint_of
from contiga.simulation.gas import ChamberState
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.settle import Rest
from contiga.simulation.system_state import BodyStates, Energy, SystemState
from contiga.simulation.trigger import TriggerState

FORMAT = 18
_STATE_NUMBERS = ("step", "peak_energy", "shaking", "leak", "place_error", "speed_error")
"""Numbers of a state."""


class Peak(NamedTuple):
    """The greatest force so far, of all contacts together."""

    force: float = 0.0
    """Sum of the magnitudes of all contacts' forces."""
    row: int = -1
    """Row of the history; −1 before there is any force."""
    state: SystemState | None = None
    """State that is still to be written; None once written."""

    def after(self, state: SystemState, force: float, row: int, *, written: bool) -> Peak:
        """Return the peak after one more step: unchanged unless `force` is greater than before.

        The state is not kept if `written`: its fields are written anyway.
        """
        if not force > self.force:  # nor where it is NaN
            return self
        return Peak(force, row, None if written else state)


class Onward(NamedTuple):
    """Values for a run that goes on beyond its end, whose last step is then not the last."""

    written: int
    """Steps in the fields file without the last, which is written only because it is the last."""
    peak: Peak
    """The greatest force so far, whose state may still have to be written."""
    unmeasured: tuple[int, ...]
    """Rows of the history whose areas were measured only because their fields were written."""


class Checkpoint(NamedTuple):
    """A run after `done` of its steps."""

    fingerprint: str
    """Digest of the case and of everything read for it."""
    end: float
    """End of the run, time."""
    ends: tuple[float, ...]
    """Earlier ends of the run whose steps differ from those of a single run."""
    done: int
    """Steps done, the start counted."""
    written: int
    """Steps in the fields file."""
    state: SystemState
    """State after the last of them."""
    history: dict[str, FloatArray]
    """Columns so far."""
    peak: Peak
    """The greatest force so far."""
    crest: tuple[Finding, ...]
    """Findings about the model from that step."""
    onward: Onward | None = None
    """None if there is no difference."""


def write_checkpoint(
    path: Path, checkpoint: Checkpoint, summary: dict[str, Any], before: Path | None = None
) -> None:
    """Write `checkpoint` to `path` atomically; an older file is moved to `before`, if given.

    `summary` is the summary of the run so far.
    """
    with whole_file(path, sealed=True, before=before) as file:
        file.attrs["format"] = FORMAT
        file.attrs["fingerprint"] = checkpoint.fingerprint
        file.attrs["end"] = checkpoint.end
        file.attrs["ends"] = np.array(checkpoint.ends, np.float64)
        file.attrs["done"] = checkpoint.done
        file.attrs["written"] = checkpoint.written
        file[SUMMARY_KEY] = json.dumps(summary)
        _write_state(file, checkpoint.state)
        # Keep the order of columns: a resumed run writes the same file.
        history = file.create_group("history", track_order=True)
        for name, column in checkpoint.history.items():
            history.create_dataset(name, data=column)
        file.attrs["crest"] = json.dumps(checkpoint.crest)
        _write_peak(file.create_group("peak"), checkpoint.peak)
        if checkpoint.onward is not None:
            onward = file.create_group("onward")
            onward.attrs["written"] = checkpoint.onward.written
            onward.attrs["unmeasured"] = np.array(checkpoint.onward.unmeasured, np.int64)
            _write_peak(onward.create_group("peak"), checkpoint.onward.peak)


def _write_peak(group: Any, peak: Peak) -> None:
    group.attrs["force"], group.attrs["row"] = peak.force, peak.row
    if peak.state is not None:
        _write_state(group.create_group("state"), peak.state)


def _write_state(file: Any, state: SystemState) -> None:
    """Write a group for each body, slave, contact, spring and gas, data sets for the rest.

    Names keep their order, which a resumed run needs.
    """
    file.attrs["time"] = state.time
    for kind in ("bodies", "slaves", "contacts", "springs", "gas", "slip_rings", "triggers"):
        file.create_group(kind, track_order=True)
    for name, body in state.bodies.items():
        group = file.create_group(f"bodies/{name}")
        group["pose"] = body.pose
        group["twist"] = np.concatenate(body.twist)
    for name, slave in state.slaves.items():
        group = file.create_group(f"slaves/{name}")
        group["points"], group["velocities"] = slave
        for key, array in slave.matter.items():
            group[f"matter/{key}"] = array
    for name, contact in state.contacts.items():
        group = file.create_group(f"contacts/{name}")
        for key, array in contact.arrays.items():
            group[key] = array
    for name, spring in state.springs.items():
        group = file.create_group(f"springs/{name}")
        for key, value in spring._asdict().items():
            group[key] = np.array(value)
    for kind, states in (("slip_rings", state.slip_rings), ("triggers", state.triggers)):
        for name, numbers in states.items():
            file[f"{kind}/{name}"] = np.array(numbers)
    for name, chamber in state.gas.items():
        group = file.create_group(f"gas/{name}")
        group["force"] = chamber.force
        for key, value in chamber.gas._asdict().items():
            group[key] = value
    if state.joints is not None:
        for key, array in state.joints._asdict().items():
            file[f"joints/{key}"] = array
    file["energy"] = np.array(state.energy)
    if state.rest is not None:
        file["rest"] = np.array(state.rest, np.float64)
    for name in _STATE_NUMBERS:
        file[name] = getattr(state, name)
    file["rigid"], file["wrenches"] = state.rigid, state.wrenches


def _read_state(file: Any, contacts: Iterable[ContactPart]) -> SystemState:
    """Return the state that `_write_state` wrote; states of contacts refer to `contacts`."""

    def arrays(group: Any, *names: str) -> list[FloatArray]:
        return [np.asarray(group[name]) for name in names]

    bodies = [arrays(group, "pose", "twist") for group in file["bodies"].values()]
    poses = np.array([pose for pose, _ in bodies]).reshape(-1, 4, 4)
    twists = np.array([twist for _, twist in bodies]).reshape(-1, 6)
    slaves: dict[str, SlaveState] = {}
    for name, group in file["slaves"].items():
        both = np.asarray(group["points"]), np.asarray(group["velocities"])
        slaves[name] = SlaveState(*both)
        if "matter" in group:
            inside = {key: np.asarray(array) for key, array in group["matter"].items()}
            slaves[name] = ElementState.of(*both, inside)
    springs = {}
    for name, group in file["springs"].items():
        columns = {key: np.asarray(group[key]) for key in SpringState._fields}
        devices = DeviceState(*map(float, columns.pop("devices")))
        numbers = {key: float(value) for key, value in columns.items() if key != "ends"}
        springs[name] = SpringState(ends=columns["ends"], devices=devices, **numbers)
    gas = {}
    for name, group in file["gas"].items():
        contents: dict[str, Any] = {}
        for key in GasState._fields:
            value = np.asarray(group[key])
            contents[key] = float(value) if value.ndim == 0 else value
        gas[name] = ChamberState(GasState(**contents), np.asarray(group["force"]))
    joints = None
    if "joints" in file:
        joints = JointStates(
            **{key: np.asarray(file["joints"][key]) for key in JointStates._fields}
        )
    rest = None
    if "rest" in file:
        steps, residual = np.asarray(file["rest"]).tolist()
        rest = Rest(int(steps), residual)
    return SystemState(
        time=float(file.attrs["time"]),
        bodies=BodyStates({name: i for i, name in enumerate(file["bodies"])}, poses, twists),
        slaves=slaves,
        contacts={
            part.name: State(
                **{key: np.asarray(array) for key, array in file["contacts"][part.name].items()},
                of=part.contact,
            )
            for part in contacts
        },
        energy=Energy(*map(float, file["energy"])),
        rigid=np.asarray(file["rigid"]),
        wrenches=np.asarray(file["wrenches"]),
        springs=springs,
        gas=gas,
        joints=joints,
        slip_rings={
            name: SlipRingState(*map(float, ring)) for name, ring in file["slip_rings"].items()
        },
        triggers={
            name: TriggerState(*map(float, trigger)) for name, trigger in file["triggers"].items()
        },
        rest=rest,
        **{name: float(file[name][()]) for name in _STATE_NUMBERS},
    )


def read_checkpoint(path: Path, model: Model) -> Checkpoint:
    """Return the checkpoint in `path`, if `model` can go on from it.

    The model may end later than the run of the checkpoint.

    Raises
    ------
    CheckpointError
        The checkpoint is missing or damaged, of another format, of another case, or of a run with
        a later end.
    """
    if not path.is_file():
        raise CheckpointError(
            "there is no checkpoint to go on from",
            where=str(path),
            remedy="Run the case without --resume",
        )
    if not is_sealed(path):
        raise CheckpointError(**unsealed_message(path), where=str(path))
    try:
        import h5py

        with h5py.File(path, "r") as file:
            if int(file.attrs["format"]) != FORMAT:
                raise ValueError("format")
            onward = None
            if "onward" in file:
                group = file["onward"]
                rows = tuple(map(int, group.attrs["unmeasured"]))
                peak = _read_peak(group["peak"], model.contacts)
                onward = Onward(int(group.attrs["written"]), peak, rows)
            checkpoint = Checkpoint(
                str(file.attrs["fingerprint"]),
                float(file.attrs["end"]),
                tuple(map(float, file.attrs["ends"])),
                int(file.attrs["done"]),
                int(file.attrs["written"]),
                _read_state(file, model.contacts),
                {name: np.asarray(column) for name, column in file["history"].items()},
                _read_peak(file["peak"], model.contacts),
                tuple(Finding(*texts) for texts in json.loads(file.attrs["crest"])),
                onward,
            )
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise CheckpointError(
            "the checkpoint cannot be read",
            where=str(path),
            remedy="Run the case again without --resume",
        ) from error
    try:  # compare the steps so far: the model may end later
        is_same_case = checkpoint.fingerprint == fingerprint_of(model, checkpoint.end)
    except InputError:  # its steps do not fit into the time until that end
        is_same_case = False
    if not is_same_case:
        raise CheckpointError(
            "the checkpoint is of another case, or its files have changed since",
            where=str(path),
            remedy="Go on with the case it was made from, or run this one without --resume",
        )
    if checkpoint.end > model.stepping.end:
        raise CheckpointError(
            f"the checkpoint is of a run to t = {checkpoint.end:g}, and the case ends before",
            where=str(path),
            found=model.stepping.end,
            allowed=f"an end of {checkpoint.end:g} or later",
            remedy="Set such an end, or run the case without --resume",
        )
    return checkpoint


def _read_peak(group: Any, contacts: Iterable[ContactPart]) -> Peak:
    state = _read_state(group["state"], contacts) if "state" in group else None
    return Peak(float(group.attrs["force"]), int(group.attrs["row"]), state)
