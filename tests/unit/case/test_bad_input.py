"""Bad input as a table: each wrong case gets one message with what, where and what is allowed.

A row is a name, what is put into a good case in place of what, and pieces of the message.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.case.schema import load_case
from contiga.errors import GeometryError, InputError, UnitError

from .conftest import AREA, FIXED, GEOMETRY, GOOD, LAW, MOVE, POINTS, refused, swap

TABLE = [
    # ---- keys
    swap(
        "unknown key at the top", "[output]", "[ouput]", "ouput: unknown key", "'output'", "units"
    ),
    swap("unknown key in time", "step = 1.0", "stp = 1.0", "time.stp: unknown key", "'step'"),
    swap(
        "unknown key in a contact",
        'master = "plate"',
        'mastr = "plate"',
        "contact[0].mastr: unknown key",
        "Did you mean 'master'?",
    ),
    swap(
        "unknown key in a law",
        LAW,
        '{ kind = "force", curv = 1.0 }',
        "contact[0].law.curv: unknown key",
        "'curve'",
    ),
    swap(
        "unknown key in the second table of a list",
        FIXED,
        '[[body]]\nname = "b"\ngeometry = { shape = "plane" }\nnam = 1',
        "body[1].nam: unknown key",
    ),
    swap("missing table", '[units]\nlength = "mm"\nmass = "kg"\ntime = "ms"', "", "units: is miss"),
    swap("missing key", "end = 13.0", "", "time.end: is missing"),
    swap("no law", f"law = {LAW}", "", "contact[0].law: is missing"),
    # ---- types
    swap("text for a number", "step = 1.0", 'step = "1"', "time.step: must be a number", "'1'"),
    swap("truth for a number", "step = 1.0", "step = true", "time.step: must be a number", "True"),
    swap("half a count", "every = 1", "every = 1.5", "output.every: must be a whole number; found"),
    swap("number for text", '"Cloud pressed into a plate"', "3", "title: must be text in quotes"),
    swap("law is a number", LAW, "3", "contact[0].law: must be a table with a kind; found 3"),
    swap("geometry is a file name", GEOMETRY, '"plate.step"', "body[0].geometry: must be a table"),
    swap("not a number", "end = 13.0", "end = nan", "time.end: must be finite; found nan"),
    swap("too many points", "nu = 5", "nu = 1000000000", "points.sample.nu: must be", "5000000"),
    swap("too many points both ways", "nu = 5, nv = 6", "nu = 90000, nv = 90000", "sample.n"),
    swap(
        "too many random points",
        POINTS,
        '{ random = { shape = "plane", n = 1000000000 } }',
        "slave[0].points.random.n: is too large; found 1000000000",
    ),
    swap(
        "too many bars",
        POINTS,
        "{ coordinates = [[0, 0, 0], [1, 0, 0]], segments = 1000000000 }",
        "slave[0].points.segments: is too large",
    ),
    swap("a late end", "end = 13.0", "end = 1e12", "time.step: makes 1e+12 steps", "of the end"),
    swap(
        "a late end of short steps",
        "end = 13.0\nstep = 1.0",
        'end = 1e12\nstep = "auto"\nlargest = 1.0',
        "time.largest: makes 1e+12 steps or more",
    ),
    swap("too many steps between fields", "every = 1", "every = 0", "output.every: is too", ">= 1"),
    swap("no time between fields", "every = 1", "interval = 0.0", "output.interval: is too small"),
    swap(
        "steps and time between fields",
        "every = 1",
        "every = 1\ninterval = 2.0",
        "output.interval: is beside `every`",
    ),
    swap(
        "table cell is text",
        MOVE,
        '{ kind = "translate", table = [[0, 0, 0, 0], [13, "a", 0, 0]] }',
        "slave[0].motion.table[1][1]: must be a number; found 'a'",
    ),
    swap(
        "single brackets around a body",
        "[[body]]",
        "[body]",
        "body: must be a list of tables",
        "Write [[body]] in double brackets",
    ),
    # ---- choices
    swap(
        "unknown law",
        LAW,
        '{ kind = "stres" }',
        "contact[0].law.kind: unknown kind; found 'stres'",
        'allowed: "force", "stress", "penalty", "adaptive"',
        "Did you mean 'stress'?",
    ),
    swap("law without kind", LAW, "{ curve = 1 }", "contact[0].law.kind: is missing", '"force"'),
    swap(
        "unknown area",
        AREA,
        '{ kind = "hul" }',
        "contact[0].area.kind: unknown kind; found 'hul'",
        '"constant", "tributary"',
    ),
    swap(
        "unknown motion",
        FIXED,
        'motion = { kind = "move" }',
        "body[0].motion.kind: unknown kind",
        '"fixed", "translate", "rotate", "poses", "combine"',
    ),
    swap(
        "a body cannot follow a series",
        FIXED,
        'motion = { kind = "series", files = "a*" }',
        "body[0].motion.kind: unknown kind; found 'series'",
    ),
    swap(
        "unknown search",
        'slave = "cylinder"',
        'slave = "cylinder"\nsearch = "intersect"',
        "contact[0].search: unknown value; found 'intersect'",
        'allowed: "intersection", "penetration"',
        "Did you mean 'intersection'?",
    ),
    swap("unknown field", "every = 1", 'fields = ["mises"]', "output.fields[0]: unknown value"),
    swap("unknown format", "every = 1", 'formats = ["vtk"]', "output.formats[0]: unknown value"),
    # ---- units
    swap("no unit at all", '"mm"', '"bananas"', "units.length: not a known unit", kind=UnitError),
    swap(
        "unit of another dimension",
        '"ms"',
        '"mm"',
        "units.time: not a unit of time; found 'mm'",
        "s, ms",
        kind=UnitError,
    ),
    # ---- time
    swap(
        "end before start", "end = 13.0", "end = -1.0", "time.end: the end must come after", "> 0"
    ),
    swap("end at start", "end = 13.0", "end = 5.0\nstart = 5.0", "time.end: the end must come"),
    swap("no step", "step = 1.0", "step = 0", "time.step: is too small; found 0", "allowed: > 0"),
    swap("step back", "step = 1.0", "step = -0.5", "time.step: is too small; found -0.5"),
    swap("step too long", "step = 1.0", "step = 14.0", "time.step: the step is longer", "most 13"),
    # ---- names
    swap(
        "master not defined",
        'master = "plate"',
        'master = "plat"',
        "contact[0].master: no body of this name is defined; found 'plat'",
        'allowed: "plate"',
        "Did you mean 'plate'?",
    ),
    swap(
        "slave as master",
        'master = "plate"',
        'master = "cylinder"',
        "contact[0].master: no body",
        "'cylinder' is a slave",
    ),
    swap("slave not defined", 'slave = "cylinder"', 'slave = "x"', "contact[0].slave: no slave"),
    swap(
        "two bodies of one name",
        FIXED,
        '[[body]]\nname = "plate"\ngeometry = { shape = "plane" }',
        "body[1].name: the name is used 2 times; found 'plate'",
    ),
    swap(
        "body and slave of one name",
        'name = "cylinder"',
        'name = "plate"',
        "slave[0].name: a body and a slave must not have the same name",
    ),
    swap("no name", 'name = "plate"', 'name = ""', "body[0].name: is not a name; found ''"),
    swap("comma in a name", 'name = "plate"', 'name = "a,b"', "body[0].name: is not a name"),
    # ---- curves and tables
    swap(
        "abscissae go back",
        LAW,
        '{ kind = "force", curve = [[0, 0], [2, 1], [1, 2]] }',
        "contact[0].law.curve: the values of x go back or repeat at row 2; found [2.0, 1.0]",
        "x strictly increasing",
    ),
    swap(
        "one point is no curve",
        LAW,
        '{ kind = "force", curve = [[0, 0]] }',
        "contact[0].law.curve: a table must have 2 columns and at least 2 rows; found (1, 2)",
    ),
    swap(
        "three columns in a curve",
        LAW,
        '{ kind = "force", curve = [[0, 0, 0], [1, 1, 1]] }',
        "contact[0].law.curve: a table must have 2 columns and at least 2 rows; found (2, 3)",
    ),
    swap(
        "text as a curve", LAW, '{ kind = "force", curve = "steel" }', "contact[0].law.curve: must"
    ),
    swap(
        "text in a curve",
        LAW,
        '{ kind = "force", curve = [[0, 0], [1, "b"]] }',
        "contact[0].law.curve[1][1]: must be a number; found 'b'",
    ),
    swap(
        "unknown extrapolation",
        LAW,
        '{ kind = "force", curve = { points = [[0, 0], [1, 1]], extrapolation = "lin" } }',
        "contact[0].law.curve.extrapolation: unknown value; found 'lin'",
        '"linear", "constant", "error"',
    ),
    swap(
        "curve wrong in a damped law",
        LAW,
        '{ kind = "stress", elastic = 1, thickness = 1, damping_curve = [[0, 0], [0, 1]] }',
        "contact[0].law.damping_curve: the values of x go back or repeat at row 1",
    ),
    swap(
        "thickness of zero",
        LAW,
        '{ kind = "stress", elastic = 1, thickness = 0 }',
        "contact[0].law.thickness: is too small; found 0",
    ),
    swap(
        "times of a motion go back",
        MOVE,
        '{ kind = "translate", table = [[1, 0, 0, 0], [0, 0, 0, 0]] }',
        "slave[0].motion.table: the times go back or repeat at row 1; found [1.0, 0.0]",
    ),
    swap(
        "columns missing in a motion",
        MOVE,
        '{ kind = "translate", table = [[0, 0, 0]] }',
        "slave[0].motion.table: a table must have 4 columns",
        "[t, dx, dy, dz]",
    ),
    swap(
        "axis of length zero",
        FIXED,
        'motion = { kind = "rotate", axis = [0, 0, 0], table = [[0, 0]] }',
        "body[0].motion.axis: an axis must not be the zero vector",
        kind=InputError,
    ),
    swap(
        "poses from nowhere",
        FIXED,
        'motion = { kind = "poses" }',
        "body[0].motion: must have exactly one of the keys file or table",
    ),
    # ---- hysteresis and friction
    swap(
        "unloading above loading",
        LAW,
        '{ kind = "stress", elastic = 1, thickness = 1, unloading = 2, hysteresis_slope = 5 }',
        "contact[0].law.unloading: the unloading curve is above the loading curve at 1",
    ),
    swap(
        "unloading without its slope",
        LAW,
        '{ kind = "force", curve = 2, unloading = 1 }',
        "contact[0].law.hysteresis_slope: is missing",
        "Give both",
    ),
    swap(
        "a slope below that of the curve",
        LAW,
        '{ kind = "force", curve = 2, unloading = 1, hysteresis_slope = 1.5 }',
        "contact[0].law.hysteresis_slope: must not be below the steepest slope",
        "2 or above",
    ),
    swap(
        "a share that is none",
        LAW,
        '{ kind = "force", curve = 2, share = "all" }',
        "contact[0].law.share: unknown value; found 'all'",
    ),
    swap(
        "combined with unloading",
        f"law = {LAW}",
        'type = "combined"\nmaster_law = { kind = "stress", elastic = 1, thickness = 1 }\n'
        'law = { kind = "stress", elastic = 1, unloading = 1, hysteresis_slope = 5 }',
        "contact[0].law.unloading: combined contact balances elastic stresses",
    ),
    swap(
        "friction of another kind",
        "area =",
        'friction = { kind = "coulom", static = 0.4 }\narea =',
        "contact[0].friction.kind: unknown kind; found 'coulom'",
        '"coulomb", "viscous-regularised"',
    ),
    swap(
        "static friction below the dynamic",
        "area =",
        'friction = { kind = "coulomb", static = 0.2, dynamic = 0.4 }\narea =',
        "contact[0].friction.static: the static coefficient must not be below the dynamic one",
    ),
    swap(
        "a negative coefficient",
        "area =",
        'friction = { kind = "coulomb", static = -0.2 }\narea =',
        "contact[0].friction.static: is too small; found -0.2",
    ),
    swap(
        "viscous friction without a speed",
        "area =",
        'friction = { kind = "viscous-regularised", coefficient = 0.2, speed = 0 }\narea =',
        "contact[0].friction.speed: is too small; found 0",
    ),
    # ---- combined contact
    swap(
        "combined without the master's law",
        "area =",
        'type = "combined"\narea =',
        "contact[0].master_law: is missing",
        "needs both laws",
    ),
    swap(
        "combined with the force law",
        "area =",
        'type = "combined"\nmaster_law = { kind = "stress", elastic = 1, thickness = 1 }\narea =',
        "contact[0].law: combined contact balances the stresses",
        "'ForceLaw'",
        "StressLaw",
    ),
    swap(
        "a master's law alone",
        "area =",
        'master_law = { kind = "stress", elastic = 1, thickness = 1 }\narea =',
        'contact[0].master_law: only a contact of type "combined"',
    ),
    swap(
        "the master's own thickness missing",
        f"law = {LAW}",
        'type = "master"\nlaw = { kind = "stress", elastic = 1 }',
        "contact[0].law.thickness: is missing",
        "not the slave's",
    ),
    # ---- numbers nobody means
    *(
        swap(f"steps of {step}", "step = 1.0", f"step = {step}", "time.step: makes", "at most")
        for step in ("1e-300", "1e-320", "1e-9")
    ),
    swap("a time beyond all", "end = 13.0", "end = 1" + 34 * "0", "time.step: makes 1e+34 steps"),
    swap(
        "steps lost in rounding",
        "end = 13.0",
        "start = 1e17\nend = 1.0000000000000003e17",
        "time.step: is below the rounding error",
    ),
    swap(
        "a number of many digits",
        "end = 13.0",
        "end = 1" + 400 * "0",
        "time.end: must be a number; found 'a number of 401 digits'",
    ),
    swap(
        "a size of many digits",
        "width = 2.0",
        "width = 1" + 400 * "0",
        "body[0].geometry.width: a size must be positive; found 'a number of 401 digits'",
        kind=GeometryError,
    ),
    swap(
        "a place of many digits",
        GEOMETRY,
        f'{{ shape = "bumpy_plate", centre = [0, 0, 1{"0" * 400}] }}',
        "body[0].geometry",
        kind=InputError,
    ),
    swap(
        "a seed below zero",
        POINTS,
        "{ random = { box = [[0, 0, 0], [1, 1, 1]], n = 5, seed = -1 } }",
        "slave[0].points.random.seed: is too small",
    ),
    swap(
        "a curve that is a number",
        GEOMETRY,
        '{ shape = "extruded", curve = 5, direction = [0, 0, 1] }',
        "body[0].geometry.curve: must be a curve; found 5",
    ),
    # ---- options that do not go together
    swap(
        "held where no path is followed",
        AREA,
        AREA + '\nsearch = "penetration"\nthrough = "hold"',
        "contact[0].through: a search by",
    ),
    swap("a depth for nothing", AREA, AREA + "\ndepth = 1.0", "contact[0].depth: only a search by"),
    swap(
        "a report without a history",
        "every = 1",
        'formats = ["vtkhdf"]',
        "output.formats: a report needs the format",
        "set report = false",
    ),
    # ---- TOML itself
    swap("not TOML", "end = 13.0", "end = ", "is not valid TOML", "line 7"),
    swap("a key twice", "end = 13.0", "end = 13.0\nend = 14.0", "is not valid TOML", "line 8"),
]


@pytest.mark.parametrize(("old", "new", "pieces", "kind"), TABLE)
def test_a_wrong_case_is_refused_with_its_key(
    tmp_path: Path, old: str, new: str, pieces: tuple[str, ...], kind: type[InputError]
) -> None:
    refused(tmp_path, old, new, pieces, kind)


def test_the_good_case_is_good(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(GOOD, encoding="utf-8")
    assert load_case(path).file == path
