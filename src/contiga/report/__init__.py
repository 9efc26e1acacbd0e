"""The report of a run: one HTML file that reads offline, made from the output folder alone.

Question: what happened in this run? Read `run_folder` (the files of a run) and `fields`, `html`
(the page) and `html_tables`, `lines` and `plots` (figures over time) with one file a subject, such
as `motion`; `peak`, `scene` and `still` (the picture), `view`, `space`; `comparison` and `curves`
(several runs).
"""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

from contiga.extras import require

PICTURE = "peak.png"
PAGE = "report.html"


def require_packages(purpose: str = "a report") -> None:
    """Check that plotly and matplotlib are installed; `purpose` begins the message.

    Raises
    ------
    MissingPackageError
        One of them is not.
    """
    require(purpose, "plotly", "matplotlib")


def write_report(folder: str | Path) -> Path:
    """Write ``report.html`` and ``peak.png`` into the output folder of a run.

    Only files of the folder are read (history, fields, summary, case), so a report can be written
    again at any time and on another machine. Without recorded fields there are no pictures: the
    page says so, and ``peak.png`` is not written. A run that goes on or was stopped is shown up to
    its last checkpoint.

    Parameters
    ----------
    folder : output folder of a run

    Returns
    -------
    Path
        The page. Each file is written under another name and renamed whole.

    Raises
    ------
    FileError
        The folder is not that of a run, or of one that has just begun.
    MissingPackageError
        plotly or matplotlib is not installed.
    OutputError
        The folder cannot be written to.
    """
    require_packages()
    from contiga.io.out.files import atomic_write, write_text
    from contiga.report.frames import frames_of
    from contiga.report.html import page
    from contiga.report.peak import at_frame, peak_frame
    from contiga.report.places import ties_of
    from contiga.report.run_folder import read_fields, read_outlines, read_run
    from contiga.report.space import view_of
    from contiga.report.still import draw_still

    run = read_run(Path(folder))
    series = read_fields(run)
    still = view = peak_time = None
    if series is not None:
        frame = peak_frame(series, run.times, run.total("force"))
        outlines = read_outlines(run)
        ties = ties_of(run.summary)
        peak = at_frame(series, frame, outlines, ties)
        peak_time = peak.time
        with atomic_write(run.folder / PICTURE) as path:
            draw_still(peak, path, run.units)
        still = (run.folder / PICTURE).read_bytes()
        with series.held(), nullcontext() if outlines is None else outlines.held():
            frames = frames_of(series, outlines, frame, peak, run.units, ties)
        view = view_of(peak, frames, run.units, ties)
    text = page(run, still=still, view=view, peak_time=peak_time)
    write_text(run.folder / PAGE, text)
    return run.folder / PAGE
