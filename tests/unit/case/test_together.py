"""What is wrong with the parts of a case is told at once, what costs nothing first."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.case.build import build
from contiga.case.problems import ErrorCollector
from contiga.case.schema import load_case
from contiga.case.whole import load_case_to_build
from contiga.errors import InputError, MissingPackageError

CASE = """
[units]
length = "mm"
mass = "g"
time = "ms"
[time]
end = 10.0
step = 0.5
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 20.0, centre = [0, 0, 30] }
mass = { density = 1.0e-3 }
motion = { kind = "free", velocity = [0, 0, -1.0] }
[[body]]
name = "sled"
geometry = { shape = "plane", width = 90.0, length = 90.0, centre = [0, 0, -50] }
motion = { kind = "acceleration", table = [[0, 2.0], [10, 0.0]], unit = "g", direction = "x" }
[[body]]
name = "part"
geometry = { shape = "sphere", radius = 5.0, centre = [90, 0, 0] }
[[slave]]
name = "pad"
points = { grid = { shape = "plane", width = 80, length = 80, nu = 9, nv = 9 } }
thickness = 10.0
[[slave]]
name = "skin"
points = { body = "part", tolerance = 0.5 }
[[contact]]
master = "ball"
slave = "pad"
law = { kind = "stress", elastic = [[0, 0], [0.5, 1.0]] }
[[contact]]
master = "ball"
slave = "skin"
law = { kind = "force", curve = [[0, 0], [1, 1]] }
"""
WRONG = {
    "sled's table": ("[10, 0.0]]", "[9, 0.0]]", "body[1].motion.table: "),
    "part's file": (
        'shape = "sphere", radius = 5.0, centre = [90, 0, 0]',
        'mesh = "part.stl"',
        "body[2].geometry",
    ),
    "ball's mass": (
        'shape = "sphere", radius = 20.0, centre = [0, 0, 30]',
        'shape = "plane", width = 20.0, length = 20.0, centre = [0, 0, 30]',
        "body[0].mass",
    ),
    "pad's thickness": ("thickness = 10.0\n", "", "contact[0].law: the law needs the slave's"),
}


def told(folder: Path, *names: str) -> InputError:
    text = CASE
    for name in names:
        old, new, _ = WRONG[name]
        assert text.count(old) == 1
        text = text.replace(old, new)
    (folder / "part.stl").write_text("solid nothing\nfacet\n")
    (folder / "case.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        build(load_case(folder / "case.toml"))
    return caught.value


def test_it_is_one_list(tmp_path: Path) -> None:
    first, *others = str(told(tmp_path, *WRONG)).splitlines()
    assert first == f"{tmp_path / 'case.toml'}: 4 things are wrong"
    # The contact of the part that cannot be read is not wrong by itself.
    assert all(
        line.strip().startswith(WRONG[name][2]) for line, name in zip(others, WRONG, strict=True)
    )


@pytest.mark.parametrize("name", WRONG)
def test_one_thing_is_told_alone(tmp_path: Path, name: str) -> None:
    error = told(tmp_path, name)
    assert str(error).startswith(f"{tmp_path / 'case.toml'}: {WRONG[name][2]}")


def test_what_is_right_is_built(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    assert len(build(load_case(tmp_path / "case.toml")).contacts) == 2


def test_other_errors_are_not_kept() -> None:
    wrong = ErrorCollector("case.toml", {})
    wrong.raise_all()
    with pytest.raises(ZeroDivisionError), wrong.at("body[0]"):
        raise ZeroDivisionError


def test_what_tables_say_wrong_is_told_with_what_cannot_be_made(tmp_path: Path) -> None:
    """Beside the pad's table, whose contact is left out, a file and a mass are wrong."""
    text = CASE.replace("thickness = 10.0", "thicknes = 10.0")
    for name in ("part's file", "ball's mass"):
        old, new, _ = WRONG[name]
        text = text.replace(old, new)
    (tmp_path / "part.stl").write_text("solid nothing\nfacet\n")
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        load_case_to_build(tmp_path / "case.toml")
    first, *others = [line.strip() for line in str(caught.value).splitlines()]
    assert first == f"{tmp_path / 'case.toml'}: 3 things are wrong"
    assert others[0].startswith("slave[0].thicknes: unknown key")
    assert others[1].startswith("body[2].geometry")
    assert others[2].startswith("body[0].mass")


