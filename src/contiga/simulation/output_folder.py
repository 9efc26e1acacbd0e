"""The output folder of a run: what may be written to, names, final renames."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from contiga.errors import OutputError
from contiga.io.out.atomic import atomic_write

HISTORY, FIELDS, CASE = "history.csv", "fields.vtkhdf", "case.toml"
SUMMARY, CHECKPOINT = "summary.json", "checkpoint.h5"
OUTLINES = "outlines.vtkhdf"
UNFINISHED, UNFINISHED_OUTLINES = FIELDS + ".part", OUTLINES + ".part"
# Not the copy of the case: a folder that holds a case.toml and nothing else is somebody's own.
OURS = (HISTORY, FIELDS, OUTLINES, SUMMARY, CHECKPOINT, UNFINISHED, UNFINISHED_OUTLINES)
REPORT = ("report.html", "peak.png")


def open_folder(folder: Path, ours: Iterable[str] = OURS, kind: str = "run") -> bool:
    """Make sure that `folder` can be written to and holds nothing of somebody else.

    Parameters
    ----------
    ours : names of files that tell an earlier folder of the same kind
    kind : what the folder is of, in words

    Returns
    -------
    bool
        Whether it has been made.

    Raises
    ------
    OutputError
        It is a file, cannot be made or written, or holds files but none of `ours`.
    """
    where = str(folder)
    if folder.exists() and not folder.is_dir():
        raise OutputError("the output folder is a file", where=where, allowed="a folder")
    if folder.is_dir():
        names = {path.name for path in folder.iterdir()}
        if names and not names & set(ours):
            raise OutputError(
                f"the output folder holds files that are not of a {kind}",
                where=where,
                found=sorted(names)[0],
                allowed=f"a new or empty folder, or that of an earlier {kind}",
            )
    missing = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(
            "the output folder cannot be written",
            where=where,
            found=error.strerror,
            allowed="a folder you may write to",
        ) from error
    return missing


def clear_last_run(folder: Path) -> None:
    """Remove what would be taken for a part of the new run."""
    for name in (CHECKPOINT, UNFINISHED, UNFINISHED_OUTLINES):
        (folder / name).unlink(missing_ok=True)


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


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with atomic_write(path) as temporary:
        Path(temporary).write_text(text, encoding="utf-8")


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a JSON file whole or not at all."""
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False) + "\n")
