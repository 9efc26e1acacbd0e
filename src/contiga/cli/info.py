"""Describe a file for ``contiga info``: rows of a label and a text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.errors import InputError

if TYPE_CHECKING:
    from contiga.records import FloatArray

Row = tuple[str, str]

_POWERS = {"size": "", "area": "²"}
"""Power of the unit of length, by key of a summary."""


def rows_of(file: Path, *, faces: bool = False) -> Iterator[Row]:
    """Yield rows (label, text) about a CAD file or a mesh; `faces` adds each face of CAD.

    The rows of a CAD file come from the cache if it was described before, else they are cached.

    Raises
    ------
    InputError
        The file cannot be read, or it is a mesh and `faces` is set.
    """
    from contiga.io.cad.formats import SUFFIXES, expect_cad

    if file.suffix.lower() in SUFFIXES:
        expect_cad(file)
        from contiga.io.cad.read_cache import cached_answer

        question = "info and faces" if faces else "info"
        yield from cached_answer(file, question, __file__, lambda: list(_cad_rows(file, faces)))
    elif faces:
        raise InputError(
            "only CAD has faces to be listed",
            where=str(file),
            found="--faces",
            allowed=" ".join(SUFFIXES),
        )
    else:
        from contiga.io.mesh.read_master import master_of
        from contiga.io.mesh.read_mesh import read_mesh
        from contiga.slaves.mesh_summary import mesh_summary

        mesh = read_mesh(file)
        yield from _summary(mesh_summary(mesh))
        if mesh.facets is not None and len(mesh.facets):
            yield from master_of(mesh, where=str(file)).condition_rows()


def _cad_rows(file: Path, faces: bool) -> Iterator[Row]:
    """Yield the rows of a CAD file: the whole, its condition, two for each part, then its faces."""
    from contiga.io.cad.cad_parts import read_cad_file

    cad = read_cad_file(file)
    from contiga.geometry.face_box import bounds_of  # loaded while the file is read
    from contiga.geometry.trim_area import patch_areas
    from contiga.masters.body_summary import body_summary

    yield from _summary(body_summary(cad.body))
    yield from cad.body.condition_rows()
    if cad.message:
        yield "solids", cad.message
    for part in cad.parts:
        body = part.body
        volume = body.volume() if body.closed else 0.0
        side = "inward, around a cavity" if volume < 0.0 else "outward"
        numbers = [face.number for face in part.faces]
        face_text = f"face{'' if len(numbers) == 1 else 's'} {_ranges(numbers)}"
        texts = [
            *([part.title] if part.title else []),
            *([f"loose {face_text}"] if part.kind == "faces" else [part.kind, face_text]),
            f"closed, normals {side}, volume {_with_unit(body.unit, abs(volume), '³')}"
            if body.closed
            else "open",
            f"area {_with_unit(body.unit, body.area(), '²')}",
            *([] if part.colour is None else [part.colour]),
        ]
        yield f"part {part.number}", ", ".join(texts)
        yield "", _box(body.bounds(), body.unit)
    if not faces:
        return
    body = cad.body
    labels = {face.number: (face, part) for part in cad.parts for face in part.faces}
    areas = patch_areas(body)
    for k, number in enumerate(cad.numbers):
        face, part = labels[number]
        texts = [
            face.kind,
            *(label for label in (face.name, face.colour) if label is not None),
            f"area {_with_unit(body.unit, float(areas[k]), '²')}",
            f"part {part.number}",
            _box(bounds_of([body.patches[k]], [body.trims[k]]), body.unit),
        ]
        yield f"face {number}", ", ".join(texts)


def _box(bounds: FloatArray, unit: str | None) -> str:
    """Return the ranges of a box (2, 3) along x, y and z as a text."""
    low, high = bounds.tolist()
    spans = zip("xyz", low, high, strict=True)
    return ", ".join(f"{axis} {a:.6g} to {_with_unit(unit, b)}" for axis, a, b in spans)


def _ranges(numbers: Sequence[int]) -> str:
    """Return integers, in their order, as a text; runs of successive ones as "3-7"."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1][1:] = [number]
        else:
            runs.append([number])
    return ", ".join("-".join(map(str, run)) for run in runs)


def _summary(summary: dict[str, Any]) -> Iterable[Row]:
    """Yield the rows of a summary: bounds as a row an axis, lists of tables as a row each.

    Entries that are None or empty are left out.
    """
    unit = summary.get("unit")
    for key, value in summary.items():
        label = key.replace("_", " ")
        if key == "bounds":
            for axis, low, high in zip("xyz", *value, strict=True):
                yield axis, f"{low:.6g} to {high:.6g}, {_with_unit(unit, high - low)} long"
        elif key in _POWERS and isinstance(value, float):
            yield label, _with_unit(unit, value, _POWERS[key])
        elif key == "thickness" and value is not None:
            yield label, f"{value[0]:.6g} to {_with_unit(unit, value[1])}"
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for k, entry in enumerate(value):
                yield (label if k == 0 else ""), _as_text(entry)
        elif value is not None and value not in ([], {}, ""):
            yield label, _as_text(value)


def _with_unit(unit: str | None, value: float, power: str = "") -> str:
    """Return a number with its unit, if there is one."""
    return f"{value:.6g}" if unit is None else f"{value:.6g} {unit}{power}"


def _as_text(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{str(k).replace('_', ' ')}: {_as_text(v)}" for k, v in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_as_text(v) for v in value)
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value)
