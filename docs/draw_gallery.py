"""Run the cases of the gallery, draw their pictures and write its page.

``python docs/draw_gallery.py [NAME …]`` runs all cases of the page, or some of them anew, which
takes a few minutes. Each picture is that of the run's report beside curves of its history.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import contiga as cg
from contiga.report import style
from contiga.report.curve_picture import draw_curves
from contiga.report.references import rated, references_of
from contiga.report.run_folder import read_run

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images"
COLOURS = 256
"""Of a picture in the repository, which keeps it small."""
HEIGHT = 320
LARGEST = 60_000
"""Bytes of a picture."""


class Entry(NamedTuple):
    """A run of the gallery."""

    name: str
    case: str
    """Below `examples`."""
    columns: tuple[str, ...]
    """Of the history, to be drawn."""
    numbers: tuple[str, ...]
    """Columns of which the page tells the largest magnitude."""
    over: str = "time"
    """Channel that the columns are drawn over, with the tests that the case names."""


ENTRIES = (
    Entry("headform", "01_headform.toml", ("force",), ("force", "max_penetration", "area")),
    Entry("regions", "02_two_regions.toml", ("force", "n_clusters"), ("force", "n_clusters")),
    Entry("collision", "03_two_parts.toml", ("ring.vz", "ball.vz"), ("force", "ring.wx")),
    Entry("sled", "04_sled.toml", ("chest.vx", "belt.force", "force"), ("belt.force", "force")),
    Entry("pad", "pad.toml", ("force", "head_cg.filtered_a"), ("force", "max_penetration")),
    Entry(
        "foam",
        "06_headform_foam.toml",
        ("force", "head_cg.filtered_a"),
        ("force", "max_penetration"),
    ),
    Entry("tyre", "07_tyre.toml", ("force_z", "force_x"), ("force", "max_penetration")),
    Entry("cloth", "08_cloth.toml", ("front hem.z", "force"), ("front hem.z",)),
    Entry(
        "rubber_ring",
        "09_rubber_ring.toml",
        ("lower eye.vz", "side.fz"),
        ("above.force", "side.fz"),
    ),
    Entry(
        "airbag",
        "10_airbag.toml",
        ("bag.pressure", "bag.volume", "head.vz", "head on bag.force"),
        ("bag.pressure", "bag.volume"),
    ),
    Entry(
        "sled_belt",
        "11_sled_belt.toml",
        ("lower belt.force", "upper belt.force", "lower belt.paid_out"),
        ("upper belt.force", "lower belt.travel"),
    ),
    Entry(
        "torso_belt",
        "12_torso_belt.toml",
        ("chest.vx", "chest-belt.force"),
        ("chest-belt.force", "chest.vx"),
    ),
    Entry(
        "three_point_belt",
        "13_three_point_belt.toml",
        ("shoulder start.force", "lap start.force", "retractor.force", "retractor.paid_out"),
        ("shoulder start.force", "lap start.force", "chest-shoulder.force"),
    ),
    Entry(
        "occupant",
        "occupant/occupant.toml",
        ("head_cg.filtered_a", "shoulder start.force", "lap start.force", "bag.pressure"),
        ("shoulder start.force", "lap start.force", "bag.pressure", "ribs.travel", "excursion.x"),
    ),
    Entry(
        "pendulum_chain",
        "14_pendulum_chain.toml",
        ("ceiling.angle", "elbow.angle", "eye.cone", "force"),
        ("force", "ceiling.fz"),
    ),
    Entry(
        "test_curve",
        "15_test_curve.toml",
        ("force",),
        ("force", "head_cg.filtered_a"),
        over="head.travel",
    ),
    Entry("bonnet", "bonnet.toml", ("bonnet.force", "hard parts.force"), ("bonnet.force",)),
    Entry("spin", "gallery/spin.toml", ("ball.vx", "ball.wy"), ("force", "ball.wy")),
    Entry("hail", "gallery/hail.toml", ("ring.vz", "n_contact"), ("force", "ring.vz")),
    Entry("cam", "gallery/cam.toml", ("follower.z", "force"), ("force", "follower.z")),
    Entry(
        "bounce",
        "gallery/bounce.toml",
        ("egg.z", "egg.vz", "energy.contact"),
        ("force", "max_penetration"),
    ),
    Entry(
        "spline_belt",
        "gallery/spline_belt.toml",
        ("force", "energy.strain"),
        ("energy.strain",),
    ),
    Entry(
        "pinched_hemisphere",
        "gallery/pinched_hemisphere.toml",
        ("right-shell.force_x", "energy.strain"),
        ("right-shell.force_x", "energy.strain"),
    ),
    Entry(
        "ironing",
        "gallery/ironing.toml",
        ("force_x", "force_z", "energy.friction"),
        ("force_x", "force_z"),
    ),
    Entry("breathing", "gallery/breathing.toml", ("force", "energy.external"), ("force",)),
    Entry("rocker", "gallery/rocker.toml", ("moment_y", "centre_x"), ("force", "moment_y")),
    Entry("bumps", "gallery/bumps.toml", ("area", "n_clusters"), ("force", "area", "n_clusters")),
)
HEAD = """# Gallery

*Made by `docs/draw_gallery.py`, which runs the cases. All are in
the folder `examples`: `contiga run FILE -o out`, or `make run CASE=01_headform`, which first makes
the files that it reads.*

