"""Where a run stands, in one HDF5 file: enough to go on with the same bits."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.errors import CheckpointError
from contiga.io.out.files import atomic_write
from contiga.records import FloatArray

FORMAT = 3


class Checkpoint(NamedTuple):
    """A run after `done` of its steps."""

    fingerprint: str
    """Of the case and everything read for it."""
    done: int
    """Steps carried out, the start counted."""
    written: int
    """Steps in the fields file."""
    states: dict[str, State]
    """By the name of the contact."""
    history: dict[str, FloatArray]
    """Columns so far."""


def write_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write the file whole, in place of an older one."""
    import h5py

    with atomic_write(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs["format"] = FORMAT
        file.attrs["fingerprint"] = checkpoint.fingerprint
        file.attrs["done"] = checkpoint.done
        file.attrs["written"] = checkpoint.written
        for name, state in checkpoint.states.items():
            group = file.create_group(f"states/{name}")
            for field in fields(State):
                group.create_dataset(field.name, data=getattr(state, field.name))
        # Columns stay in their order: a resumed run writes the same file.
        history = file.create_group("history", track_order=True)
        for name, column in checkpoint.history.items():
            history.create_dataset(name, data=column)


def read_checkpoint(path: Path, fingerprint: str) -> Checkpoint:
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
        checkpoint = _read(path)
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


def _read(path: Path) -> Checkpoint:
    import h5py

    with h5py.File(path, "r") as file:
        if int(file.attrs["format"]) != FORMAT:
            raise ValueError("format")
        states = {
            name: State(**{f.name: np.asarray(group[f.name]) for f in fields(State)})
            for name, group in file["states"].items()
        }
        history = {name: np.asarray(column) for name, column in file["history"].items()}
        return Checkpoint(
            str(file.attrs["fingerprint"]),
            int(file.attrs["done"]),
            int(file.attrs["written"]),
            states,
            history,
        )
