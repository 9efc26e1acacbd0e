"""Parts and faces of CAD: what there is, where it stands, and choosing some by name or number."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests import occ_rig, occ_solids

import contiga as cg
from contiga.errors import ContigaWarning, FileError, GeometryError
from contiga.io.cad.cad_parts import read_cad_file

BLOCK = np.array([[0.0, 0.0, 0.0], [4.0, 2.0, 1.0]])
TURNED = np.array([[-2.0, 0.0, 0.0], [0.0, 4.0, 1.0]])


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return occ_rig.rig(tmp_path_factory.mktemp("rig") / "rig.step")


def gprop(shape: Any) -> tuple[float, float]:
    """Volume and area by OpenCASCADE."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    volume, area = GProp_GProps(), GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, volume)
    BRepGProp.SurfaceProperties_s(shape, area)
    return volume.Mass(), area.Mass()


def test_every_instance_is_a_part_where_it_stands(rig: Path) -> None:
    parts = cg.cad_parts(rig)
    assert [(p.number, p.name, p.place, p.kind) for p in parts] == [
        (1, "box", "box 1", "solid"),
        (2, "cup", "cup 1", "shell"),
        (3, "block", "left arm/front", "solid"),
        (4, "block", "left arm/back", "solid"),
        (5, "block", "right arm/front", "solid"),
        (6, "block", "right arm/back", "solid"),
    ]
    assert [p.colour for p in parts] == ["#ff0000", None, *["#0000ff"] * 4]
    for part, box, x, y in zip(
        parts[2:], (BLOCK, TURNED) * 2, (100, 100, 200, 200), (0, 50) * 2, strict=True
    ):
        assert np.allclose(part.body.bounds(), box + np.array([x, y, 0.0]), atol=1e-9)
        assert part.body.closed
        assert part.body.volume() == pytest.approx(8.0)
    assert not parts[1].body.closed
    assert [face.number for p in parts for face in p.faces] == list(range(1, 36))


def test_volumes_and_areas_are_those_of_opencascade(tmp_path: Path) -> None:
    shapes = {name: make() for name, make in occ_solids.SOLIDS.items()}
    made = occ_rig.Rig()
    members = []
    for k, (name, shape) in enumerate(shapes.items()):
        members.append((made.product(shape, name), occ_rig.at(50 * k, k, -k, 37.0 * k), name))
    made.assembly("all", *members)
    parts = cg.cad_parts(made.write(tmp_path / "all.step"))
    assert [part.name for part in parts] == list(shapes)
    for part, shape in zip(parts, shapes.values(), strict=True):
        volume, area = gprop(shape)
        assert part.body.closed
        assert part.body.volume() == pytest.approx(volume, rel=1e-6)
        assert part.body.area() == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize(
    ("keys", "numbers"),
    [
        ("box", [1]),
        (["box", "cup"], [1, 2]),
        (2, [2]),
        (["6", 1], None),
        ("block", [3, 4, 5, 6]),  # a product: all its instances
        ("BLOCK", [3, 4, 5, 6]),
        ("front", [3, 5]),
        ("left arm", [3, 4]),  # a sub-assembly
        ("arm", [3, 4, 5, 6]),
        ("right arm/back", [6]),
        ("rig", [1, 2, 3, 4, 5, 6]),
        ([np.int64(4), "box"], [1, 4]),
    ],
)
def test_names_and_numbers_choose_parts(rig: Path, keys: Any, numbers: list[int] | None) -> None:
    if numbers is None:  # a text is a name: there is no part called 6
        with pytest.raises(GeometryError, match="no part of that name; found '6'"):
            cg.read_cad(rig, parts=keys)
        return
    body = cg.read_cad(rig, parts=keys)
    wanted = [part for part in cg.cad_parts(rig) if part.number in numbers]
    assert len(body.patches) == sum(len(part.faces) for part in wanted)
    assert body.area() == pytest.approx(sum(part.body.area() for part in wanted))
    assert body.closed == (2 not in numbers)


