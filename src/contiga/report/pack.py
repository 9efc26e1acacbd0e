"""A run or a study as one zip file to send; a browser and a spreadsheet open it offline."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from contiga.errors import FileError
from contiga.io.out.files import atomic_write, check_suffix
from contiga.io.out.stored import CASE, FIELDS, HISTORY, OUTLINES, SUMMARY
from contiga.report import PAGE, PICTURE

_RUN_FILES = (PAGE, PICTURE, HISTORY, SUMMARY, CASE, "row.json")
_STUDY_FILES = ("study.html", "map.png", "table.csv", "table.h5", "study.json")
_FIELD_FILES = (FIELDS, OUTLINES)


def pack(folder: str | Path, path: str | Path, *, fields: bool = False) -> int:
    """Write the page, numbers and case of a run, or of all cases of a study, into a zip file.

    The files stand in one folder with the name of `folder`; links between the pages of a study
    lead to the reports of its cases there. Files that do not exist are skipped, except the page.

    Parameters
    ----------
    folder : output folder of a run or a study
    path : zip file to write (.zip), whole or not at all
    fields : include the fields for ParaView, which are large

    Returns
    -------
    int
        Number of files in it.

    Raises
    ------
    FileError
        The folder is neither of a run nor of a study, or has no page; another suffix than .zip.
    OutputError
        The file cannot be written.
    """
    check_suffix(path, ".zip")
    folder, name = Path(folder), Path(folder).resolve().name
    run_files = (*_RUN_FILES, *(_FIELD_FILES if fields else ()))
    is_study = (folder / "study.json").is_file()
    page = folder / (_STUDY_FILES[0] if is_study else PAGE)
    if not page.is_file():
        raise FileError(
            f"the folder cannot be packed: {page.name} is missing",
            where=str(folder),
            allowed="the output folder of a run with a report, or of a study",
            remedy=f"contiga report {folder}" if (folder / SUMMARY).is_file() else None,
        )
    paths = [folder / file for file in (_STUDY_FILES if is_study else run_files)]
    if is_study:
        paths += [case / file for case in sorted(folder.glob("cases/*")) for file in run_files]
    files = [path for path in paths if path.is_file()]
    with atomic_write(path) as temporary, ZipFile(temporary, "w", ZIP_DEFLATED) as archive:
        for file in files:
            archive.write(file, Path(name) / file.relative_to(folder))
    return len(files)
