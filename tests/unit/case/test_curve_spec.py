"""Curves of a case from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.case.schema import load_case, parse_case
from contiga.case.toml import resolved_toml

from .conftest import GOOD, LAW, refused, swap

DECK = (
    "*DEFINE_CURVE\n12\n0.0, 0.0\n0.5, 0.7\n*DEFINE_CURVE\n13, , , 0.5\n0.0, 0.0\n0.5, 0.7\n*END\n"
)
FOAM = '{ file = "foam.csv", columns = ["strain", "stress"], units = ["1", "MPa"] }'
UNLOADING = '{ file = "d.k", curve = 13, units = ["1", "MPa"], extrapolation = "constant" }'
STRESS = (
    f'{{ kind = "stress", thickness = 5, elastic = {FOAM}, unloading = {UNLOADING}, '
    "hysteresis_slope = 0.1 }"
)


@pytest.fixture(autouse=True)
def _files(tmp_path: Path) -> None:
    (tmp_path / "foam.csv").write_text("strain,t,stress\n0,1,0\n0.5,1,0.7\n", encoding="utf-8")
    (tmp_path / "d.k").write_text(DECK, encoding="utf-8")
    (tmp_path / "pulse.k").write_text("*DEFINE_CURVE\n3\n0.0,0.0\n0.02,5.0\n", encoding="utf-8")


def test_curves_of_a_law_are_read_into_the_units_of_the_case(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(GOOD.replace(LAW, STRESS), encoding="utf-8")
    law = (case := load_case(path)).contact[0].law
    np.testing.assert_allclose(law.elastic.points, [[0.0, 0.0], [0.5, 7e-4]], rtol=1e-15)
    np.testing.assert_allclose(law.unloading.points, [[0.0, 0.0], [0.5, 3.5e-4]], rtol=1e-15)
    assert law.unloading.extrapolation == "constant"
    copy = resolved_toml(case)
    assert "foam.csv" not in copy, "the copy stands alone"
    assert resolved_toml(parse_case(copy)) == copy


def test_poses_of_a_file_are_in_the_units_of_the_case(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text(
        '"t [s]","x [m]","y","z","qw","qx","qy","qz"\n0,0,0,0,1,0,0,0\n0.01,0.1,2,0,1,0,0,0\n'
    )
    path = tmp_path / "case.toml"
    for motion in (poses := '{ kind = "poses", file = "poses.csv" }', _combined(poses)):
        path.write_text(GOOD.replace('{ kind = "fixed" }', motion), encoding="utf-8")
        case = load_case(path)
        for one in (case, case.model_copy(deep=True), parse_case(resolved_toml(case))):
            where = one.body[0].motion.instance.pose(10.0)[:3, 3]
            np.testing.assert_allclose(where, [100.0, 2.0, 0.0])


def _combined(motion: str) -> str:
    return f'{{ kind = "combine", motions = [{motion}, {{ kind = "fixed" }}] }}'


def test_springs_and_pulses_take_them_too(tmp_path: Path) -> None:
    spring = (
        '[[spring]]\nbetween = ["plate", "ground"]\nat = [[0, 0, 0], [0, 0, 1]]\n'
        'curve = { file = "foam.csv", columns = ["strain", "stress"], units = ["m", "N"] }\n'
    )
    pulse = (
        '{ kind = "velocity", file = "pulse.k", curve = 3, unit = "m/s", time_unit = "s", '
        'direction = "x" }'
    )
    path = tmp_path / "case.toml"
    path.write_text(GOOD.replace('{ kind = "fixed" }', pulse) + spring, encoding="utf-8")
    case = load_case(path)
    np.testing.assert_allclose(case.spring[0].curve.points, [[0.0, 0.0], [500.0, 7e-4]])
    motion = case.body[0].motion.motion_in(("mm", "kg", "ms"))
    assert motion.span == (0.0, 20.0)
    # From rest to 5 m/s in 20 ms: half of that speed on the mean.
    np.testing.assert_allclose(motion.pose(20.0)[0, 3], 50.0, rtol=1e-12)
    assert "curve 3 of the file" in case.body[0].motion.describe()


def wrong(old: str, new: str) -> str:
    return STRESS.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "pieces", "kind"),
    [
        swap(
            "no file",
            LAW,
            wrong("foam.csv", "fom.csv"),
            "contact[0].law.elastic.file",
            "no such file",
            kind=Exception,
        ),
        swap(
            "unknown key",
            LAW,
            wrong("columns", "column"),
            "contact[0].law.elastic.column",
            "Did you mean 'columns'?",
        ),
        swap(
            "column",
            LAW,
            wrong('"stress"]', '"stres"]'),
            "the column 'stres' is missing",
            kind=Exception,
        ),
        swap(
            "unit",
            LAW,
            wrong("MPa", "mm"),
            "contact[0].law.elastic",
            "not a unit of stress",
            kind=Exception,
        ),
        swap(
            "curve",
            LAW,
            wrong("13", "14"),
            "contact[0].law.unloading",
            "no *DEFINE_CURVE 14",
            "curve = 12, 13",
            kind=Exception,
        ),
        swap(
            "no curve", LAW, LAW.replace("[[0, 0], [1, 0.5]]", "true"), "must be a curve", "file ="
        ),
    ],
)
def test_wrong_curves_are_refused_at_their_key(
    tmp_path: Path, old: str, new: str, pieces: tuple[str, ...], kind: type
) -> None:
    refused(tmp_path, old, new, pieces, kind)
