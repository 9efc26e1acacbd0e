"""Draw the picture of the occupant from a run: ``python docs/draw_occupant.py FOLDER``."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from contiga.report.film import write_film

TARGET = Path(__file__).with_name("images") / "occupant.png"
END = 120.0
"""End of the run, ms."""
TIMES = (0.0, 34.0, 66.0, 100.0)
"""Times of the frames, ms."""
SECONDS = 5.0
VIEW = (0, 60, 760, 800)
"""Left, top, right and bottom of the scene in a frame of the film, pixels."""
WIDTH, COLOURS = 1000, 160
MARGIN = 12


def frames(folder: Path) -> list[Image.Image]:
    """Return the scene at each time without its white border."""
    with tempfile.TemporaryDirectory() as kept:
        film = write_film(folder, Path(kept) / "film.gif", seconds=SECONDS)
        with Image.open(film) as pictures:
            count = pictures.n_frames
            scenes = []
            for time in TIMES:
                pictures.seek(round(time / END * (count - 1)))
                scenes.append(pictures.convert("RGB").crop(VIEW))
    drawn = np.any([np.array(scene).min(axis=2) < 250 for scene in scenes], axis=0)
    rows = np.flatnonzero(drawn.any(axis=1))
    cut = []
    for scene in scenes:
        columns = np.flatnonzero((np.array(scene).min(axis=2) < 250).any(axis=0))
        cut.append(scene.crop((columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)))
    return cut


def main(folder: Path) -> None:
    """Put the frames beside each other."""
    scenes = frames(folder)
    width = sum(scene.width for scene in scenes) + MARGIN * (len(scenes) - 1)
    sheet = Image.new("RGB", (width, scenes[0].height + 40), "white")
    write, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=30)
    left = 0
    for scene, time in zip(scenes, TIMES, strict=True):
        sheet.paste(scene, (left, 40))
        write.text((left + scene.width // 2 - 40, 0), f"{time:g} ms", fill="black", font=font)
        left += scene.width + MARGIN
    small = sheet.resize((WIDTH, round(sheet.height * WIDTH / width)), Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(TARGET, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
