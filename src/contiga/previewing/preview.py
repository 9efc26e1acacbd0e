"""`contiga.preview`: the parts before a run, to be looked at or saved."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from contiga.display import Facts, line_of
from contiga.errors import FileError, InputError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.previewing.page import page_of
from contiga.previewing.stage import Stage, stage_of
from contiga.previewing.still import draw_still
from contiga.previewing.words import gap_text
from contiga.simulation.model import Model

SUFFIXES = (".png", ".html")


class Preview:
    """The start of a simulation as a picture. A notebook shows it; `save` writes a 3D view, too.

    >>> import contiga as cg
    >>> ball = cg.Body(cg.shapes.sphere(radius=1.0))
    >>> pad = cg.Slave([[0.0, 0.0, 0.75]], area=[1.0])
    >>> press = cg.Contact(ball, pad, law=cg.PenaltyLaw(1.0))
    >>> parts = {"bodies": {"ball": ball}, "slaves": {"pad": pad}, "contacts": {"press": press}}
    >>> shown = cg.preview(cg.Simulation(**parts, end=1.0, step=0.5))
    >>> shown.gaps
    {'press': -0.25}
    >>> shown.save("start.png").name
    'start.png'
    """

    def __init__(self, stage: Stage) -> None:
        self.stage = stage

    @property
    def gaps(self) -> dict[str, float]:
        """The smallest gap of each contact at the start, negative inside the body."""
        return {gap.contact: gap.value for gap in self.stage.gaps}

    def __repr__(self) -> str:
        facts: Facts = [(gap.contact, gap_text(gap, self.stage.units)) for gap in self.stage.gaps]
        return line_of("Preview", [("parts", len(self.stage.parts)), *facts], self.stage.title)

    def _repr_png_(self) -> bytes:
        """Return the picture, drawn anew; a notebook calls this."""
        require("a preview", "matplotlib")
        picture = BytesIO()
        draw_still(self.stage, picture)
        return picture.getvalue()

    def save(self, path: str | Path) -> Path:
        """Write the preview as a picture (.png) or a page (.html), whole or not at all.

        Returns the path.

        Raises
        ------
        FileError
            Another suffix.
        OutputError
            The file cannot be written.
        MissingPackageError
            matplotlib (.png) or plotly (.html) is not installed.
        """
        path = check_suffix(path)
        if path.suffix.lower() == ".png":
            content = self._repr_png_()
        else:
            require("a preview", "plotly")
            content = page_of(self.stage).encode()
        with atomic_write(path) as temporary:
            temporary.write_bytes(content)
        return path


def check_suffix(path: str | Path) -> Path:
    """Return `path` if its suffix, in small or capital letters, is one that a preview is saved as.

    Raises
    ------
    FileError
        It ends neither in .png nor in .html.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(
            "a preview is a picture or a page", where=str(path), allowed=" or ".join(SUFFIXES)
        )
    return path


def preview(what: object) -> Preview:
    """Return a preview of the start of a simulation or a case; nothing is run.

    Its contents are computed here, the picture when a notebook shows it or `Preview.save` is
    called.

    Bodies show their free side (normals point there) and their contact side in another colour,
    slaves their points, with the inactive ones faint, motions their paths over the time of the run,
    and each contact its smallest gap. A point past the border of an open body, or deeper behind it
    than contact reaches, is not inside: its distance counts.

    Parameters
    ----------
    what : a Simulation, a Case, or the path of a case file

    Raises
    ------
    InputError
        None of these, or something in the case or its files is wrong.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body(cg.shapes.sphere(radius=1.0))
    >>> pad = cg.Slave([[0.0, 0.0, 1.25]], area=[1.0], name="pad")
    >>> cg.preview(
    ...     cg.Simulation(
    ...         bodies={"ball": ball},
    ...         slaves={"pad": pad},
    ...         contacts=[cg.Contact(ball, pad, law=cg.PenaltyLaw(1.0))],
    ...         end=1.0,
    ...         step=0.5,
    ...         title="Ball",
    ...         units=("mm", "g", "ms"),
    ...     )
    ... )
    Preview('Ball', parts 2, ball-pad gap 0.25 mm)
    """
    if isinstance(what, Model):
        return Preview(stage_of(what))
    from contiga.case.build import build
    from contiga.case.schema import Case, load_case

    case = load_case(what) if isinstance(what, str | Path) else what
    if not isinstance(case, Case):
        raise InputError(
            "nothing to preview",
            where="preview",
            found=type(what).__name__,
            allowed="a Simulation, a Case, or the path of a case file",
        )
    return Preview(stage_of(build(case)))
