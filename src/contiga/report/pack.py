"""A run or a study as one zip file to send; a browser and a spreadsheet open it offline."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from contiga.errors import FileError
from contiga.io.out.files import atomic_write, check_suffix
from contiga.io.out.stored import CASE, FIELDS, HISTORY, OUTLINES, SUMMARY
from contiga.report import PAGE, PICTURE

_OF_RUN = (PAGE, PICTURE, HISTORY, SUMMARY, CASE, "row.json")
_OF_STUDY = ("study.html", "map.png", "table.csv", "table.h5", "study.json")
_FIELDS = (FIELDS, OUTLINES)


def pack(folder: str | Path, path: str | Path, *, fields: bool = False) -> int:
    """Write the page, numbers and case of a run, or of all cases of a study, into a zip file.

    The files stand in one folder with the name of `folder`; links between the pages of a study
    lead to the reports of its cases there.

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
    files = list(_files(Path(folder), fields))
    folder, name = Path(folder), Path(folder).resolve().name
    with atomic_write(path) as temporary, ZipFile(temporary, "w", ZIP_DEFLATED) as archive:
        for file in files:
            archive.write(file, Path(name) / file.relative_to(folder))
    return len(files)


def _files(folder: Path, fields: bool) -> Iterator[Path]:
    of_run = (*_OF_RUN, *(_FIELDS if fields else ()))
    study = (folder / "study.json").is_file()
    page = folder / (_OF_STUDY[0] if study else PAGE)
    if not page.is_file():
        raise FileError(
            f"the folder cannot be packed: {page.name} is missing",
            where=str(folder),
            allowed="the output folder of a run with a report, or of a study",
            remedy=f"contiga report {folder}" if (folder / SUMMARY).is_file() else None,
        )
    yield from (
        folder / name for name in (_OF_STUDY if study else of_run) if (folder / name).is_file()
    )
    if study:
        for case in sorted(folder.glob("cases/*")):
            yield from (case / name for name in of_run if (case / name).is_file())
