"""Pulses, loads and springs as a case file has them: what they make, what is refused and how."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from pydantic import ValidationError

from contiga.case.load_spec import LoadSpec
from contiga.case.problems import case_error
from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.spec import BY_KIND, Spec
from contiga.case.spring_spec import SpringSpec
from contiga.dynamics import Accelerated, Velocity
from contiga.errors import InputError

CASE_UNITS = ("mm", "kg", "ms")


def spec_of(kind: type[Spec], text: str, folder: Path = Path()) -> Any:
    """The table that `text` is, as the case file reads it."""
    data = tomllib.loads(text)
    try:
        return kind.model_validate(data, context={"folder": folder})
    except ValidationError as error:
        raise case_error(error, data, "case.toml") from error


def test_a_velocity_in_the_units_of_the_case() -> None:
    spec = spec_of(
        VelocitySpec, 'kind = "velocity"\ndirection = "x"\ntable = [[0, 0], [4, 2], [9, 2]]'
    )
    motion = spec.motion_in(CASE_UNITS)
    assert isinstance(motion, Velocity)
    assert motion.span == (0.0, 9.0)
    np.testing.assert_array_equal(motion.displacement(9.0), [14.0, 0.0, 0.0])
    assert spec.describe() == "velocity along x from a table of 3 rows, t = 0 to 9"


def test_an_acceleration_in_g_and_seconds() -> None:
    spec = spec_of(
        AccelerationSpec,
        """
        kind = "acceleration"
        table = [[0, 0, 0, 1], [0.01, 0, 0, 1]]
        unit = "g"
        time_unit = "s"
        velocity = [3, 0, 0]
        smooth = true
        """,
    )
    motion = spec.motion_in(CASE_UNITS)
    assert isinstance(motion, Accelerated)
    assert motion.span == (0.0, 10.0)
    np.testing.assert_allclose(motion.acceleration(5.0), [0, 0, 9.80665e-3], rtol=1e-15)
    np.testing.assert_allclose(motion.velocity(10.0), [3.0, 0, 9.80665e-2], rtol=1e-14)
    metres = spec.motion_in(("m", "kg", "s"))
    assert metres.acceleration(0.005)[2] == 9.80665
    assert spec.describe() == (
        "acceleration in g from a table of 2 rows, t = 0 to 0.01 s, smooth, "
        "at first with the velocity [3.0, 0.0, 0.0]"
    )


def test_a_pulse_from_a_file_that_says_its_units(tmp_path: Path) -> None:
    (tmp_path / "sled.csv").write_text("n,time [s],acc [g]\n1,0,0\n2,0.1,-20\n", encoding="utf-8")
    text = """
        kind = "acceleration"
        file = "sled.csv"
        columns = ["time", "acc"]
        direction = [0, 1, 0]
    """
    spec = spec_of(AccelerationSpec, text, tmp_path)
    motion = spec.motion_in(CASE_UNITS)
    np.testing.assert_allclose(motion.acceleration(100.0), [0, -20 * 9.80665e-3, 0], rtol=1e-14)
    np.testing.assert_allclose(motion.velocity(100.0), [0, -9.80665, 0], rtol=1e-14)
    assert spec.describe().endswith("sled.csv")


@pytest.mark.parametrize(
    ("spec", "motion"), [(VelocitySpec, Velocity), (AccelerationSpec, Accelerated)]
)
@pytest.mark.parametrize("smooth", [True, False])
def test_pulses_are_smooth_on_request(spec, motion, smooth) -> None:
    table = [[0, 0], [1, 3], [4, 1], [5, 1]]
    data = {"kind": spec.model_fields["kind"].default, "direction": "y", "table": table}
    actual = spec.model_validate(data | {"smooth": smooth}).motion_in(CASE_UNITS)
    expected = motion(table, direction="y", smooth=smooth)
    for t in (0.4, 2.5, 4.5):
        np.testing.assert_array_equal(actual.displacement(t), expected.displacement(t))
        np.testing.assert_array_equal(actual.acceleration(t), expected.acceleration(t))


def test_pulses_are_told_apart_by_their_kind() -> None:
    from pydantic import TypeAdapter

    either = TypeAdapter(Annotated[VelocitySpec | AccelerationSpec, BY_KIND])
    table = {"kind": "velocity", "direction": "x", "table": [[0, 0], [1, 1]]}
    assert isinstance(either.validate_python(table), VelocitySpec)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "case.toml: must have exactly one of the keys table or file"),
        ('table = [[0, 1]]\nfile = "a.csv"', "no such file"),
        ("table = [[0, 0], [1, 1]]", "case.toml: direction: rows [t, v] need a direction"),
        (
            'table = [[0, 0]]\ndirection = "x"',
            "case.toml: table: a table must have 2 columns and at least 2 rows",
        ),
        ('table = [[0, 0], [1]]\nunit = "km/h"\ndirection = "x"', "all of the same length"),
        ('table = []\ndirection = "x"', "2 columns and at least 2 rows"),
        ('table = [[1, 0], [0, 1]]\ndirection = "x"', "the times go back or repeat at row 1"),
        ('table = [[0, 0], [1, "a"]]\ndirection = "x"', "table[1][1]: must be a number"),
        ('table = [[0, 0], [1, inf]]\ndirection = "x"', "table[1][1]: must be finite"),
        (
            'table = [[0, 0], [1, 1]]\ndirection = "x"\nunit = "g"',
            "unit: not a unit of velocity; found 'g'",
        ),
        ('table = [[0, 0], [1, 1]]\ndirection = "x"\ntime_unit = "m"', "time_unit: not a unit of"),
        ('table = [[0, 0], [1, 1]]\ndirection = "w"', "direction: not an axis"),
        ('table = [[0, 0], [1, 1]]\ncolumns = ["t", "v"]', "columns: only a file has columns"),
        ("table = [[0, 0], [1, 1]]\nvelocity = [0, 0, 0]", "velocity: unknown key"),
    ],
)
def test_a_wrong_pulse_is_refused_at_its_key(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        spec_of(VelocitySpec, 'kind = "velocity"\n' + text)
    assert message in str(caught.value)


def test_a_wrong_file_is_refused_at_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t [ms], a [g]\n0, 0\n1, one\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"case\.toml: .*a\.csv:3: a row does not have a number"):
        spec_of(
            AccelerationSpec, 'kind = "acceleration"\nfile = "a.csv"\ndirection = "x"', tmp_path
        )


def test_a_load_over_time() -> None:
    spec = spec_of(
        LoadSpec,
        """
        body = "head"
        force = [[0, 0, 0, 0], [2, 0, 0, 8]]
        moment = [1, 0, 0]
        at = [0, 1, 2]
        follow = true
        """,
    )
    load = spec.instance
    np.testing.assert_array_equal(load.force_at(1.0), [0, 0, 4])
    np.testing.assert_array_equal(load.moment_at(1.0), [1, 0, 0])
    assert (load.body, load.follow, load.span) == ("head", True, (0.0, 2.0))
    assert spec.describe() == (
        "force of 2 rows over time and moment [1.0, 0.0, 0.0] on head at [0.0, 1.0, 2.0], "
        "turning with it"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('body = "a"', "case.toml: force: a load needs a force or a moment"),
        ("force = [1, 0, 0]", "case.toml: body: is missing"),
        ('body = "a"\nforce = 3', "force: must be a vector, or rows over time; found 3"),
        ('body = "a"\nforce = [1, [2], 3]', "force: must be a vector, or rows over time"),
        ('body = "a"\nforce = [[0, 1, 1, true], [1, 1, 1, 1]]', "force: must be finite numbers"),
        ('body = "a"\nforce = [inf, 0, 0]', "force: must be finite numbers, and entry 0 is not"),
        (f'body = "a"\nforce = [1{"0" * 400}, 0, 0]', "force: must be finite numbers"),
        ('body = "a"\nforce = [1, 0]', "force: must be three finite numbers"),
        ('body = "a"\nforce = []', "force: must be three finite numbers"),
        (
            'body = "a"\nforce = [[0, 1, 0, 0]]',
            "force: a table must have 4 columns and at least 2 rows",
        ),
        ('body = "a"\nmoment = [0, 0, 1]\nat = [0, 0, 0]', "at: a moment has no point"),
        ('body = "a"\nforce = [0, 0, 1]\nsmooth = true', "smooth: there are no rows"),
        ('body = "a"\nforces = [0, 0, 1]', "forces: unknown key"),
    ],
)
def test_a_wrong_load_is_refused_at_its_key(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        spec_of(LoadSpec, text)
    assert message in str(caught.value)
    assert "2 things" not in str(caught.value)


def test_a_belt_with_a_damper() -> None:
    spec = spec_of(
        SpringSpec,
        """
        name = "belt"
        between = ["dummy", "ground"]
        at = [[0, 0, 0], [4, 3, 0]]
        curve = [[0, 0], [10, 5]]
        unloading = { points = [[0, 0], [10, 1]], extrapolation = "constant" }
        hysteresis_slope = 2
        damping = 0.5
        length = 4
        """,
    )
    spring = spec.instance
    state = spring.start(spring.at, np.zeros((2, 3)))
    assert (spring.name, spring.between) == ("belt", ("dummy", "ground"))
    assert (state.length, state.force, spring.damping) == (5.0, 0.5, 0.5)
    assert spring.hysteresis is not None
    assert spring.hysteresis.slope == 2.0
    assert "unloading 2 points" in spec.describe()
    assert spec.describe().endswith("damping 0.5; length 4 at rest")


def test_a_number_is_a_stiffness_and_a_damper_needs_no_curve() -> None:
    ends = 'between = ["a", "b"]\nat = [[0, 0, 0], [1, 0, 0]]\n'
    spring = spec_of(SpringSpec, ends + "curve = 7").instance
    assert spring.start([[0, 0, 0], [3, 0, 0]], np.zeros((2, 3))).force == 14.0
    assert spring.name == "a-b"
    damper = spec_of(SpringSpec, ends + "damping = 7").instance
    assert damper.curve is None


ENDS = "at = [[0, 0, 0], [1, 0, 0]]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ENDS + 'between = ["a", "b"]', "case.toml: curve: a spring needs a curve or a damping"),
        ('between = ["a", "b"]\ncurve = 1', "at: is missing"),
        (ENDS + "curve = 1", "between: is missing"),
        (ENDS + 'between = ["a", "a"]\ncurve = 1', "between: both ends are of one body"),
        (ENDS + 'between = ["ground", "ground"]\ncurve = 1', "both ends are on the ground"),
        (ENDS + 'between = ["a"]\ncurve = 1', "between: must be two names"),
        ('at = [[1, 1, 1], [1, 1, 1]]\nbetween = ["a", "b"]\ncurve = 1', "at: the two points are"),
        ('at = [[1, 1, 1]]\nbetween = ["a", "b"]\ncurve = 1', "at: must be two finite points"),
        (ENDS + 'between = ["a", "b"]\ncurve = "k"', "curve: must be a curve"),
        (
            ENDS + 'between = ["a", "b"]\ncurve = [[0, 0]]',
            "curve: a table must have 2 columns and at least 2 rows",
        ),
        (ENDS + 'between = ["a", "b"]\ncurve = 1\nunloading = 2', "hysteresis_slope: is missing"),
        (ENDS + 'between = ["a", "b"]\nunloading = 2', "curve: is missing"),
        (ENDS + 'between = ["a", "b"]\ndamping = -2', "damping: is too small; found -2"),
        (ENDS + 'between = ["a", "b"]\ncurve = 1\nlength = -2', "length: is too small; found -2"),
        (ENDS + 'between = ["a", "b"]\ncurve = 1\nname = ""', "name: is not a name"),
    ],
)
def test_a_wrong_spring_is_refused_at_its_key(text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        spec_of(SpringSpec, text)
    assert message in str(caught.value)
