"""A film of a run: the scene of the still picture at equally spaced times.

Frames are drawn off-screen from the recorded fields. MP4 is encoded by the ffmpeg that the package
imageio-ffmpeg brings, GIF by Pillow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contiga.errors import FileError, InputError, OutputError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.records import FloatArray
from contiga.rendering.camera import look
from contiga.report.coloured import fields_of
from contiga.report.frames import chosen_steps
from contiga.report.peak import at_frame, peak_frame, seen_parts
from contiga.report.places import ties_of
from contiga.report.run_folder import Run, read_fields, read_outlines, read_run
from contiga.report.scene import outside_direction, render, upwards
from contiga.report.still import SAMPLES, put_bar, put_view
from contiga.report.style import number

if TYPE_CHECKING:
    from PIL.Image import Image

    from contiga.io.out.outlines import OutlineSeries
    from contiga.report.fields import RecordedFields

SUFFIXES = (".mp4", ".gif")
SECONDS = 6.0
"""Length of a film if none is given, that of the play button of the report."""
_RATES = {".mp4": 25, ".gif": 12}
"""Frames per second."""
_COLUMNS, _ROWS, _VIEW = 880, 832, 760
"""Width and height of a frame, multiples of 16 for encoders, and width of the view beside the
colour bar, pixels."""
_MAX_FRAMED = 40
"""Largest number of recorded steps that the camera is fitted to."""

Show = Callable[[int, int, str], Any]
"""Called with the number of frames drawn, the number of all frames, and a text."""


def write_film(
    folder: str | Path, path: str | Path, *, seconds: float = SECONDS, show: Show | None = None
) -> Path:
    """Write a film of the recorded steps of a run as .mp4 or .gif, whole or not at all.

    Parameters
    ----------
    folder : output folder of a run
    path : film to write
    seconds : length of the film, seconds; its frames show the recorded steps nearest to equally
        spaced times of the run
    show : called with the number of frames drawn, the number of all frames, and a text

    Raises
    ------
    FileError
        The suffix is neither .mp4 nor .gif, or the folder is not that of a run.
    InputError
        The run recorded fields at fewer than two steps, or the length is not 0.1 s to 600 s.
    MissingPackageError
        matplotlib, or for .mp4 imageio-ffmpeg, is not installed.
    OutputError
        The film cannot be written or encoded.

    Returns
    -------
    Path
        The film.
    """
    path = checked_path(path)
    if not 0.1 <= seconds <= 600.0:
        raise InputError(
            "a film has a length in seconds", where="seconds", found=seconds, allowed="0.1 to 600"
        )
    run = read_run(Path(folder))
    series = read_fields(run)
    if series is None or len(series.times) < 2:
        raise InputError(
            "a film needs two recorded steps at least",
            where=str(run.folder),
            found=0 if series is None else len(series.times),
            remedy='Run the case with "vtkhdf" among [output] formats',
        )
    outlines = read_outlines(run)
    rate = _RATES[path.suffix.lower()]
    steps = _nearest_steps(series.times, max(2, round(seconds * rate)))
    frames = _frames(run, series, outlines, steps, show)
    with series.held(), atomic_write(path) as temporary:
        if path.suffix.lower() == ".mp4":
            _write_mp4(temporary, frames, rate, path)
        else:
            pictures = (frame.quantize(128) for frame in frames)  # each with its own palette
            next(pictures).save(
                temporary,
                format="gif",
                save_all=True,
                append_images=pictures,
                duration=round(1000 / rate),
                loop=0,
            )
    return path


def checked_path(path: str | Path) -> Path:
    """Return the path of a film after checking its suffix and the packages that it needs.

    Raises
    ------
    FileError
        The suffix is neither .mp4 nor .gif.
    MissingPackageError
        matplotlib, or for .mp4 imageio-ffmpeg, is not installed.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(
            "a film is an .mp4 or a .gif",
            where=str(path),
            found=path.suffix or "no suffix",
            allowed=" or ".join(SUFFIXES),
        )
    require("a film", "matplotlib")  # which brings Pillow and fonts
    if path.suffix.lower() == ".mp4":
        require("a film as .mp4 (.gif needs no encoder)", "imageio_ffmpeg")
    return path


def _nearest_steps(times: FloatArray, count: int) -> NDArray[np.intp]:
    """Return the recorded step (count,) nearest to each of `count` equally spaced times.

    Of two steps equally near it is the later one.
    """
    frame_times = np.linspace(times[0], times[-1], count)
    after = np.clip(np.searchsorted(times, frame_times), 1, len(times) - 1)
    before_is_nearer = frame_times - times[after - 1] < times[after] - frame_times
    return np.asarray(np.where(before_is_nearer, after - 1, after))


def _frames(
    run: Run,
    series: RecordedFields,
    outlines: OutlineSeries | None,
    steps: NDArray[np.intp],
    show: Show | None,
) -> Iterator[Image]:
    """Yield the frames; frames in a row that show the same step are one picture, drawn once.

    All have the camera of the touching parts at up to `_MAX_FRAMED` steps, and the field and
    colours of the peak: the von Mises stress of facets, else pressure, else penetration. `show` is
    called after each frame.
    """
    from PIL import Image

    peak_step = peak_frame(series, run.times, run.total("force"))
    ties = ties_of(run.summary)
    peak = at_frame(series, peak_step, None, ties)
    fields = fields_of(peak, run.units)
    has_stress = "von_mises" in fields and len(peak.slave_triangles) > 0
    contact_field = "pressure" if "pressure" in fields else "penetration"
    name = "von_mises" if has_stress else contact_field
    has_colour = has_stress or bool(peak.in_contact.any())
    corners = []
    for step in chosen_steps(series.times, peak_step, _MAX_FRAMED):
        parts = seen_parts(series, int(step))
        points = np.concatenate(parts) if peak.focus is None else peak.focus.points(parts)
        points = points[np.isfinite(points).all(axis=1)]
        corners += list(product(*np.stack([points.min(axis=0), points.max(axis=0)]).T))
    size = (_ROWS * SAMPLES, _VIEW * SAMPLES)
    camera = look(outside_direction(peak), upwards(peak), np.array(corners), size)
    picture, step_drawn = None, -1
    for k, step in enumerate(steps.tolist()):
        if picture is None or step != step_drawn:
            scene = at_frame(series, step, outlines, ties)
            field = fields_of(scene, run.units).get(name)
            values = np.zeros(len(scene.slave_points)) if field is None else field.values
            field = fields[name]._replace(values=values)
            picture, step_drawn = Image.new("RGB", (_COLUMNS, _ROWS), "white"), step
            title = f"t = {number(scene.time)} {run.units.time}".rstrip()
            put_view(picture, render(camera, scene, field, through=False), title, 0, top=0)
            if has_colour:
                put_bar(picture, field, _VIEW + 12)
        yield picture
        if show is not None:
            show(k + 1, len(steps), "")


def _write_mp4(temporary: Path, frames: Iterator[Image], rate: int, path: Path) -> None:
    """Encode frames into `temporary`; an error of the encoder is an OutputError with `path`."""
    import imageio_ffmpeg

    try:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), (_COLUMNS, _ROWS), fps=rate, quality=8, ffmpeg_log_level="error"
        )
        writer.send(None)
        for frame in frames:
            writer.send(np.asarray(frame).tobytes())
        writer.close()
    except (OSError, RuntimeError) as error:
        raise OutputError(
            f"the film cannot be encoded: {str(error).splitlines()[0]}",
            where=str(path),
            remedy="Write a .gif, which needs no encoder",
        ) from error
