"""Where a run stands, in one HDF5 file: enough to go on with the same bits."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.springs import SpringState
from contiga.errors import CheckpointError
from contiga.io.out.files import atomic_write
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.model import ContactPart
from contiga.simulation.peak import Peak
from contiga.simulation.system_state import BodyStates, Energy, SlaveState, SystemState

FORMAT = 7


class Checkpoint(NamedTuple):
    """A run after `done` of its steps."""

    fingerprint: str
    """Of the case and everything read for it."""
    done: int
    """Steps carried out, the start counted."""
    written: int
    """Steps in the fields file."""
    state: SystemState
    """After the last of them."""
    history: dict[str, FloatArray]
    """Columns so far."""
    peak: Peak
    """The greatest force so far."""
    crest: tuple[Finding, ...]
    """What the step of that showed of the model."""


def write_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write the file whole, in place of an older one."""
    import h5py

    with atomic_write(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs["format"] = FORMAT
        file.attrs["fingerprint"] = checkpoint.fingerprint
        file.attrs["done"] = checkpoint.done
        file.attrs["written"] = checkpoint.written
        _write_state(file, checkpoint.state)
        # Columns stay in their order: a resumed run writes the same file.
        history = file.create_group("history", track_order=True)
        for name, column in checkpoint.history.items():
            history.create_dataset(name, data=column)
        peak = file.create_group("peak")
        peak.attrs["force"], peak.attrs["row"] = checkpoint.peak.force, checkpoint.peak.row
        file.attrs["crest"] = json.dumps(checkpoint.crest)
        if checkpoint.peak.state is not None:
            _write_state(peak.create_group("state"), checkpoint.peak.state)


def _write_state(file: Any, state: SystemState) -> None:
    """A group for each body, slave, contact and spring, in their order."""
    file.attrs["time"] = state.time
    for kind in ("bodies", "slaves", "contacts", "springs"):
        file.create_group(kind, track_order=True)
    for name, body in state.bodies.items():
        group = file.create_group(f"bodies/{name}")
        group["pose"] = body.pose
        group["twist"] = np.concatenate(body.twist)
    for name, slave in state.slaves.items():
        group = file.create_group(f"slaves/{name}")
        group["points"], group["velocities"] = slave
    for name, contact in state.contacts.items():
        group = file.create_group(f"contacts/{name}")
        for key, array in contact.arrays.items():
            group[key] = array
    for name, spring in state.springs.items():
        group = file.create_group(f"springs/{name}")
        for key, value in spring._asdict().items():
            group[key] = value
    file["energy"] = np.array(state.energy)
    file["step"], file["most"] = state.step, state.most
    file["rigid"], file["wrenches"] = state.rigid, state.wrenches


def _read_state(file: Any, contacts: Iterable[ContactPart]) -> SystemState:
    def arrays(group: Any, *names: str) -> list[FloatArray]:
        return [np.asarray(group[name]) for name in names]

    bodies = [arrays(group, "pose", "twist") for group in file["bodies"].values()]
    poses, twists = (np.array(rows) for rows in zip(*bodies, strict=True))
    return SystemState(
        time=float(file.attrs["time"]),
        bodies=BodyStates({name: i for i, name in enumerate(file["bodies"])}, poses, twists),
        slaves={
            name: SlaveState(*arrays(group, "points", "velocities"))
            for name, group in file["slaves"].items()
        },
        contacts={
            part.name: State(
                **{key: np.asarray(array) for key, array in file["contacts"][part.name].items()},
                of=part.contact,
            )
            for part in contacts
        },
        energy=Energy(*map(float, file["energy"])),
        step=float(file["step"][()]),
        rigid=np.asarray(file["rigid"]),
        wrenches=np.asarray(file["wrenches"]),
        springs={name: _spring(group) for name, group in file["springs"].items()},
        most=float(file["most"][()]),
    )


def _spring(group: Any) -> SpringState:
    ends, *numbers = (group[key][()] for key in SpringState._fields)
    return SpringState(ends, *map(float, numbers))


def read_checkpoint(path: Path, fingerprint: str, contacts: Iterable[ContactPart]) -> Checkpoint:
    """Read a checkpoint and check that it belongs to the case.

    Raises
    ------
    CheckpointError
        Missing, damaged, of another format, or of another case.
    """
    if not path.is_file():
        raise CheckpointError(
            "there is no checkpoint to go on from",
            where=str(path),
            remedy="Run the case without --resume",
        )
    try:
        checkpoint = _read(path, contacts)
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise CheckpointError(
            "the checkpoint cannot be read",
            where=str(path),
            remedy="Run the case again without --resume",
        ) from error
    if checkpoint.fingerprint != fingerprint:
        raise CheckpointError(
            "the checkpoint is of another case, or its files have changed since",
            where=str(path),
            remedy="Go on with the case it was made from, or run this one without --resume",
        )
    return checkpoint


def _read(path: Path, contacts: Iterable[ContactPart]) -> Checkpoint:
    import h5py

    with h5py.File(path, "r") as file:
        if int(file.attrs["format"]) != FORMAT:
            raise ValueError("format")
        history = {name: np.asarray(column) for name, column in file["history"].items()}
        return Checkpoint(
            str(file.attrs["fingerprint"]),
            int(file.attrs["done"]),
            int(file.attrs["written"]),
            _read_state(file, contacts),
            history,
            _read_peak(file["peak"], contacts),
            tuple(Finding(*texts) for texts in json.loads(file.attrs["crest"])),
        )


def _read_peak(group: Any, contacts: Iterable[ContactPart]) -> Peak:
    state = _read_state(group["state"], contacts) if "state" in group else None
    return Peak(float(group.attrs["force"]), int(group.attrs["row"]), state)
