"""The reproduction of the thesis: run all experiments, write page, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from contiga.errors import FileError, RunError
from contiga.extras import require
from contiga.io.out import files
from contiga.simulation.clock import Clock
from contiga_validation.ahead import FIRST_TIMED_CHAPTER, compiling_ahead
from contiga_validation.catalogue import chapter_title, selected
from contiga_validation.engine.drawing import png
from contiga_validation.engine.experiment import Experiment, ExperimentResult, Options
from contiga_validation.engine.page import page
from contiga_validation.engine.suite import Progress, reading, results_folder, with_progress
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
    """Run the experiments of the thesis and write their results to the folder `out`.

    Parameters
    ----------
    out : folder for ``report.html``, ``tables.csv``, ``tables.json`` and ``figures``
    only : keys of experiments, or chapters and sections; all of them if omitted
    full : use the finest meshes that memory allows in the comparison: tens of minutes
    cad : CAD file of the comparison's third body; from `data`, or a generated one, if omitted
    data : folder of public CAD files, if any
    progress : called with the number done, the total, and the title of the next one

    Returns
    -------
    Path
        The page. Nothing is written before all experiments are done; files are written
        atomically, the page last.

    Raises
    ------
    InputError
        The experiment is unknown, or the folder cannot be written or holds other files.
    FileError
        The CAD file is missing.
    MissingPackageError
        A package of the experiments is not installed.
    RunError
        An experiment failed.
    """
    require("a reproduction", "matplotlib", "pydantic", "sklearn", "OCP")
    part = None if cad is None else Path(cad)
    if part is not None and not part.is_file():
        raise FileError("no such file", where=str(part))
    experiments = selected(only, Options(full, part, None if data is None else Path(data)))
    with results_folder(out, (CSV, JSON), "reproduction") as folder:
        return _write(folder, run_all(experiments, progress))


def run_all(
    experiments: Sequence[Experiment], progress: Progress | None = None
) -> tuple[ExperimentResult, ...]:
    """Run experiments and draw their pictures, in memory, while a second process compiles kernels.

    Raises
    ------
    RunError
        An experiment failed; the message names it.
    """
    results = []
    with compiling_ahead(experiments) as wait:
        for experiment in with_progress(experiments, progress, lambda e: f"{e.key} {e.title}"):
            if experiment.chapter >= FIRST_TIMED_CHAPTER:
                wait()
            results.append(_run(experiment))
    return tuple(results)


def broken_claims(folder: str | Path) -> list[str]:
    """Return the claims that did not hold in the reproduction in `folder`, one line each.

    Raises
    ------
    FileError
        The folder holds no reproduction.
    """
    with reading(Path(folder) / JSON, "the tables of a reproduction") as content:
        return [
            f"{experiment['key']}: {claim['text']} ({claim['measured']})"
            for experiment in content["experiments"]
            for claim in experiment["claims"]
            if not claim["holds"]
        ]


def _run(experiment: Experiment) -> ExperimentResult:
    """Run an experiment and draw its pictures; any error becomes a RunError that names it."""
    clock = Clock()
    start = perf_counter()
    try:
        with clock.watching():
            outcome = experiment.run()
            pictures = tuple(png(picture) for picture in outcome.pictures)
    except Exception as error:
        raise RunError(f"experiment {experiment.key}: {type(error).__name__}: {error}") from error
    return ExperimentResult(experiment, outcome, pictures, perf_counter() - start, clock.compiled)


def _write(folder: Path, results: tuple[ExperimentResult, ...]) -> Path:
    """Write the files of the folder; remove pictures that only an earlier reproduction had."""
    figures = folder / FIGURES
    figures.mkdir(exist_ok=True)
    names = set()
    for entry in results:
        for picture, content in zip(entry.outcome.pictures, entry.pictures, strict=True):
            names.add(f"{picture.key}.png")
            with files.atomic_write(figures / f"{picture.key}.png") as path:
                path.write_bytes(content)
    earlier_names: set[str] = set()
    with suppress(FileError), reading(folder / JSON, "the tables of a reproduction") as tables:
        listed = [p["file"] for e in tables["experiments"] for p in e["pictures"]]
        earlier_names = {Path(file).name for file in listed}
    for name in earlier_names - names:
        (figures / name).unlink(missing_ok=True)
    facts = machine()
    files.write_text(folder / CSV, tidy_csv(results))
    files.write_json(folder / JSON, as_json(results, facts))
    files.write_text(folder / PAGE, page(results, facts, chapter_title))
    return folder / PAGE
