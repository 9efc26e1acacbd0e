"""How bodies are drawn in the fields of a run."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.io.out.vtkhdf import read_fields

HOLE, FAR = 0.05, 3.0


def plate() -> cg.Body:
    """A square of one with a round hole in its middle."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(corners)
    )
    hole = (cg.shapes.circle(radius=HOLE, centre=[0.5, 0.5, 0]),)
    return cg.Body([cg.shapes.plane(width=1.0, length=1.0)], trims=[(outer, hole)])


def drawn(folder: Path, body: cg.Body | cg.TriMesh, size: float | None) -> np.ndarray:
    """(n, 3, 3) corners of the triangles of the body in the fields of a run."""
    point = cg.Slave([[0.0, 0.0, FAR]], area=[1.0])
    contact = cg.Contact(body, point, law=cg.PenaltyLaw(1.0))
    simulation = cg.Simulation(
        bodies={"body": body}, slaves={"point": point}, contacts=[contact], end=1.0, step=1.0,
        output=cg.OutputOptions(size=size, report=False),
    )  # fmt: skip
    simulation.run(folder)
    fields = read_fields(folder / "fields.vtkhdf")
    (part,) = (one for one in fields.parts if one.name == "body")
    return fields.points(0)[fields.rows("body")][part.triangles]


def sides(corners: np.ndarray) -> np.ndarray:
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)


def test_no_side_is_longer_than_the_size_and_a_small_hole_is_round(tmp_path: Path) -> None:
    coarse, fine = (drawn(tmp_path / str(size), plate(), size) for size in (None, 0.01))
    assert sides(coarse).max() > 0.5
    assert sides(fine).max() <= 0.01
    middle = np.array([0.5, 0.5, 0.0]) + plate().bounds()[0] * [1.0, 1.0, 0.0]
    away = [np.linalg.norm(part[..., :2] - middle[:2], axis=-1) for part in (coarse, fine)]
    assert min(one.min() for one in away) == pytest.approx(HOLE, rel=1e-6)
    # The area that is missing is the hole's: less of a polygon of few corners.
    holes = [1.0 - area(part) for part in (coarse, fine)]
    assert holes[1] == pytest.approx(np.pi * HOLE**2, rel=0.03)
    assert holes[0] < 0.95 * holes[1]


@pytest.mark.parametrize("size", [1e-9, 1e-3])
def test_a_size_that_takes_too_many_triangles_is_refused(tmp_path: Path, size: float) -> None:
    with pytest.raises(
        cg.errors.InputError, match=r"output.size: would draw body .*or more"
    ) as caught:
        drawn(tmp_path / "out", plate(), size)
    assert not (tmp_path / "out").exists()
    least = float(caught.value.allowed.split()[0])
    assert size < least < 0.01


def area(corners: np.ndarray) -> float:
    a, b, c = np.moveaxis(corners, 1, 0)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_triangles_are_drawn_as_they_are(tmp_path: Path) -> None:
    mesh = cg.Body([cg.shapes.sphere()]).tessellate(0.05)
    actual = drawn(tmp_path, mesh, 0.1)
    np.testing.assert_array_equal(actual, mesh.vertices[mesh.triangles])


def _pulled(output: cg.OutputOptions | None = None) -> cg.Simulation:
    """A block of one by one by two that is a tenth longer, and a ball far from it."""
    slave = block((1, 1, 2), (1.0, 1.0, 2.0), kind="hexahedron")
    pulled = cg.motion.Translate([[0, 0, 0, 0.2], [1, 0, 0, 0.2]])
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=10.0),
        density=1.0,
        fixed={"layer": ([0, 0, -1], 0.0)},
        driven={"layer": ([0, 0, 1], 0.0), "motion": pulled},
    )
    return cg.Simulation(
        bodies={"body": cg.Body([cg.shapes.sphere(radius=1.0, centre=(0, 0, -9))])},
        slaves={"block": (slave, motion)},
        contacts=[],
        end=1.0,
        step="auto",
        settling=cg.Settle(tolerance=1e-6),
        units=("mm", "g", "ms"),
        output=output,
    )


def test_what_deforms_has_its_inside_in_the_fields_and_others_have_not(tmp_path: Path) -> None:
    _pulled().run(tmp_path, settle_only=True)
    fields = read_fields(tmp_path / "fields.vtkhdf")
    rows = fields.rows("block")
    stress = fields.data(0, "stress")[rows]
    strain = 0.1  # (1 + e) S of Saint-Venant and Kirchhoff, over the section, which stays
    np.testing.assert_allclose(stress[:, 2], 10.0 * (1.0 + strain) * (strain + 0.005), rtol=1e-5)
    np.testing.assert_allclose(fields.data(0, "von_mises")[rows], stress[:, 2], rtol=1e-5)
    assert np.isnan(fields.data(0, "von_mises")[fields.rows("body")]).all()
    green = strain + 0.005
    np.testing.assert_allclose(fields.data(0, "strain")[rows, 2], green, rtol=1e-5)
    np.testing.assert_allclose(fields.data(0, "principal_strain")[rows], green, rtol=1e-5)
    density = fields.data(0, "energy_density")[rows]
    np.testing.assert_allclose(density, 5.0 * green**2, rtol=1e-5)
    assert fields.units["stress"] == "MPa"
    assert fields.units["energy_density"] == "mJ/mm³"


def test_of_the_inside_only_what_is_asked_for_is_written(tmp_path: Path) -> None:
    _pulled(cg.OutputOptions(fields=("von_mises",))).run(tmp_path, settle_only=True)
    names = read_fields(tmp_path / "fields.vtkhdf").names
    assert "von_mises" in names
    assert not {"stress", "strain", "principal_strain", "energy_density"} & set(names)


