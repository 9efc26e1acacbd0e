"""The whole reproduction: every experiment run, its page, tables and pictures written."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from contiga.errors import FileError, RunError
from contiga.extras import require
from contiga.io.out import files
from contiga.simulation.clock import Clock
from contiga_validation.ahead import BEFORE, compiling_ahead
from contiga_validation.catalogue import chapter_title, chosen
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Experiment, Found, Options
from contiga_validation.engine.page import page
from contiga_validation.engine.suite import Progress, in_turn, opened, told_in
from contiga_validation.engine.table_files import as_json, machine, tidy_csv

PAGE, CSV, JSON, FIGURES = "report.html", "tables.csv", "tables.json", "figures"


def reproduce(
    out: str | Path,
    *,
    only: Sequence[str] | None = None,
    full: bool = False,
    cad: str | Path | None = None,
    data: str | Path | None = None,
    progress: Progress | None = None,
) -> Path:
    """Run the experiments of the thesis and write what they find into the folder `out`.

    Parameters
    ----------
    out : folder for ``report.html``, ``tables.csv``, ``tables.json`` and ``figures``
    only : keys of experiments, or chapters and sections; all of them if omitted
    full : in the comparison the finest meshes that memory allows, which takes tens of minutes
    cad : CAD file of the comparison's third body; one of `data`, or one made, if omitted
    data : folder of public CAD files; none is looked for if omitted
    progress : called with what is done, how much there is, and what comes next

    Returns
    -------
    Path
        The page. Nothing is written before all experiments are done; each file is written under
        another name and renamed whole, the page last.

    Raises
    ------
    InputError
        An unknown experiment, or a folder that cannot be written or is somebody else's.
    FileError
        No such CAD file.
    MissingPackageError
        A package that the experiments use is not installed.
    RunError
        An experiment could not be carried through.
    """
    require("a reproduction", "matplotlib", "pydantic", "sklearn", "OCP")
    part = None if cad is None else Path(cad)
    if part is not None and not part.is_file():
        raise FileError("no such file", where=str(part))
    wanted = chosen(only, Options(full, part, None if data is None else Path(data)))
    with opened(out, (CSV, JSON), "reproduction") as folder:
        return _write(folder, run_all(wanted, progress))


def run_all(
    experiments: Sequence[Experiment], progress: Progress | None = None
) -> tuple[Found, ...]:
    """Run experiments and draw their pictures, in memory.

    Raises
    ------
    RunError
        One could not be carried through; the message says which.
    """
    found = []
    with compiling_ahead(experiments) as wait:
        for experiment in in_turn(experiments, progress, lambda one: f"{one.key} {one.title}"):
            if experiment.chapter >= BEFORE:
                wait()
            found.append(_run(experiment))
    return tuple(found)


def broken_claims(folder: str | Path) -> list[str]:
    """Claims that did not hold in the reproduction left in `folder`, a line each.

    Raises
    ------
    FileError
        The folder holds no reproduction.
    """
    with told_in(Path(folder) / JSON, "the tables of a reproduction") as content:
        return [
            f"{experiment['key']}: {claim['text']} ({claim['measured']})"
            for experiment in content["experiments"]
            for claim in experiment["claims"]
            if not claim["holds"]
        ]


def _run(experiment: Experiment) -> Found:
    clock = Clock()
    start = perf_counter()
    try:
        with clock.watching():
            outcome = experiment.run()
            pictures = tuple(png(picture) for picture in outcome.pictures)
    except Exception as error:
        raise RunError(f"experiment {experiment.key}: {type(error).__name__}: {error}") from error
    return Found(experiment, outcome, pictures, perf_counter() - start, clock.compiled)


def _write(folder: Path, found: tuple[Found, ...]) -> Path:
    """The files of the folder; pictures that only an earlier reproduction had are removed."""
    figures = folder / FIGURES
    figures.mkdir(exist_ok=True)
    names = set()
    for entry in found:
        for picture, content in zip(entry.outcome.pictures, entry.pictures, strict=True):
            names.add(f"{picture.key}.png")
            with files.atomic_write(figures / f"{picture.key}.png") as path:
                path.write_bytes(content)
    for name in _pictures_of(folder) - names:
        (figures / name).unlink(missing_ok=True)
    facts = machine()
    files.write_text(folder / CSV, tidy_csv(found))
    files.write_json(folder / JSON, as_json(found, facts))
    files.write_text(folder / PAGE, page(found, facts, chapter_title))
    return folder / PAGE


def _pictures_of(folder: Path) -> set[str]:
    """Names of the pictures an earlier reproduction says it has written."""
    with suppress(FileError), told_in(folder / JSON, "the tables of a reproduction") as content:
        listed = [p["file"] for e in content["experiments"] for p in e["pictures"]]
        return {Path(file).name for file in listed}
    return set()
