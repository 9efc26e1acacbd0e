"""The output folder of a run: names, and what an earlier run left in it."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from contiga.errors import CheckpointError, OutputError
from contiga.io.out.files import atomic_write
from contiga.io.out.stored import (
    CASE,
    CHECKPOINT,
    FIELDS,
    HISTORY,
    OUTLINES,
    SUMMARY,
    UNFINISHED,
    UNFINISHED_OUTLINES,
)

__all__ = [
    "CASE",
    "CHECKPOINT",
    "FIELDS",
    "HISTORY",
    "LOCK",
    "OURS",
    "OUTLINES",
    "SUMMARY",
    "UNFINISHED",
    "UNFINISHED_OUTLINES",
]

LOCK = "run.lock"
"""There while a run writes to the folder; it says which."""
# Not the copy of the case: a folder that holds a case.toml and nothing else is somebody's own.
OURS = (HISTORY, FIELDS, OUTLINES, SUMMARY, CHECKPOINT, UNFINISHED, UNFINISHED_OUTLINES, LOCK)
REPORT = ("report.html", "peak.png")


def clear_last_run(folder: Path) -> None:
    """Remove what would be taken for a part of the new run."""
    for name in (CHECKPOINT, UNFINISHED, UNFINISHED_OUTLINES):
        (folder / name).unlink(missing_ok=True)


def take_up_fields(folder: Path) -> None:
    """Have the unfinished fields and outlines of a run there, to go on with.

    Where it had gone through these are copies of the finished ones, which stay until it has again.

    Raises
    ------
    CheckpointError
        The fields are gone.
    """
    if not (folder / UNFINISHED).is_file():
        for finished, unfinished in ((OUTLINES, UNFINISHED_OUTLINES), (FIELDS, UNFINISHED)):
            if (folder / finished).is_file():
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
