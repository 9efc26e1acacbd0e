"""Bad geometry, points and files in a case, as a table: rows as in `test_bad_input`."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.errors import FileError, InputError

from .conftest import FIXED, GEOMETRY, MOVE, POINTS, refused, swap

TABLE = [
    # ---- geometry
    swap(
        "unknown shape",
        GEOMETRY,
        '{ shape = "sphre" }',
        "body[0].geometry.shape: there is no such surface; found 'sphre'",
        "bumpy_plate, cone, cylinder",
        "Did you mean 'sphere'?",
    ),
    swap("a curve as a body", GEOMETRY, '{ shape = "circle" }', "geometry.shape: there is no such"),
    swap(
        "unknown argument of a shape",
        GEOMETRY,
        '{ shape = "sphere", raduis = 1 }',
        "body[0].geometry.raduis: unknown key",
        "Did you mean 'radius'?",
    ),
    swap(
        "argument of a shape missing",
        GEOMETRY,
        '{ shape = "extruded", direction = [0, 0, 1] }',
        "body[0].geometry.curve: is missing; extruded needs it",
    ),
    swap(
        "a shape that cannot be",
        GEOMETRY,
        '{ shape = "sphere", radius = -1 }',
        "body[0].geometry.radius: a size must be positive; found -1",
        kind=InputError,
    ),
    swap(
        "a shape in a shape that cannot be",
        GEOMETRY,
        '{ shape = "extruded", direction = [0, 0, 1], curve = { shape = "arc", radius = 0 } }',
        "body[0].geometry.curve.radius: a size must be positive; found 0",
        kind=InputError,
    ),
    swap(
        "geometry of no kind",
        GEOMETRY,
        '{ fle = "a.step" }',
        "body[0].geometry: must have exactly one of the keys file, mesh, shape, nurbs, profile",
        "Did you mean 'file'?",
    ),
    swap(
        "geometry of two kinds",
        GEOMETRY,
        '{ file = "a.step", shape = "plane" }',
        "body[0].geometry: must have exactly one of the keys",
        "found 'file, shape'",
    ),
    swap(
        "knots that decrease",
        GEOMETRY,
        "{ nurbs = { degrees = [1, 1], knots = [[0, 0, 1, 0.5], [0, 0, 1, 1]],"
        " control_points = [[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]] } }",
        "body[0].geometry",
        "knots",
        "decrease",
        kind=InputError,
    ),
    swap(
        "a weight of zero",
        GEOMETRY,
        "{ nurbs = { degrees = [1, 1], knots = [[0, 0, 1, 1], [0, 0, 1, 1]],"
        " weights = [[1, 1], [1, 0]],"
        " control_points = [[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]] } }",
        "body[0].geometry",
        "weights",
        kind=InputError,
    ),
    swap(
        "a transform of two steps in one",
        GEOMETRY,
        '{ shape = "plane", transform = [{ translate = [0, 0, 1], scale = 2.0 }] }',
        "body[0].geometry.transform[0]: must have exactly one of the keys translate, rotate or sc",
    ),
    swap("no bodies", "[[body]]", "[[bodies]]", "bodies: unknown key", "'body'"),
    # ---- points
    swap("points of no kind", POINTS, "{ n = 4 }", "slave[0].points: must have exactly one of"),
    swap(
        "one point along u",
        POINTS,
        '{ sample = { shape = "plane", nu = 1, nv = 3 } }',
        "slave[0].points.sample.nu: is too small; found 1; allowed: >= 2",
    ),
    swap(
        "no points",
        POINTS,
        "{ random = { box = [[0,0,0],[1,1,1]], n = 0 } }",
        "slave[0].points.random.n: is too small",
    ),
    swap(
        "a box inside out",
        POINTS,
        "{ random = { box = [[0,0,0],[1,-1,1]], n = 3 } }",
        "slave[0].points.random",
        "lower corner of a box",
        kind=InputError,
    ),
    swap(
        "a coordinate that is not finite",
        POINTS,
        "{ coordinates = [[0, 0, inf]] }",
        "slave[0].points.coordinates[0][2]: must be finite; found inf",
    ),
    swap(
        "two coordinates",
        POINTS,
        "{ coordinates = [[0, 0]] }",
        "slave[0].points.coordinates[0]: has the wrong length; found 2; allowed: at least 3",
    ),
    # ---- files
    swap(
        "missing geometry file",
        GEOMETRY,
        '{ file = "none.step" }',
        "body[0].geometry.file: no such file; found 'none.step'",
        "looked for",
        kind=FileError,
    ),
    swap(
        "folder as a mesh",
        POINTS,
        '{ file = "." }',
        "slave[0].points.file: this is a folder",
        kind=FileError,
    ),
    swap(
        "no file of a series",
        MOVE,
        '{ kind = "series", files = "step_*.vtu" }',
        "slave[0].motion.files: ",
        "no file fits the pattern; found 'step_*.vtu'",
        kind=FileError,
    ),
    swap(
        "missing pose file",
        FIXED,
        'motion = { kind = "poses", file = "poses.csv" }',
        "body[0].motion.file: no such file; found 'poses.csv'",
        kind=FileError,
    ),
    swap(
        "a name too long for a file",
        GEOMETRY,
        f'{{ file = "{"a" * 5000}.step" }}',
        "body[0].geometry.file: is not a file name",
        kind=FileError,
    ),
    swap(
        "a character no file name has",
        GEOMETRY,
        '{ file = "a\\u0000b.step" }',
        "body[0].geometry.file: is not a file name",
        kind=FileError,
    ),
    *(
        swap(
            f"series of files {pattern!r}",
            MOVE,
            f'{{ kind = "series", files = "{pattern}" }}',
            "slave[0].motion.files: is not a file name pattern",
            kind=FileError,
        )
        for pattern in ("", "a**b", "a\\u0000b", "**", "x/**", "a**/b_*.vtu")
    ),
]


@pytest.mark.parametrize(("old", "new", "pieces", "kind"), TABLE)
def test_wrong_geometry_points_and_files_are_refused_with_their_key(
    tmp_path: Path, old: str, new: str, pieces: tuple[str, ...], kind: type[InputError]
) -> None:
    refused(tmp_path, old, new, pieces, kind)