"""


def run(entry: Entry, folder: Path) -> list[tuple[str, str]]:
    """Run a case, keep its picture, and return its numbers: (label, value with unit)."""
    case = ROOT / "examples" / entry.case
    _make_files(case)
    result = cg.run(case, out=folder)
    missing = [c for c in (*entry.columns, *entry.numbers) if c not in result.history]
    if missing:
        raise SystemExit(f"{entry.name}: no columns {missing} in {list(result.history)}")
    if entry.over == "time":
        _curves(result, entry.columns, folder / "curves.png")
    else:
        draw_curves([folder], folder / "curves.png", x=entry.over, y=entry.columns)
    _beside(folder / "peak.png", folder / "curves.png", IMAGES / f"gallery_{entry.name}.png")
    return list(_numbers(result, entry))


def _make_files(case: Path) -> None:
    """The CAD and the meshes of the examples that a case names, if they are not there."""
    text = case.read_text(encoding="utf-8")
    for target in dict.fromkeys(re.findall(r'"generated/(\w+\.\w+)"', text)):
        file = ROOT / "examples" / "generated" / target
        script = ROOT / "examples" / f"make_{file.stem}.py"
        if not file.is_file():
            subprocess.run([sys.executable, str(script), str(file)], check=True)


def _curves(result: Any, columns: tuple[str, ...], target: Path) -> None:
    """Columns of a history one below the other, those of a unit in one axes."""
    from matplotlib.figure import Figure

    units = result.summary["columns"]
    groups = {u: [c for c in columns if units[c] == u] for u in map(units.get, columns)}
    figure = Figure(figsize=(3.8, 4.2), layout="constrained")
    for axes, (unit, names) in zip(
        figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0],
        groups.items(),
        strict=True,
    ):
        for name, colour in zip(names, style.LINES, strict=False):
            known = result.history[name] == result.history[name]  # not NaN
            time, values = result.history["time"][known], result.history[name][known]
            axes.plot(time, values, color=colour, lw=2.0, label=name)
        axes.set_ylabel(f"[{unit}]" if unit else "")
        axes.legend(frameon=False, fontsize=11, loc="best")
        axes.grid(color=style.GRID)
        axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel(f"time [{units['time']}]")
    figure.savefig(target, dpi=140)


def _beside(scene: Path, curves: Path, target: Path) -> None:
    """The picture of the report and the curves in one, with few colours."""
    from PIL import Image

    parts = []
    for path in (scene, curves):
        with Image.open(path) as full:
            picture = full.convert("RGB")
        width = round(picture.width * HEIGHT / picture.height)
        parts.append(picture.resize((width, HEIGHT), Image.Resampling.LANCZOS))
    both = Image.new("RGB", (sum(p.width for p in parts), HEIGHT), "white")
    both.paste(parts[0], (0, 0))
    both.paste(parts[1], (parts[0].width, 0))
    both.quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)
    assert target.stat().st_size < LARGEST, (target, target.stat().st_size)


def _numbers(result: Any, entry: Entry) -> Any:
    units = result.summary["columns"]
    yield "steps", str(result.summary["steps"])
    for column in entry.numbers:
        values = abs(result.history[column])
        yield (
            f"largest `{column}`",
            f"{style.number(values[values == values].max())} {units[column]}",
        )
    energy = result.summary.get("energy") or {}
    if energy:
        yield "energy balance error", f"{100.0 * energy['relative']:.2g} %"
    for sensor, said in (result.summary.get("sensors") or {}).items():
        for criterion, value in said["criteria"].items():
            text = f"{style.number(value['value'])} {value.get('unit', '')}"
            yield f"{criterion} of {sensor}", text.strip()
    folder = read_run(result.out)
    for test in (rated(folder, reference) for reference in references_of(folder)):
        if test.rating is not None:
            score = f"{test.rating.overall:.3f} ({test.rating.grade})"
            yield f"rating of `{test.reference.channel}` by ISO/TS 18571", score


def section(entry: Entry, numbers: list[tuple[str, str]]) -> str:
    """What the page has of a run: what it is, picture, numbers, case."""
    text = (ROOT / "examples" / entry.case).read_text(encoding="utf-8")
    title, about, case = parts_of(text)
    rows = "".join(f"| {label} | {value.strip()} |\n" for label, value in numbers)
    return (
        f"## {title}\n\n{about} [`{entry.case}`](../examples/{entry.case})\n\n"
        f"![{title}: the scene at the peak, and curves](images/gallery_{entry.name}.png)\n\n"
        f"| | |\n|---|---|\n{rows}\n```toml\n{case}```\n"
    )


def parts_of(text: str) -> tuple[str, str, str]:
    """Title, what the comment at its head says, and the rest of a case file."""
    head, _, case = text.partition("\n\n")
    about = " ".join(line.removeprefix("#").strip() for line in head.splitlines())
    title = re.search(r'^title = "(.*)"$', case, re.M)
    assert title is not None
    return title.group(1), about, case


def sections() -> dict[str, str]:
    """Those of the page, by the name of their picture."""
    if not PAGE.is_file():
        return {}
    parts = re.split(r"^(?=## )", PAGE.read_text(encoding="utf-8"), flags=re.M)[1:]
    names = (re.search(r"images/gallery_(\w+)\.png", part) for part in parts)
    return {name.group(1): part for name, part in zip(names, parts, strict=True) if name}


def main(names: list[str]) -> None:
    """Run the cases that are named, all if none are, and write the page."""
    made = sections()
    for entry in ENTRIES:
        if not names or entry.name in names:
            with tempfile.TemporaryDirectory() as folder:
                made[entry.name] = section(entry, run(entry, Path(folder))).rstrip("\n") + "\n\n"
            print(entry.name, flush=True)
    text = HEAD + "".join(made[entry.name] for entry in ENTRIES if entry.name in made)
    PAGE.write_text(text.rstrip("\n") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
