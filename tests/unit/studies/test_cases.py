"""Cases of a study: grids in order, tables, samples that cover their box, rules."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from contiga.errors import CaseError, FileError, InputError, UnitError
from contiga.studies.cases import cases_of, check_keys, shown_value

from .conftest import CASE, STUDY, study_from

RANGED = """
base = "case.toml"
collect = ["steps"]
sample = {{ kind = "{kind}", count = {count}, seed = 3 }}
[[variable]]
name = "radius"
key = "body.ball.geometry.radius"
low = 1.0
high = 100.0
scale = "log"
[[variable]]
name = "speed"
key = "body.ball.motion.velocity[2]"
low = -5.0
high = -1.0
"""


def test_a_grid_is_every_pair_the_last_variable_fastest(folder: Path) -> None:
    cases = cases_of(study_from(STUDY, folder))
    assert [case.values for case in cases] == [
        {"speed": speed, "step": step} for speed in (-1.0, -2.0) for step in (0.5, 0.25)
    ]
    assert [case.number for case in cases] == [1, 2, 3, 4]
    assert cases[1].settings == {"body.ball.motion.velocity[2]": -1.0, "time.step": 0.25}


def test_values_between_two_ends_are_even_on_their_scale(folder: Path) -> None:
    text = STUDY.replace(
        "values = [0.5, 0.25]", 'low = 0.125\nhigh = 0.5\ncount = 3\nscale = "log"'
    )
    values = [case.values["step"] for case in cases_of(study_from(text, folder))[:3]]
    assert values == pytest.approx([0.125, 0.25, 0.5], rel=1e-15)
    text = STUDY.replace("values = [0.5, 0.25]", "low = 1.0\nhigh = 4.0\ncount = 4\nwhole = true")
    values = [case.values["step"] for case in cases_of(study_from(text, folder))[:4]]
    assert values == [1, 2, 3, 4]
    assert all(isinstance(value, int) for value in values)


@pytest.mark.parametrize("kind", ["latin-hypercube", "sobol"])
def test_samples_have_one_point_in_each_layer(kind: str, folder: Path) -> None:
    cases = cases_of(study_from(RANGED.format(kind=kind, count=16), folder))
    radius = np.array([case.values["radius"] for case in cases])
    speed = np.array([case.values["speed"] for case in cases])
    layers = np.log10(radius) / 2.0 * 16.0, (speed + 5.0) / 4.0 * 16.0
    for layer in layers:
        assert sorted(np.floor(layer).astype(int)) == list(range(16))
    assert not np.array_equal(np.argsort(radius), np.argsort(speed))


def test_samples_are_those_of_their_seed(folder: Path) -> None:
    text = RANGED.format(kind="sobol", count=5)
    one, two = (cases_of(study_from(text, folder)) for _ in range(2))
    assert one == two
    other = cases_of(study_from(text.replace("seed = 3", "seed = 4"), folder))
    assert other[0].values != one[0].values


def test_a_table_gives_numbers_whole_numbers_and_text(folder: Path) -> None:
    (folder / "rows.csv").write_text("speed [m/s];n;file\n-1.5;7;a.k\n-2;8;b.k\n", encoding="utf-8")
    text = 'table = "rows.csv"\nbase = "case.toml"\ncollect = ["steps"]\n' + "".join(
        f'[[variable]]\nname = "{name}"\nkey = "time.{name}"\ncolumn = "{name}"\n'
        for name in ("speed", "n", "file")
    )
    base = tomllib.loads(CASE)
    cases = cases_of(study_from(text, folder), base=base)
    assert [list(case.values.values()) for case in cases] == [[-1.5, 7, "a.k"], [-2, 8, "b.k"]]
    crossed = text + '[[variable]]\nname = "more"\nkey = "time.more"\nvalues = [1, 2]\n'
    assert [case.values["more"] for case in cases_of(study_from(crossed, folder), base=base)] == [
        1,
        2,
        1,
        2,
    ]


SPEEDS = (
    'table = "rows.csv"\nbase = "case.toml"\ncollect = ["steps"]\n[[variable]]\n'
    'name = "speed"\nkey = "{key}"\ncolumn = "speed"\n'
)
MOVED = "body.ball.motion.velocity[2]"


@pytest.mark.parametrize(
    ("head", "units", "factor"),
    [
        ("speed [km/h]", ("mm", "kg", "ms"), 1 / 3.6),
        ('"speed [km/h]"', ("m", "kg", "s"), 1 / 3.6),
        ("speed (kmh)", ("m", "kg", "s"), 1 / 3.6),
        ("speed [m/s]", ("mm", "kg", "s"), 1e3),
        ("speed [kg/m^3]", ("mm", "kg", "ms"), 1e-9),
        ("speed [t/mm³]", ("m", "kg", "s"), 1e12),
        ("speed [MPa]", ("mm", "kg", "ms"), 1e-3),
        ("speed [N/mm^2]", ("mm", "t", "s"), 1.0),
        ("speed [kNm]", ("mm", "kg", "ms"), 1e3),
        ("speed [N m]", ("mm", "g", "ms"), 1e3),
        ("speed [m/s²]", ("mm", "kg", "ms"), 1e-3),
        ("speed [deg/s]", ("mm", "kg", "ms"), np.pi / 180e3),
        ("speed [rpm]", ("mm", "kg", "s"), np.pi / 30.0),
        ("speed [%]", ("mm", "kg", "ms"), 0.01),
        ("speed [1]", ("mm", "kg", "ms"), 1.0),
        ("speed", ("mm", "kg", "ms"), 1.0),
    ],
)
def test_columns_of_a_table_are_converted_to_the_units_of_the_case(
    head: str, units: tuple[str, str, str], factor: float, folder: Path
) -> None:
    (folder / "rows.csv").write_text(f"{head};n\n-36;1\n1,5;2\n", encoding="utf-8")
    study = study_from(SPEEDS.format(key=MOVED), folder)
    base = tomllib.loads(CASE) | {
        "units": dict(zip(("length", "mass", "time"), units, strict=True))
    }
    cases = cases_of(study, base=base)
    found = [case.settings[MOVED] for case in cases]
    np.testing.assert_allclose(found, [-36 * factor, 1.5 * factor], rtol=1e-14)
    assert [case.values["speed"] for case in cases] == found, "rules and the table see the same"


@pytest.mark.parametrize(
    ("head", "more", "said"),
    [
        ("speed [fast]", "", "rows.csv:1: speed [fast]: not a unit of the quantities of a case"),
        ("speed (max)", "", "found 'max'"),
        ("speed [degC]", "", "not a unit of the quantities"),
        ("speed [g]", "", "a unit of mass and of acceleration"),
        ("speed [deg]", "", "an angle is not converted"),
        ("speed [km/h] raw", "", "stands at the end of its head"),
        ("speed [km/h]", 'unit = "km/h"\n', "speed: unit: a column with a unit is converted"),
    ],
)
def test_heads_that_are_not_converted_are_refused(
    head: str, more: str, said: str, folder: Path
) -> None:
    (folder / "rows.csv").write_text(f"{head},n [what]\n-36,1\n", encoding="utf-8")
    name = head if "raw" in head else "speed"
    text = SPEEDS.format(key=MOVED).replace('column = "speed"', f'column = "{name}"') + more
    with pytest.raises(InputError) as caught:
        cases_of(study_from(text, folder), base=tomllib.loads(CASE))
    assert said in str(caught.value)


def test_units_beside_the_key_and_labels_of_the_case(folder: Path) -> None:
    (folder / "rows.csv").write_text("speed [km/h]\n-36\n", encoding="utf-8")
    base = tomllib.loads(CASE)
    base["body"][0]["motion"] = {
        "kind": "velocity",
        "direction": "z",
        "unit": "km/h",
        "table": [[0, 0], [1, 0]],
    }
    key = "body.ball.motion.table[1][1]"
    with pytest.raises(UnitError, match="are in the unit that stands beside it"):
        cases_of(study_from(SPEEDS.format(key=key), folder), base=base)
    del base["body"][0]["motion"]["unit"]
    labelled = study_from(SPEEDS.format(key=key) + 'unit = "mm/ms"\n', folder)
    assert cases_of(labelled, base=base)[0].settings == {key: -10.0}
    seconds = 'set = { "units.time" = "s" }\n' + SPEEDS.format(key=key)
    assert cases_of(study_from(seconds, folder), base=base)[0].settings[key] == -10000.0


def test_a_text_has_no_unit(folder: Path) -> None:
    (folder / "rows.csv").write_text("speed [km/h]\nfast\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"rows\.csv:2: a text in a column with a unit"):
        cases_of(study_from(SPEEDS.format(key=MOVED), folder), base=tomllib.loads(CASE))


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("speed,n\n,1\n", "rows.csv:2: a value of the table is missing; found ',1'"),
        ("speed,n\n-1,2\n\n,3\n", "rows.csv:4: a value of the table is missing"),
        ("speed,n\n-1\n", "is missing"),
        ("speed,n\nnan,2\n", "is missing"),
        ("speed,n\n-1,2,3\n", "rows.csv:2: a row has 3 cells under a header of 2"),
        ("speed,n\n", "has no rows"),
        ("sped,n\n-1,2\n", "the column 'speed' is missing; found 'sped, n'"),
        ("speed,speed\n-1,2\n", "the column 'speed' is there 2 times"),
        ("-1,2\n-1,2\n", "must name the columns"),
        ("", "must name the columns"),
    ],
)
def test_a_table_with_holes_is_refused(rows: str, said: str, folder: Path) -> None:
    (folder / "rows.csv").write_text(rows, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        cases_of(study_from(SPEEDS.format(key=MOVED), folder))
    assert said in str(caught.value)


def test_rules_set_keys_and_leave_cases_out(folder: Path) -> None:
    text = STUDY + '[[rule]]\nrequire = "speed < -1 or step > 0.3"\n'
    text += '[[rule]]\nkey = ["time.end", "time.largest"]\nvalue = "4 * step"\n'
    cases = cases_of(study_from(text, folder))
    assert [tuple(case.values.values()) for case in cases] == [(-1, 0.5), (-2, 0.5), (-2, 0.25)]
    assert [case.number for case in cases] == [1, 2, 3]
    assert [case.settings["time.end"] for case in cases] == [2.0, 2.0, 1.0]
    assert cases[2].settings["time.largest"] == 1.0
    with pytest.raises(CaseError, match="no case fulfils the rules"):
        cases_of(study_from(STUDY + '[[rule]]\nrequire = "speed > 0"\n', folder))


def test_a_grid_that_nobody_runs_is_refused(folder: Path) -> None:
    many = STUDY.replace("values = [0.5, 0.25]", "low = 0.1\nhigh = 0.5\ncount = 1000000")
    with pytest.raises(CaseError, match=r"too many cases; found 2000000"):
        cases_of(study_from(many, folder))


def test_keys_that_lead_nowhere_say_whose_they_are(folder: Path) -> None:
    base = {"body": [{"name": "ball", "motion": {"velocity": [0, 0, -1]}}], "time": {"step": 1}}
    good = study_from(STUDY, folder)
    check_keys(good, base, cases_of(good)[0].settings)
    wrong = study_from(STUDY.replace("body.ball.", "body.bal."), folder)
    with pytest.raises(
        CaseError, match=r"variable 'speed'.*base case has no such key.*Did you mean 'ball'"
    ):
        check_keys(wrong, base, cases_of(wrong)[0].settings)
    far = study_from(STUDY.replace("velocity[2]", "velocity[3]"), folder)
    with pytest.raises(CaseError, match="variable 'speed'"):
        check_keys(far, base, cases_of(far)[0].settings)
    twice = study_from(STUDY + '[[rule]]\nkey = "time.step"\nvalue = "step"\n', folder)
    with pytest.raises(CaseError, match=r"two entries set this key.*variable 'step'"):
        check_keys(twice, base, cases_of(twice)[0].settings)


def test_tables_and_lists_are_shown_as_text() -> None:
    assert [shown_value(v) for v in (1, 2.5, "a", [1, 2], {"k": 1}, True)] == [
        *(1, 2.5, "a", "[1, 2]", '{"k": 1}', "true")
    ]
