"""Name the files in the output folder of a run, and clear what an earlier run left there."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from contiga.errors import CheckpointError, OutputError
from contiga.io.out.files import atomic_write, clear_temporaries
from contiga.io.out.stored import (
    CASE,
    CHECKPOINT,
    CHECKPOINT_BEFORE,
    FIELDS,
    HISTORY,
    OUTLINES,
    SUMMARY,
    UNFINISHED,
    UNFINISHED_OUTLINES,
    newest_checkpoint,
)

__all__ = [
    "CASE",
    "CHECKPOINT",
    "CHECKPOINT_BEFORE",
    "FIELDS",
    "HISTORY",
    "LOCK",
    "OURS",
    "OUTLINES",
    "SUMMARY",
    "UNFINISHED",
    "UNFINISHED_OUTLINES",
    "newest_checkpoint",
]

LOCK = "run.lock"
"""There while a run writes to the folder; it says which."""
# Not the copy of the case: a folder that holds a case.toml and nothing else is somebody's own.
_CHECKPOINTS = (CHECKPOINT, CHECKPOINT_BEFORE)
_UNFINISHED = (UNFINISHED, UNFINISHED_OUTLINES)
OURS = (HISTORY, FIELDS, OUTLINES, SUMMARY, *_CHECKPOINTS, *_UNFINISHED, LOCK)
REPORT = ("report.html", "peak.png")


def clear_last_run(folder: Path) -> None:
    """Remove what would be taken for a part of the new run."""
    for name in (*_CHECKPOINTS, *_UNFINISHED):
        (folder / name).unlink(missing_ok=True)


def clear_killed(folder: Path) -> None:
    """Remove the half-written files of runs that were killed.

    Those of reports stay: somebody may just be writing one, who need not have locked the folder.
    """
    clear_temporaries(folder, (*OURS, CASE))


def finish_fields(folder: Path, *, outlines: bool) -> None:
    """Give fields and outlines their final names, each that has not got it yet."""
    if (folder / UNFINISHED).exists() and not outlines:
        (folder / OUTLINES).unlink(missing_ok=True)
    for unfinished, finished in _series(outlines):
        if (folder / unfinished).exists():
            (folder / unfinished).replace(folder / finished)


def _series(outlines: bool) -> tuple[tuple[str, str], ...]:
    """Names of fields and outlines while a run goes on and after it."""
    fields = (UNFINISHED, FIELDS)
    return ((UNFINISHED_OUTLINES, OUTLINES), fields) if outlines else (fields,)


def take_up_fields(folder: Path, *, outlines: bool) -> None:
    """Open the unfinished fields and outlines of a run, to go on with them.

    Where it had gone through these are copies of the finished ones, which stay until it has again.

    Raises
    ------
    CheckpointError
        The fields are gone.
    """
    for unfinished, finished in _series(outlines):
        if (folder / finished).is_file() and not (folder / unfinished).is_file():
            with atomic_write(folder / unfinished) as temporary:
                shutil.copyfile(folder / finished, temporary)
    if not (folder / UNFINISHED).is_file():
        raise CheckpointError(
            "the fields of the run that is to go on are not there",
            where=str(folder / FIELDS),
            remedy="Put the file back, or run the case without --resume",
        )


def clear_stale(folder: Path, formats: Iterable[str]) -> None:
    """Remove what an earlier run left and this one does not write: results do not mix.

    The report goes in any case: it is made anew from the other files.
    """
    stale: list[str] = list(REPORT)
    if "csv" not in formats:
        stale.append(HISTORY)
    if "vtkhdf" not in formats:
        stale += [FIELDS, OUTLINES]
    for name in stale:
        (folder / name).unlink(missing_ok=True)


def keep_case_file(folder: Path, case_file: Path, case_text: str) -> None:
    """Refuse to write the copy of a case over the case itself.

    Raises
    ------
    OutputError
        The case stands in `folder` under the name of the copy, and says it in other words.
    """
    copy = folder / CASE
    if not (copy.is_file() and case_file.is_file() and copy.samefile(case_file)):
        return
    if copy.read_text(encoding="utf-8") != case_text:
        raise OutputError(
            "the run would write its copy of the case over the case file",
            where=str(copy),
            allowed="another output folder (-o), or another name of the case file",
        )
