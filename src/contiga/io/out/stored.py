"""Output of a run so far, read from its folder without the code that wrote it.

A run that has ended leaves `history.csv` and `summary.json`. While it goes on, and after it was
stopped, both are in its last checkpoint, and its fields and outlines are complete up to the last
step that was written.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import FileError, MissingPackageError
from contiga.extras import require
from contiga.io.out.hdf5 import begins_as_hdf5, is_sealed
from contiga.io.out.history import read_history
from contiga.records import FloatArray

HISTORY, FIELDS, CASE = "history.csv", "fields.vtkhdf", "case.toml"
SUMMARY = "summary.json"
CHECKPOINT, CHECKPOINT_BEFORE = "checkpoint.h5", "checkpoint.before.h5"
OUTLINES = "outlines.vtkhdf"
UNFINISHED, UNFINISHED_OUTLINES = FIELDS + ".part", OUTLINES + ".part"
SUMMARY_KEY = "summary"
"""Name of the summary in a checkpoint, as JSON text."""


class Stored(NamedTuple):
    """The available output of a run."""

    folder: Path
    finished: bool
    history: dict[str, FloatArray]
    """Columns (n,) by name."""
    summary: dict[str, Any]


def read_stored(folder: str | Path) -> Stored:
    """Return history and summary of a run, up to its last checkpoint if it has not ended.

    Of a run that has ended the two files are read, unless a checkpoint beside them has another
    title or number of steps: it is then of a later run, and is returned.

    Raises
    ------
    FileError
        There is no such folder, no run in it, or nothing of it yet; files that cannot be read.
    MissingPackageError
        The run has not ended, and the package that reads its checkpoint is not installed.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(
            "no such output folder", where=str(folder), remedy="Run a case first: contiga run"
        )
    has_ended = (
        (folder / SUMMARY).is_file()
        and (folder / HISTORY).is_file()
        and not (folder / UNFINISHED).is_file()
    )
    try:
        stored = _checkpoint_output(newest_checkpoint(folder))
    except (FileError, MissingPackageError):
        if not has_ended:
            raise
        stored = None  # the other files of the run are complete
    if has_ended:
        try:
            summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        except (ValueError, OSError) as error:
            raise FileError("not a readable summary", where=str(folder / SUMMARY)) from error
        # the checkpoint may be of a later run in the same folder
        if stored is None or all(
            stored.summary.get(key) == summary.get(key) for key in ("title", "steps")
        ):
            return Stored(folder, True, _floats(read_history(folder / HISTORY)), summary)
    if stored is not None:
        return stored
    if (folder / UNFINISHED).is_file():
        raise FileError(
            "the run has just begun, and tells of itself from its first checkpoint on",
            where=str(folder),
            remedy="Look again some seconds later",
        )
    missing = HISTORY if (folder / SUMMARY).is_file() else SUMMARY
    raise FileError(f"not the output folder of a run: {missing} is missing", where=str(folder))


def newest_checkpoint(folder: Path) -> Path:
    """Return the path of the checkpoint to continue from, which may not exist.

    It is the one before if only that exists: a run was killed while it replaced its checkpoint.
    """
    newest, before = folder / CHECKPOINT, folder / CHECKPOINT_BEFORE
    return before if before.is_file() and not newest.is_file() else newest


def unsealed_message(path: Path) -> dict[str, str]:
    """Return `what` and `remedy` of the error about a checkpoint that is not sealed.

    It cannot be read, is of an older version, or is damaged; the remedy for a damaged one depends
    on whether the checkpoint before it is sound.
    """
    try:
        older = begins_as_hdf5(path)
    except OSError as error:
        remedy = "Have it read, or run the case again without --resume"
        return {"what": f"the checkpoint cannot be read: {error.strerror}", "remedy": remedy}
    if older:
        return {
            "what": "the checkpoint was written by an older version",
            "remedy": "Go on with that version, or run the case again without --resume",
        }
    before = path.with_name(CHECKPOINT_BEFORE)
    if path == before or not (before.is_file() and is_sealed(before)):
        remedy = "Run the case again without --resume"
        return {"what": "the checkpoint is damaged, and there is none before it", "remedy": remedy}
    return {
        "what": f"the checkpoint is damaged; the one before is {before.name}",
        "remedy": f"Rename that to {CHECKPOINT} to go on from there",
    }


def _checkpoint_output(path: Path) -> Stored | None:
    """Return history and summary in a checkpoint; None if it does not exist, or has no summary.

    Raises
    ------
    FileError
        It is not sealed, or its content is not that of a checkpoint.
    MissingPackageError
        The package that reads it is not installed.
    """
    if not path.is_file():
        return None
    if not is_sealed(path):
        raise FileError(**unsealed_message(path), where=str(path))
    require("what an unfinished run has left", "h5py")
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            if SUMMARY_KEY not in file:
                return None
            history = {name: np.asarray(column) for name, column in file["history"].items()}
            summary: dict[str, Any] = json.loads(file[SUMMARY_KEY].asstr()[()])
    except (OSError, KeyError, ValueError, AttributeError) as error:
        raise FileError("the checkpoint cannot be read", where=str(path)) from error
    return Stored(path.parent, False, _floats(history), summary)


def _floats(history: dict[str, Any]) -> dict[str, FloatArray]:
    return {name: np.asarray(column, np.float64) for name, column in history.items()}
