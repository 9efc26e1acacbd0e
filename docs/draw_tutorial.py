"""Do what the tutorial says, and draw its pictures: ``python docs/draw_tutorial.py [FOLDER]``."""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
import tempfile
from pathlib import Path
from typing import Any

PAGE = Path(__file__).with_name("tutorial.md")
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
COLOURS = 256
"""Of a picture in the repository, which keeps it small."""
WIDTH = 960
TIMES = (1.5, 4.0, 25.0, 45.0)
"""Of the frames, ms."""


def follow(folder: Path, page: str) -> None:
    """Run the programs and the commands of the page one after the other in an empty folder."""
    from contiga.cli.commands import app

    names: dict[str, Any] = {}
    with contextlib.chdir(folder):
        for kind, text in BLOCK.findall(page):
            if kind == "python":
                exec(compile(text, PAGE.name, "exec"), names)
            elif kind == "toml":
                Path("impact.toml").write_text(text, encoding="utf-8")
            elif not kind:
                for line in re.findall(r"^contiga (.+)$", text, re.M):
                    app(shlex.split(line), standalone_mode=False)


def small(source: Path, target: Path) -> None:
    """A picture narrower and with few colours."""
    from PIL import Image

    with Image.open(source) as full:
        picture = full.convert("RGB")
    height = round(picture.height * WIDTH / picture.width)
    reduced = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
    # By the extent of colours, not by how often they occur: marks of few pixels keep theirs.
    reduced.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1).save(target, optimize=True)


def frames(fields: Path, times: list[float], target: Path) -> None:
    """The pad coloured by pressure at some times, and the impactor over it, as in ParaView.

    Parameters
    ----------
    fields : the file that ParaView opens
    times : of its steps
    """
    # The last one draws: without it the others have no window.
    from vtkmodules import vtkFiltersCore, vtkIOHDF, vtkRenderingCore, vtkRenderingOpenGL2  # noqa: F401

    window = vtkRenderingCore.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetSize(2 * WIDTH, WIDTH * 11 // 20)
    for k, time in enumerate(TIMES):
        reader = vtkIOHDF.vtkHDFReader()
        reader.SetFileName(str(fields))
        reader.UpdateInformation()
        reader.SetStep(min(range(len(times)), key=lambda i, at=time: abs(times[i] - at)))
        renderer = vtkRenderingCore.vtkRenderer()
        renderer.SetViewport(k / len(TIMES), 0.0, (k + 1) / len(TIMES), 1.0)
        renderer.SetBackground(1.0, 1.0, 1.0)
        for part in (1, 0):
            only = vtkFiltersCore.vtkThreshold()
            only.SetInputConnection(reader.GetOutputPort())
            only.SetInputArrayToProcess(0, 0, 0, 0, "part")
            only.SetLowerThreshold(part)
            only.SetUpperThreshold(part)
            renderer.AddActor(_actor(only, part))
        camera = renderer.GetActiveCamera()
        camera.SetPosition(1.0, -1.7, 1.5)
        camera.SetFocalPoint(0.0, 0.0, 0.0)
        camera.SetViewUp(0.0, 0.0, 1.0)
        renderer.ResetCamera(-80.0, 80.0, -80.0, 80.0, -60.0, 130.0)
        window.AddRenderer(renderer)
    _write(window, target)


def _actor(part: Any, number: int) -> Any:
    from vtkmodules import vtkRenderingCore

    mapper = vtkRenderingCore.vtkDataSetMapper()
    mapper.SetInputConnection(part.GetOutputPort())
    actor = vtkRenderingCore.vtkActor()
    actor.SetMapper(mapper)
    if number == 0:
        mapper.ScalarVisibilityOff()
        actor.GetProperty().SetColor(0.45, 0.55, 0.68)
        actor.GetProperty().SetOpacity(0.3)
        return actor
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("pressure")
    mapper.SetScalarRange(0.0, 1.6)
    table = vtkRenderingCore.vtkColorTransferFunction()
    for at, colour in ((0.0, "#f7ecd0"), (0.4, "#f6a04d"), (0.9, "#d8363f"), (1.6, "#4d0f4f")):
        table.AddRGBPoint(at, *(int(colour[j : j + 2], 16) / 255.0 for j in (1, 3, 5)))
    mapper.SetLookupTable(table)
    actor.GetProperty().LightingOff()
    return actor


def _write(window: Any, target: Path) -> None:
    from vtkmodules import vtkIOImage, vtkRenderingCore

    window.Render()
    image = vtkRenderingCore.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtkIOImage.vtkPNGWriter()
    writer.SetFileName(str(target))
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


def main(pictures: Path) -> None:
    """Do what the tutorial says in a temporary folder, and keep its pictures for the page."""
    import contiga as cg

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        follow(folder, PAGE.read_text(encoding="utf-8"))
        times = cg.open_result(folder / "out").fields.times.tolist()
        frames(folder / "out" / "fields.vtkhdf", times, folder / "frames.png")
        made = {
            "preview": folder / "preview.png",
            "peak": folder / "out" / "peak.png",
            "force": folder / "force.png",
            "frames": folder / "frames.png",
        }
        for picture, source in made.items():
            small(source, pictures / f"tutorial_{picture}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images")