def test_a_part_read_alone_is_the_one_listed(rig: Path) -> None:
    for part in cg.cad_parts(rig, unit="cm"):
        body = cg.read_cad(rig, parts=part.number, unit="cm")
        assert body.unit == part.body.unit == "cm"
        assert len(body.edges) == len(part.body.edges)
        for a, b in zip(body.patches, part.body.patches, strict=True):
            assert np.array_equal(a.control_points, b.control_points)


def test_faces_are_chosen_by_their_number_in_the_file(rig: Path) -> None:
    whole = cg.read_cad(rig)
    some = cg.read_cad(rig, faces=[7, 35, 12])
    for patch, k in zip(some.patches, (6, 11, 34), strict=True):
        assert np.array_equal(patch.control_points, whole.patches[k].control_points)
    assert len(cg.read_cad(rig, parts="box", faces=12).patches) == 7
    one = cg.read_cad(rig, faces=1)
    assert not one.closed
    assert len(one.edges) == 4


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"parts": "bock"}, r"rig\.step: no part of that name; found 'bock'; allowed: 1 box "
         r"\(box 1\), 2 cup \(cup 1\), 3 block \(left arm/front\), .*Did you mean 'block'\?"),
        ({"parts": 7}, "no part of that number; found 7; allowed: 1 box"),
        ({"faces": 36}, r"no face of that number; found 36; allowed: 1 to 35\. contiga info"),
        ({"parts": []}, "parts: chooses nothing"),
        ({"faces": []}, "faces: chooses nothing"),
        ({"parts": 0}, "parts: is not a part number or name; found 0"),
        ({"parts": True}, "is not a part number"),
        ({"parts": [1.5]}, "is not a part number"),
        ({"faces": "top"}, "faces: is not a face number; found 't'"),
        ({"faces": -1}, "is not a face number"),
    ],
)  # fmt: skip
def test_what_fits_nothing_is_told_with_what_there_is(
    rig: Path, given: dict[str, Any], message: str
) -> None:
    with pytest.raises(GeometryError, match=message):
        cg.read_cad(rig, **given)


def test_inches_are_kept_or_converted(tmp_path: Path) -> None:
    path = occ_rig.rig(tmp_path / "rig.step", "INCH")
    body = cg.read_cad(path, parts="right arm/back")
    assert body.unit == "in"
    assert np.allclose(body.bounds() * 25.4, TURNED + np.array([200.0, 50.0, 0.0]), atol=1e-9)
    assert cg.read_cad(path, parts="box", unit="mm").volume() == pytest.approx(24.0)


def test_iges_names_solids_by_their_instance(tmp_path: Path) -> None:
    path = occ_rig.rig(tmp_path / "rig.iges")
    names = [part.name for part in cg.cad_parts(path)]
    assert sorted(names[:5]) == ["back", "back", "box 1", "front", "front"]
    assert cg.read_cad(path, parts="box 1").volume() == pytest.approx(24.0)
    assert len(cg.read_cad(path, parts="front").patches) == 12


def test_loose_faces_make_a_part_as_far_as_they_adjoin(tmp_path: Path) -> None:
    from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer

    path = tmp_path / "loose.iges"
    with occ_rig.quiet():
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("MM", 0)
        for shape in (occ_rig.box(), occ_rig.pin().Moved(occ_rig.at(9, 0, 0))):
            for face in occ_solids.parts(shape, "FACE"):
                writer.AddShape(face)
        writer.Write(str(path))
    parts = cg.cad_parts(path)
    assert [(part.kind, len(part.faces), part.name) for part in parts] == [
        ("faces", 6, None),
        ("faces", 3, None),
    ]
    assert [part.body.volume() for part in parts] == pytest.approx([24.0, 5 * np.pi])
    assert all(part.body.closed for part in parts)
    with pytest.raises(GeometryError, match=r"allowed: 1 to 2 \(the file names no parts\)$"):
        cg.read_cad(path, parts="box")