@pytest.mark.parametrize("reader", [load_case, load_case_to_build])
def test_names_of_nothing_are_in_the_list(tmp_path: Path, reader) -> None:
    """Beside a key that is none, a master is misspelt, and so are a load's body and a spring's."""
    text = CASE.replace("thickness = 10.0", "thicknes = 10.0")
    text = text.replace('master = "ball"\nslave = "skin"', 'master = "bal"\nslave = "skin"')
    text += '[[load]]\nbody = "pad"\nforce = [1, 0, 0]\n'
    text += '[[spring]]\nbetween = ["ground", "sledd"]\nat = [[0, 0, 0], [9, 0, 0]]\ncurve = 1\n'
    if reader is load_case_to_build:
        text = text.replace(*WRONG["ball's mass"][:2])
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        reader(tmp_path / "case.toml")
    _, *lines = [line.strip() for line in str(caught.value).splitlines()]
    starts = ["slave[0].thicknes: unknown key", "contact[1].master: no body", "load[0].body: no"]
    starts += ["spring[0].between[1]: no"] + ["body[0].mass"] * (reader is load_case_to_build)
    assert [line[: len(start)] for line, start in zip(lines, starts, strict=True)] == starts
    assert "Did you mean 'ball'?" in lines[1]
    assert "'pad' is a slave" in lines[2]


@pytest.mark.parametrize("name", ["", 3])
def test_names_are_not_held_against_tables_that_are_wrong(tmp_path: Path, name: object) -> None:
    """What the contacts call by its name has a name that is none."""
    (tmp_path / "case.toml").write_text(CASE.replace('name = "ball"', f"name = {name!r}"))
    with pytest.raises(InputError) as caught:
        load_case(tmp_path / "case.toml")
    assert "body[0].name" in str(caught.value)
    assert "things are wrong" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('time = "ms"', 'time = "mss"', "units.time"),
        ("step = 0.5", "step = -0.5", "time.step"),
        ("[[body]]", "[[bodies]]", "bodies"),
        ('master = "ball"\nslave = "pad"', 'master = "bal"\nslave = "pad"', "contact[0].master"),
        ("radius = 20.0", "radius = -20.0", "body[0].geometry"),
    ],
)
def test_what_is_wrong_alone_is_told_alone(tmp_path: Path, old: str, new: str, key: str) -> None:
    (tmp_path / "case.toml").write_text(CASE.replace(old, new, 1))
    with pytest.raises(InputError) as alone:
        load_case(tmp_path / "case.toml")
    with pytest.raises(InputError) as whole:
        load_case_to_build(tmp_path / "case.toml")
    assert str(whole.value) == str(alone.value)
    assert key in str(alone.value)


