"""Solids of a file that touch or overlap."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests import occ_rig
from tests.stress import unions

import contiga as cg
from contiga.errors import ContigaWarning, FileError, GeometryError


def plate_and_pins(path: Path) -> Path:
    """A plate, a pin that stands on it, another beside; lengths in mm."""
    made = occ_rig.Rig()
    plate, pin = made.product(occ_rig.box(20.0, 20.0, 3.0), "plate"), occ_rig.pin()
    pins = made.product(pin, "pin")
    made.assembly(
        "all",
        (plate, occ_rig.at(0, 0, 0), "base"),
        (pins, occ_rig.at(5, 5, 3), "left"),
        (pins, occ_rig.at(40, 5, 3), "right"),
    )
    return made.write(path)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return plate_and_pins(tmp_path / "all.step")


def test_a_pin_on_a_plate_is_one_solid_with_it_and_told(file: Path) -> None:
    with pytest.warns(ContigaWarning, match=r"made one: plate \(base\), pin \(left\) at \(0\.4"):
        body = cg.read_cad(file, unit="cm")
    # The pin's lower end is gone, and the plate's top is a face with a hole.
    assert (len(body.patches), body.closed) == (6 + 2 + 3, True)
    assert body.volume() == pytest.approx(1.2 + 2.0 * 0.5 * 0.01 * np.pi, rel=1e-9)
    edge = np.array([[0.5, 0.5, 0.3], [0.5, 0.5, 0.25], [0.5, 0.5, 0.81], [1.0, 0.5, 0.31]])
    assert body.contains(edge).tolist() == [True, True, False, False]
    # The nearest wall is the rim of the pin, not what it stands on.
    assert body.project(edge).gap[1] == pytest.approx(-np.hypot(0.1, 0.05), rel=1e-9)


def test_parts_keep_all_their_faces_and_those_chosen_alone_are_as_they_were(file: Path) -> None:
    parts = cg.cad_parts(file)
    assert [len(part.body.patches) for part in parts] == [6, 3, 3]
    assert all(part.body.closed for part in parts)
    assert len(cg.read_cad(file, parts=["base", "right"]).patches) == 9
    lid = cg.read_cad(file, parts="left", faces=6)  # of the plate a face, which is no solid
    assert len(lid.patches) == 4


def test_they_are_refused_or_left_as_asked_for(file: Path) -> None:
    with pytest.raises(FileError, match=r"touch or overlap; found .plate.*pin.*; allowed: .*union"):
        cg.read_cad(file, solids="refuse")
    with pytest.warns(ContigaWarning, match="kept as they are: plate"):
        assert len(cg.read_cad(file, solids="separate").patches) == 12
    with pytest.raises(
        GeometryError, match="solids: no such choice; found 'one'; allowed: \"union\", "
    ):
        cg.read_cad(file, solids="one")  # type: ignore[arg-type]


def test_solids_apart_are_not_touched(tmp_path: Path) -> None:
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    # A box of 2 by 3 by 4; the second touches the first along an edge, the third at a corner.
    places = [(0, 0, 0), (2, 3, 0), (4, 6, 4), (0, 0, 4.001)]
    made.assembly("all", *((box, occ_rig.at(*p), str(k)) for k, p in enumerate(places)))
    body = cg.read_cad(made.write(tmp_path / "apart.step"), solids="refuse")
    assert (len(body.patches), body.closed) == (24, True)


def test_a_seam_as_wide_as_the_tolerance_of_the_file_is_none(tmp_path: Path) -> None:
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    made.assembly("all", (box, occ_rig.at(0, 0, 0), "a"), (box, occ_rig.at(2 + 4e-8, 0, 0), "b"))
    path = made.write(tmp_path / "seam.step")
    with pytest.warns(ContigaWarning, match="made one"):
        body = cg.read_cad(path)
    assert body.closed
    assert body.contains([[2.0 + 2e-8, 1.5, 2.0]]).all()
    assert body.project([[2.0, 1.5, 3.9]]).gap[0] == pytest.approx(-0.1, abs=1e-6)


@pytest.mark.parametrize("gap", [1e-7, 1e-6])
def test_a_seam_that_rounded_placements_leave_is_closed_and_told(tmp_path: Path, gap) -> None:
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    made.assembly("all", (box, occ_rig.at(0, 0, 0), "a"), (box, occ_rig.at(2 + gap, 0, 0), "b"))
    with pytest.warns(ContigaWarning, match=rf"made one: box .* at \(2, .*\), {gap:.2g} apart"):
        body = cg.read_cad(made.write(tmp_path / "seam.step"))
    assert body.closed
    assert len(body.patches) == 10
    assert body.volume() == pytest.approx(48.0, abs=1.01 * gap * 12.0)
    # A floor all the way over: what is nearest to a point below the seam is the top.
    x = 2.0 + gap * np.linspace(-3.0, 3.0, 61)
    feet = body.project(np.column_stack([x, np.full(61, 1.5), np.full(61, 3.9)]))
    np.testing.assert_allclose(feet.normal, np.tile([0.0, 0.0, 1.0], (61, 1)), atol=1e-12)
    np.testing.assert_allclose(feet.gap, -0.1, atol=1e-9)


def test_a_union_that_is_not_sound_is_left_and_told(file: Path, monkeypatch) -> None:
    from contiga.io.cad import unite
    from contiga.io.cad.step_iges import read_step_iges

    monkeypatch.setattr(unite._Union, "holds", lambda self: False)
    with pytest.warns(ContigaWarning, match="no sound union of them: plate"):
        body = read_step_iges(file, None, None)
    assert len(body.patches) == 12


def test_where_no_union_is_done_nothing_is_said_to_touch(file: Path, monkeypatch) -> None:
    from contiga.io.cad import unite
    from contiga.io.cad.step_iges import read_step_iges

    def fails(self: object, *args: object) -> None:
        self.done, self.met, self.groups = False, [], []  # type: ignore[attr-defined]

    monkeypatch.setattr(unite._Union, "__init__", fails)
    told = r"boxes meet.* does not find out whether they touch or overlap.*: {}plate \(base\), pin"
    with pytest.raises(FileError, match=told.format("found '").replace(".*: ", ".*; ")):
        read_step_iges(file, None, None, solids="refuse")
    with pytest.warns(ContigaWarning, match=told.format("")):
        body = read_step_iges(file, None, None)
    assert len(body.patches) == 12
    assert not body.closed


def test_only_solids_whose_boxes_meet_are_fused_and_none_to_keep_them_apart(
    file: Path, monkeypatch
) -> None:
    from contiga.io.cad import unite
    from contiga.io.cad.step_iges import read_step_iges

    made, own = [], unite._Union.__init__

    def counted(self, pieces, *args) -> None:
        made.append(len(pieces))
        own(self, pieces, *args)

    monkeypatch.setattr(unite._Union, "__init__", counted)
    with pytest.warns(ContigaWarning, match=r"boxes meet are kept as they are: plate .base., pin"):
        body = read_step_iges(file, None, None, solids="separate")
    assert made == []
    assert len(body.openings.meetings) == 1
    with pytest.warns(ContigaWarning, match="made one"):
        read_step_iges(file, None, None)
    assert made == [2]


def test_rings_about_a_pin_are_apart_though_boxes_meet(tmp_path: Path) -> None:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    made = occ_rig.Rig()
    ring = BRepAlgoAPI_Cut(
        BRepPrimAPI_MakeCylinder(3.0, 2.0).Shape(), BRepPrimAPI_MakeCylinder(1.5, 2.0).Shape()
    ).Shape()
    made.assembly(
        "all",
        (made.product(occ_rig.pin(), "pin"), occ_rig.at(0, 0, 0), "a"),
        (made.product(ring, "ring"), occ_rig.at(0, 0, 1), "b"),
    )
    path = made.write(tmp_path / "ring.step")
    body = cg.read_cad(path, solids="refuse")
    assert (len(body.patches), body.closed) == (7, True)
    with pytest.warns(ContigaWarning, match="boxes meet"):
        assert cg.read_cad(path, solids="separate").closed


@pytest.mark.parametrize("name", ["tiles", "boxes within", "edge to edge", "heap 0"])
def test_unions_have_the_inside_of_any_of_their_pieces(name: str) -> None:
    solid = unions.solid(name)
    low, high = solid.body.bounds()
    p = np.random.default_rng(3).uniform(low - 1.0, high + 1.0, (600, 3))
    feet = solid.body.project(p)
    assert ((solid.field(p) < 0.0) == solid.body.contains(p)).all()
    assert np.abs(solid.field(feet.point)).max() <= 2e-9 * solid.size
