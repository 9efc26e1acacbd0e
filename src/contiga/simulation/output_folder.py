"""Define the files in the output folder of a run, and remove those of an earlier run."""

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
    "OUTLINES",
    "RUN_FILES",
    "SUMMARY",
    "UNFINISHED",
    "UNFINISHED_OUTLINES",
    "newest_checkpoint",
]

LOCK = "run.lock"
"""File that exists while a run writes to the folder; it names the run."""
# Without the copy of the case: a folder that holds only a case.toml may be the user's own.
_CHECKPOINTS = (CHECKPOINT, CHECKPOINT_BEFORE)
_UNFINISHED = (UNFINISHED, UNFINISHED_OUTLINES)
RUN_FILES = (HISTORY, FIELDS, OUTLINES, SUMMARY, *_CHECKPOINTS, *_UNFINISHED, LOCK)
REPORT = ("report.html", "peak.png")


def clear_last_run(folder: Path) -> None:
    """Remove checkpoints and unfinished fields of an earlier run."""
    for name in (*_CHECKPOINTS, *_UNFINISHED):
        (folder / name).unlink(missing_ok=True)


def clear_killed(folder: Path) -> None:
    """Remove temporary files of runs that were killed.

    Those of reports stay: another process may be writing a report without locking the folder.
    """
    clear_temporaries(folder, (*RUN_FILES, CASE))


def finish_fields(folder: Path, *, outlines: bool) -> None:
    """Rename unfinished fields and outlines to their final names; missing ones are passed over.

    Outlines of an earlier run are removed if this one has fields without outlines.
    """
    if (folder / UNFINISHED).exists() and not outlines:
        (folder / OUTLINES).unlink(missing_ok=True)
    for unfinished, finished in _field_names(outlines):
        if (folder / unfinished).exists():
            (folder / unfinished).replace(folder / finished)


def _field_names(outlines: bool) -> tuple[tuple[str, str], ...]:
    """Return (name during a run, name after it) of outlines, if `outlines`, and of fields."""
    fields = (UNFINISHED, FIELDS)
    return ((UNFINISHED_OUTLINES, OUTLINES), fields) if outlines else (fields,)


def reopen_fields(folder: Path, *, outlines: bool) -> None:
    """Provide unfinished fields and outlines for a run that goes on.

    If the run had ended, they are copies of the finished files, which stay until it ends again.

    Raises
    ------
    CheckpointError
        There are neither unfinished nor finished fields.
    """
    for unfinished, finished in _field_names(outlines):
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
    """Remove results of an earlier run that the next run will not replace, so that they do not mix.

    Without "csv" in `formats` these are the history, without "vtkhdf" fields and outlines, and
    always the report and its picture, which are made from the other files. Other files stay;
    `finish_fields` removes outlines that new fields do not have.
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
        The case file is in `folder` under the name of the copy, with a different text.
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