@pytest.mark.parametrize("key", ["sensor", "load", "spring"])
def test_entries_that_are_no_tables_are_told_with_the_rest(tmp_path: Path, key: str) -> None:
    old, new, place = WRONG["ball's mass"]
    (tmp_path / "case.toml").write_text(f"{key} = ['a', 5]\n" + CASE.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_case_to_build(tmp_path / "case.toml")
    lines = [line.strip() for line in str(caught.value).splitlines()]
    assert len(lines) == 4
    for line, start in zip(lines[1:], (f"{key}[0]", f"{key}[1]", place), strict=True):
        assert line.startswith(start)


def test_bodies_that_are_no_tables_are_told(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    with pytest.raises(InputError, match=r"body\[0\]: must be a table; found 5"):
        load_case_to_build(tmp_path / "case.toml", set={"body": [5]})


def no_cad(*_: object) -> None:
    raise MissingPackageError("reading CAD needs a package")


def test_a_missing_package_is_one_line_of_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = CASE
    for name in ("sled's table", "ball's mass"):
        text = text.replace(*WRONG[name][:2])
    text = text.replace('shape = "sphere", radius = 5.0, centre = [90, 0, 0]', 'mesh = "part.stl"')
    (tmp_path / "part.stl").touch()
    (tmp_path / "case.toml").write_text(text)
    monkeypatch.setattr("contiga.case.geometry_spec.MeshGeometry.body", no_cad)
    with pytest.raises(InputError) as caught:
        build(load_case(tmp_path / "case.toml"))
    lines = [line.strip() for line in str(caught.value).splitlines()]
    assert "body[2].geometry: reading CAD needs a package" in lines
    assert len(lines) == 4
    (tmp_path / "case.toml").write_text(CASE.replace("thickness = 10.0", "thicknes = 10.0"))
    monkeypatch.setattr("contiga.case.build._checked_body", no_cad)
    with pytest.raises(InputError, match=r"body\[0\]\.geometry: reading CAD needs") as caught:
        load_case_to_build(tmp_path / "case.toml")
    assert "thicknes: unknown key" in str(caught.value)


def test_a_missing_package_alone_stays_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "part.stl").touch()
    old = WRONG["part's file"][0]
    (tmp_path / "case.toml").write_text(CASE.replace(old, 'mesh = "part.stl"'))
    monkeypatch.setattr("contiga.case.geometry_spec.MeshGeometry.body", no_cad)
    with pytest.raises(MissingPackageError, match=r"case.toml: body\[2\]\.geometry: reading CAD"):
        build(load_case(tmp_path / "case.toml"))


def test_places_are_counted_as_in_the_file(tmp_path: Path) -> None:
    """The first body is wrong: what is told of the third stands under its own number."""
    old, new, _ = WRONG["sled's table"]
    text = CASE.replace("radius = 20.0", "radius = '20'").replace(old, new)
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        load_case_to_build(tmp_path / "case.toml", set={"contact[1].master": "sled"})
    lines = [line.strip() for line in str(caught.value).splitlines()]
    assert lines[1].startswith("body[0].geometry")
    assert lines[2].startswith("body[1].motion.table")


SCHEMA = {
    "two unknown keys of a table": [
        ("radius = 20.0, centre", "raduis = 20.0, center", "body[0].geometry.raduis: unknown key"),
        ("", "", "body[0].geometry.center: unknown key"),
    ],
    "a wrong type beside an unknown key": [
        ("end = 10.0\nstep = 0.5", "end = '10'\nstp = 0.5", "time.stp: unknown key"),
        ("", "", "time.end: must be a number"),
    ],
    "names that nothing has": [
        ('master = "ball"\nslave = "pad"', 'master = "bal"\nslave = "pat"', "contact[0].master"),
        ("", "", "contact[0].slave"),
        ('points = { body = "part"', 'points = { body = "prat"', "slave[1].points.body"),
    ],
    "a motion and points of two that are none": [
        (
            'points = { body = "part", tolerance = 0.5 }',
            'points = { body = "prat" }\nmotion = { kind = "attached", body = "pert" }',
            "slave[1].points.body",
        ),
        ("", "", "slave[1].motion.body"),
    ],
    "laws of two contacts": [
        ('law = { kind = "stress", elastic = [[0, 0], [0.5, 1.0]] }', "", "contact[0]"),
        ('law = { kind = "force", curve = [[0, 0], [1, 1]] }', "", "contact[1]"),
    ],
}


@pytest.mark.parametrize("name", SCHEMA)
def test_what_the_tables_say_wrong_is_one_list(tmp_path: Path, name: str) -> None:
    text = CASE
    for old, new, _ in SCHEMA[name]:
        assert old in text
        text = text.replace(old, new, 1)
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        load_case(tmp_path / "case.toml")
    first, *others = str(caught.value).splitlines()
    assert first == f"{tmp_path / 'case.toml'}: {len(SCHEMA[name])} things are wrong"
    for _, _, key in SCHEMA[name]:
        assert any(line.strip().startswith(key) for line in others), (key, others)


def test_a_key_that_is_written_otherwise_is_not_missing_too(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE.replace('name = "pad"', 'nam = "pad"', 1))
    with pytest.raises(InputError, match=r"slave\[0\]\.nam: unknown key.*'name'") as caught:
        load_case(tmp_path / "case.toml")
    assert "missing" not in str(caught.value)
