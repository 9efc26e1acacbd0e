"""Which CAD bodies are closed, and what the files' tolerances are worth."""

from __future__ import annotations

import warnings
from pathlib import Path
from types import ModuleType

import pytest

import contiga as cg
from contiga.errors import ContigaWarning

pytestmark = pytest.mark.usefixtures("kept")

NAMES = [
    "link_rod", "crossing_bores", "rounded_box", "slot", "cup",
    "shell", "cone", "lens", "torus", "sphere",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_valid_solid_is_closed(name: str, solids: ModuleType, tmp_path: Path) -> None:
    shape = solids.SOLIDS[name]()
    assert solids.is_valid(shape)
    assert set(solids.edge_uses(shape)) == {2}
    body = cg.read_cad(solids.write(shape, tmp_path / "part.step"))
    assert body.closed
    assert body.openings.flaws == []
    assert body.surface.closed


@pytest.mark.parametrize("name", ["crossing_bores", "rounded_box", "slot"])
def test_a_solid_without_one_of_its_faces_is_open(
    name: str, solids: ModuleType, tmp_path: Path
) -> None:
    faces = solids.parts(solids.SOLIDS[name](), "FACE")
    left_out = faces.pop(2)
    shape = solids.sewn(faces, 1e-6)
    body = cg.read_cad(solids.write(shape, tmp_path / "part.step"))
    assert not body.closed
    assert body.openings.free_edges == solids.edge_uses(shape)[1]
    assert body.openings.free_length == pytest.approx(solids.rim(left_out), rel=1e-3)


@pytest.mark.parametrize(
    "name",
    [
        "nist_ctc_02_asme1_ap242.stp",
        "headface_MED_full.step",
        "dtmb5415_bulbous_bow.iges",
        "occt_bearing.iges",
        "goteborg_hull.step",
    ],
)
def test_files_are_closed_or_open_as_opencascade_has_them(
    name: str, solids: ModuleType, data_dir: Path
) -> None:
    body = cg.read_cad(data_dir / name)
    uses = solids.edge_uses(solids.sewn_shape(data_dir / name))
    assert body.closed == (set(uses) == {2})
    assert body.openings.free_edges == uses.get(1, 0)
    assert body.openings.turned_faces == ()
    assert body.openings.crowded_edges == 0
    for edge in body.edges:
        assert edge.tolerance >= edge.gap >= 0.0


def test_a_slit_within_the_tolerance_is_told_with_size_and_place(
    solids: ModuleType, tmp_path: Path
) -> None:
    path = solids.write(solids.gaping_box(0.05), tmp_path / "gaping.step")
    with pytest.warns(ContigaWarning, match=r"slit .* between patches .* at \(") as caught:
        body = cg.read_cad(path)
    assert len(caught) == 1
    assert body.closed
    assert 0.02 < body.openings.slit < 0.051
    assert body.openings.slit_point[2] == pytest.approx(10.0, abs=0.06)
    metres = _quietly(path, "m")
    assert metres.openings.slit == pytest.approx(1e-3 * body.openings.slit, rel=1e-9)
    assert metres.openings.tolerance == pytest.approx(1e-3 * body.openings.tolerance, rel=1e-9)


def _quietly(path: Path, unit: str) -> cg.Body:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContigaWarning)
        return cg.read_cad(path, unit=unit)


def test_the_uncertainty_a_step_file_states_is_kept(solids: ModuleType, tmp_path: Path) -> None:
    path = solids.write(solids.cup(), tmp_path / "cup.step")
    text = path.read_text()
    mark = "UNCERTAINTY_MEASURE_WITH_UNIT("
    head, _, tail = text.partition(mark)
    path.write_text(f"{head}{mark} LENGTH_MEASURE(2.5E-3{tail[tail.index(')') :]}")
    body = cg.read_cad(path)
    assert body.openings.tolerance == pytest.approx(2.5e-3)
    assert cg.read_cad(path, unit="m").openings.tolerance == pytest.approx(2.5e-6)