def test_facets_have_what_the_elements_behind_them_have(tmp_path: Path) -> None:
    _pulled(cg.OutputOptions(cells=True, fields=("energy_density", "strain"))).run(
        tmp_path, settle_only=True
    )
    fields = read_fields(tmp_path / "fields.vtkhdf")
    (body, block_) = fields.parts
    density = fields.cell_data(0, "energy_density")
    assert len(density) == len(body.triangles) + len(block_.triangles)
    assert np.isnan(density[: len(body.triangles)]).all()
    np.testing.assert_allclose(density[len(body.triangles) :], 5.0 * 0.105**2, rtol=1e-5)
    assert fields.cell_data(0, "strain").shape == (len(density), 6)
    assert fields.cell_names == ("energy_density", "strain")


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(cg.errors.InputError, match=r"output: fields.*'mises'.*'von_mises'"):
        _pulled(cg.OutputOptions(fields=("mises",)))


@pytest.mark.parametrize(
    ("interval", "written"),
    [
        (1.0, [0.0, 1.2, 2.1, 3.0, 3.6]),
        (0.9, [0.0, 0.9, 1.8, 2.7, 3.6]),
        (0.2, [0.3 * k for k in range(13)]),
        (50.0, [0.0, 3.6]),
    ],
)
def test_fields_are_written_at_the_first_step_behind_each_interval(
    tmp_path: Path, interval: float, written: list[float]
) -> None:
    point = cg.Slave([[0.0, 0.0, FAR]], area=[1.0])
    body = cg.Body([cg.shapes.plane(width=1.0, length=1.0)])
    contact = cg.Contact(body, point, law=cg.PenaltyLaw(1.0))
    cg.Simulation(
        bodies={"body": body}, slaves={"point": point}, contacts=[contact], end=3.6, step=0.3,
        output=cg.OutputOptions(interval=interval, report=False),
    ).run(tmp_path)  # fmt: skip
    assert read_fields(tmp_path / "fields.vtkhdf").times == pytest.approx(written)


@pytest.mark.parametrize("interval", [0.0, -1.0, np.nan, np.inf])
def test_an_interval_that_is_none_is_refused(interval: float) -> None:
    point = cg.Slave([[0.0, 0.0, FAR]], area=[1.0])
    body = cg.Body([cg.shapes.plane(width=1.0, length=1.0)])
    with pytest.raises(cg.errors.InputError, match="output: interval"):
        cg.Simulation(
            bodies={"body": body}, slaves={"point": point}, end=1.0, step=1.0,
            contacts=[cg.Contact(body, point, law=cg.PenaltyLaw(1.0))],
            output=cg.OutputOptions(interval=interval),
        )  # fmt: skip


def test_nodes_of_other_parts_of_the_mesh_are_not_drawn(tmp_path: Path) -> None:
    """A slave that is one of two squares in a file; the other's nodes come first."""
    nodes = [(x + 5.0 * far, y, 0.0) for far in (1, 0) for y in (0, 1) for x in (0, 1)]
    lines = ["*KEYWORD", "*NODE"]
    lines += [
        f"{k:8d}" + "".join(f"{v:16.3f}" for v in p) for k, p in enumerate(nodes, 1)
    ]  # fmt: skip
    lines += ["*ELEMENT_SHELL", "       1       1       1       2       4       3"]
    lines += ["       2       2       5       6       8       7", "*END", ""]
    (tmp_path / "two.k").write_text("\n".join(lines), encoding="utf-8")
    square = cg.read_mesh(tmp_path / "two.k", parts=2)
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, 0.9))])
    contact = cg.Contact(ball, square, law=cg.PenaltyLaw(1.0), search="penetration")
    result = cg.Simulation(
        bodies={"ball": ball}, slaves={"square": square}, contacts=[contact], end=1.0, step=1.0,
        output=cg.OutputOptions(report=False),
    ).run(tmp_path / "out")  # fmt: skip
    fields = read_fields(tmp_path / "out" / "fields.vtkhdf")
    rows = fields.rows("square")
    (part,) = (one for one in fields.parts if one.name == "square")
    np.testing.assert_array_equal(fields.points(1)[rows], square.points[4:])
    assert sorted(np.unique(part.triangles)) == [0, 1, 2, 3]
    force = result.state.contacts["ball-square"].force
    assert np.abs(force[4:]).max() > 0.0
    np.testing.assert_array_equal(fields.data(1, "force")[rows], force[4:])
    assert (fields.data(1, "contact_status")[rows] >= 0).all()


def test_a_cloud_is_drawn_whole_whatever_takes_part(tmp_path: Path) -> None:
    cloud = cg.Slave(np.eye(3), area=np.ones(3)).selected(box=[[-1, -1, 0.5], [1, 1, 1]])
    body = cg.Body([cg.shapes.plane(width=1.0, length=1.0)])
    cg.Simulation(
        bodies={"body": body}, slaves={"cloud": cloud}, end=1.0, step=1.0,
        contacts=[cg.Contact(body, cloud, law=cg.PenaltyLaw(1.0))],
        output=cg.OutputOptions(report=False),
    ).run(tmp_path)  # fmt: skip
    fields = read_fields(tmp_path / "fields.vtkhdf")
    assert cloud.active.tolist() == [False, False, True]
    np.testing.assert_array_equal(fields.points(0)[fields.rows("cloud")], np.eye(3))