def test_solids_of_one_product_have_its_name_or_their_own(tmp_path: Path) -> None:
    made = occ_rig.Rig()
    made.product(
        occ_rig.together(occ_rig.box(), occ_rig.pin().Moved(occ_rig.at(9, 0, 0))), "Gehäuse №5"
    )
    path = made.write(tmp_path / "pair.step")
    assert [part.name for part in cg.cad_parts(path)] == ["Gehäuse №5"] * 2
    counter = iter(("lid", "pin"))
    text = re.sub(
        r"MANIFOLD_SOLID_BREP\(''",
        lambda _: f"MANIFOLD_SOLID_BREP('{next(counter)}'",
        path.read_text(),
    )
    path.write_text(text)
    assert [part.name for part in cg.cad_parts(path)] == ["lid", "pin"]
    assert len(cg.read_cad(path, parts="pin").patches) == 3
    assert len(cg.read_cad(path, parts="Gehäuse №5").patches) == 9


def test_shells_that_touch_are_listed_as_they_are_alone(tmp_path: Path) -> None:
    """Two half boxes of loose faces in one file: whole they close, each alone is open."""
    made = occ_rig.Rig()
    faces = occ_solids.parts(occ_rig.box(), "FACE")
    halves = [occ_solids.sewn(faces[:3], 1e-6), occ_solids.sewn(faces[3:], 1e-6)]
    members = [(made.product(half, f"half {k}"), occ_rig.at(0, 0, 0), f"half {k}")
               for k, half in enumerate(halves)]  # fmt: skip
    made.assembly("both", *members)
    path = made.write(tmp_path / "halves.step")
    actual = read_cad_file(path)
    assert actual.body.closed
    assert len(actual.parts) == 2
    for part in actual.parts:
        assert not part.body.closed
        alone = cg.read_cad(path, parts=part.number)
        assert part.body.openings.free_edges == alone.openings.free_edges > 0


def test_a_plain_file_is_one_part(tmp_path: Path) -> None:
    path = occ_solids.write(occ_rig.box(), tmp_path / "plain.step")
    (part,) = cg.cad_parts(path)
    assert (part.number, part.place, part.kind, len(part.faces)) == (1, "", "solid", 6)
    assert {face.kind for face in part.faces} == {"plane"}


def rhino_file(path: Path) -> Path:
    """A red box called lid on the layer metal, a block of two balls, and a nameless box."""
    import rhino3dm as r

    model = r.File3dm()
    model.Settings.ModelUnitSystem = r.UnitSystem.Millimeters
    layer = r.Layer()
    layer.Name, layer.Color = "metal", (10, 20, 30, 255)
    said = r.ObjectAttributes()
    said.Name, said.LayerIndex = "lid", model.Layers.Add(layer)
    said.ColorSource = r.ObjectColorSource.ColorFromObject
    said.ObjectColor = (255, 0, 0, 255)
    origin = r.Point3d(0, 0, 0)
    brep = r.Brep.CreateFromBox(r.Box(r.BoundingBox(origin, r.Point3d(1, 2, 3))))
    ball = r.Brep.CreateFromSphere(r.Sphere(r.Point3d(9, 0, 0), 1.0))
    model.Objects.AddBrep(brep, said)
    index = model.InstanceDefinitions.Add("pair", "", "", "", origin, (ball,), (said,))
    for shift in (10.0, 20.0):
        move = r.Transform.Translation(r.Vector3d(shift, 0, 0))
        model.Objects.AddInstanceObject(
            r.InstanceReference(model.InstanceDefinitions[index].Id, move)
        )
    model.Objects.AddBrep(brep)
    assert model.Write(str(path), 7)
    return path


def test_3dm_objects_that_overlap_are_one_or_refused_or_left_as_asked_for(tmp_path: Path) -> None:
    path = rhino_file(tmp_path / "a.3dm")  # its two boxes stand at one place
    with pytest.warns(ContigaWarning, match=r"solids that touch or overlap are made one: lid, pa"):
        body = cg.read_cad(path)
    assert (len(body.patches), body.closed) == (6 + 2, True)
    assert body.volume() == pytest.approx(6.0 + 2.0 * 4.0 / 3.0 * np.pi)
    with pytest.raises(FileError, match=r"touch or overlap; found 'lid, part 4 at .*apart"):
        cg.read_cad(path, solids="refuse")
    assert cg.read_cad(path, parts="lid", solids="refuse").closed
    with pytest.warns(ContigaWarning, match=r"boxes meet are kept as they are: lid, part 4 at"):
        assert len(cg.read_cad(path, solids="separate").patches) == 14


