"""`geometry = { file, parts, faces }` of a case: what is chosen, said and refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests import occ_rig

import contiga as cg
from contiga.case.build import build
from contiga.case.describe import description
from contiga.case.part_cache import PartCache
from contiga.errors import InputError

CASE = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 1.0, step = 0.5 }}
[[body]]
name = "master"
geometry = {{ file = "rig.step", {choice} }}
[[slave]]
name = "dot"
points = {{ coordinates = [[1.0, 1.0, 9.0]] }}
area = 1.0
[[contact]]
master = "master"
slave = "dot"
law = {{ kind = "penalty", stiffness = 1.0 }}
"""


def test_a_case_says_what_becomes_of_solids_that_touch(tmp_path: Path) -> None:
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    made.assembly("all", (box, occ_rig.at(0, 0, 0), "a"), (box, occ_rig.at(2, 0, 0), "b"))
    made.write(tmp_path / "rig.step")
    cache = PartCache()
    for _ in range(2):  # what is kept of the file tells it again
        united = build(load(tmp_path, 'unit = "mm"'), parts=cache)
        (finding,) = united.findings
        assert finding == united.check()[0]
        assert (finding.rule, finding.where) == ("file", "body master")
        assert "made one: box (a), box (b) at (2, " in finding.text
        assert united.bodies["master"].body.closed
    with pytest.raises(InputError, match=r"body master: .*made one"):
        united.run(tmp_path / "out", strict=True)
    summary = united.run().summary
    assert summary["findings"][0] == finding._asdict()
    assert str(finding) in summary["warnings"]
    asked_for = build(load(tmp_path, 'solids = "union"'), parts=cache)
    assert asked_for.bodies["master"].body.closed
    assert asked_for.findings == ()
    kept = build(load(tmp_path, 'solids = "separate"'))
    assert "kept as they are" in kept.findings[0].text
    body = kept.bodies["master"].body
    assert not body.closed
    assert body.flaws[0].startswith("pieces that touch or overlap: patches ")
    with pytest.raises(InputError, match=r"body\[0\]\.geometry: .*solids touch or overlap"):
        build(load(tmp_path, 'solids = "refuse"'))
    with pytest.raises(InputError, match="solids: unknown value; found 'join'"):
        load(tmp_path, 'solids = "join"')


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("case")
    occ_rig.rig(folder / "rig.step")
    return folder


def load(folder: Path, choice: str) -> cg.Case:
    path = folder / "case.toml"
    path.write_text(CASE.format(choice=choice), encoding="utf-8")
    return cg.load_case(path)


@pytest.mark.parametrize(
    ("choice", "patches", "said"),
    [
        ('parts = ["box"]', 6, ", parts box"),
        ('parts = ["left arm/back", 1]', 12, ", parts left arm/back, 1"),
        ("faces = [6]", 1, ", faces 6"),
        ('parts = ["box"], faces = [7, 8]', 8, ", parts box, faces 7, 8"),
    ],
)
def test_a_case_chooses_parts_and_faces(folder: Path, choice: str, patches: int, said: str) -> None:
    case = load(folder, choice)
    assert f"rig.step{said}" in description(case)
    assert len(build(case).bodies["master"].body.faces.patches) == patches


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ('parts = ["bax"]', r"body\[0\]\.geometry.*no part of that name; found 'bax'; allowed: "
         r"1 box .*Did you mean 'box'\?"),
        ("parts = [9]", r"body\[0\]\.geometry.*no part of that number; found 9"),
        ("faces = [99]", r"body\[0\]\.geometry.*no face of that number; found 99; allowed: 1 to"),
        ("parts = []", r"body\[0\]\.geometry\.parts"),
        ("faces = [0]", r"body\[0\]\.geometry\.faces\[0\]"),
        ('faces = ["top"]', r"body\[0\]\.geometry\.faces\[0\]"),
        ('part = ["box"]', r"unknown key.*Did you mean 'parts'\?"),
    ],
)  # fmt: skip
def test_what_fits_nothing_is_one_message(folder: Path, choice: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build(load(folder, choice))