def test_3dm_objects_are_parts_by_name_layer_and_block(tmp_path: Path) -> None:
    path = rhino_file(tmp_path / "a.3dm")
    parts = cg.cad_parts(path)
    assert [(p.name, p.place, p.kind, p.colour, len(p.faces)) for p in parts] == [
        ("lid", "", "solid", "#ff0000", 6),
        ("lid", "pair", "solid", "#ff0000", 1),
        ("lid", "pair", "solid", "#ff0000", 1),
        (None, "", "solid", "#0a141e", 6),
    ]
    assert [round(p.body.bounds()[0, 0]) for p in parts] == [0, 18, 28, 0]
    assert [len(p.body.patches) for p in parts] == [6, 1, 1, 6]  # though two are in one place
    for keys, count in (("lid", 8), ("pair", 2), (4, 6), (["pair", 4], 8)):
        assert len(cg.read_cad(path, parts=keys).patches) == count
    with pytest.warns(ContigaWarning, match="made one"):
        assert len(cg.read_cad(path, parts="metal").patches) == 8
    assert cg.read_cad(path, faces=[8, 1]).area() == pytest.approx(4 * np.pi + 3.0)
    with pytest.raises(GeometryError, match=r"1 lid, 2 lid \(pair\), 3 lid \(pair\), 4 part 4"):
        cg.read_cad(path, parts="nothing")


def test_gismo_knows_no_names_but_its_patches_have_numbers(data_dir: Path) -> None:
    path = data_dir / "utah_teapot_32bezier_gismo.xml"
    (part,) = cg.cad_parts(path)
    assert (part.name, part.kind, len(part.faces)) == (None, "faces", 32)
    assert len(cg.read_cad(path, faces=[1, 2, 3]).patches) == 3
    with pytest.raises(GeometryError, match=r"allowed: 1 \(the file names no parts\)"):
        cg.read_cad(path, parts="lid")


@pytest.mark.parametrize(
    ("name", "count"),
    [
        pytest.param("nist_ctc_02_asme1_ap242.stp", 1, marks=pytest.mark.full),
        ("goteborg_hull.step", 3),
        ("occt_bearing.iges", 1),
        ("dtmb5415_bulbous_bow.iges", 1),
    ],
)
def test_parts_of_public_files_make_up_the_whole(name: str, count: int, data_dir: Path) -> None:
    path = data_dir / name
    actual = read_cad_file(path)
    assert len(actual.parts) == count
    assert sum(len(part.faces) for part in actual.parts) == len(actual.numbers)
    whole = cg.read_cad(path)
    assert actual.body.area() == pytest.approx(whole.area(), rel=1e-12)
    total = sum(part.body.area() for part in actual.parts)
    assert total == pytest.approx(whole.area(), rel=1e-8)
    last = cg.read_cad(path, parts=count)
    assert len(last.patches) == len(actual.parts[-1].body.patches)


def test_a_face_without_extent_is_told_by_its_number(
    rig: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Left out of the patches, it keeps its number."""
    from contiga.io.cad import step_iges

    plain: Callable[..., bool] = step_iges._is_thin
    seen: list[Any] = []

    def thin(raw: Any) -> bool:
        seen.append(raw)
        return len(seen) == 2 or plain(raw)

    monkeypatch.setattr(step_iges, "_is_thin", thin)
    with pytest.warns(ContigaWarning, match="face 2: a face without extent was left out"):
        actual = step_iges.list_step_iges(rig, None, None)
    assert actual.numbers[:3] == [1, 3, 4]
    assert len(actual.numbers) == 34
