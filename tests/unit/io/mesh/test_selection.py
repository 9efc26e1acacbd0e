"""What of a mesh file takes part: sets within parts, layers below the skin, middles of sets."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.errors import MeshError


def bricks(n: int) -> tuple[np.ndarray, np.ndarray]:
    """A cube of side n of unit hexahedra."""
    axes = np.arange(n + 1)
    points = np.stack(np.meshgrid(axes, axes, axes, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    low = [index[:-1, :-1, :-1], index[1:, :-1, :-1], index[1:, 1:, :-1], index[:-1, 1:, :-1]]
    high = [index[:-1, :-1, 1:], index[1:, :-1, 1:], index[1:, 1:, 1:], index[:-1, 1:, 1:]]
    return points.astype(float), np.stack([*low, *high], axis=-1).reshape(-1, 8)


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """5 by 5 by 5 bricks; sets of the nodes on top and beside, and of the lower cells."""
    points, cells = bricks(5)
    path = tmp_path_factory.mktemp("cube") / "cube.inp"
    low = np.flatnonzero(points[cells].max(axis=1)[:, 2] < 3.0)
    mesh = meshio.Mesh(
        points, [("hexahedron", cells)],
        point_sets={"TOP": np.flatnonzero(points[:, 2] == 5.0),
                    "FRONT": np.flatnonzero(points[:, 1] == 0.0)},
        cell_sets={"LOW": [low]},
    )  # fmt: skip
    meshio.write(path, mesh)
    return path


@pytest.mark.parametrize("layer", [1, 2, 3])
def test_layers_are_the_skins_of_smaller_cubes(cube: Path, layer: int) -> None:
    slave = cg.read_mesh(cube, layer=layer)
    side = 5 - 2 * (layer - 1)
    assert len(slave) == 6**3
    assert slave.bounds().tolist() == [[layer - 1] * 3, [6 - layer] * 3]
    assert slave.area.sum() == pytest.approx(6.0 * side**2)
    assert slave.active.sum() == (side + 1) ** 3 - max(side - 1, 0) ** 3


def test_the_first_layer_is_the_skin_and_all_is_what_is_inside_too(cube: Path) -> None:
    skin, first, every = (cg.read_mesh(cube, layer=how) for how in ("skin", 1, "all"))
    assert np.array_equal(skin.active, first.active)
    assert skin.active.sum() == 6**3 - 4**3
    assert every.active.all()
    assert np.array_equal(every.facets, skin.facets)
    assert (every.area[~skin.active] == 0.0).all()


@pytest.mark.parametrize(
    ("layer", "message"),
    [
        (4, r"cube\.inp, layer: the mesh has no such layer.*found 4; allowed: 1 to 3"),
        (0, "layer: is not a layer; found 0"),
        ("inner", 'is not a layer; found \'inner\'; allowed: "skin", "all"'),
        (True, "is not a layer"),
    ],
)
def test_layers_that_are_not_there_are_refused(cube: Path, layer: object, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        cg.read_mesh(cube, layer=layer)  # type: ignore[arg-type]


def test_sets_are_within_parts(cube: Path) -> None:
    top = cg.read_mesh(cube, sets="TOP")
    assert top.bounds().tolist() == [[0, 0, 5], [5, 5, 5]]
    assert top.area.sum() == pytest.approx(25.0)
    front = cg.read_mesh(cube, parts="LOW", sets="FRONT")
    assert front.bounds().tolist() == [[0, 0, 0], [5, 0, 2]]
    assert front.area.sum() == pytest.approx(10.0)
    both = cg.read_mesh(cube, sets=["TOP", "FRONT"])
    assert both.area.sum() == pytest.approx(50.0)
    with pytest.raises(MeshError, match="no facet has all its corners in one of the sets"):
        cg.read_mesh(cube, parts="LOW", sets="TOP")
    with pytest.raises(MeshError, match=r"found 'TIP'; allowed: .*Did you mean 'TOP'\?"):
        cg.read_mesh(cube, sets="TIP")


def test_sets_of_corners_have_the_middles_between_them(tmp_path: Path) -> None:
    """A ten-node tetrahedron whose file names the corners of a face alone."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    middles = np.array([corners[list(pair)].mean(axis=0) for pair in pairs])
    mesh = meshio.Mesh(
        np.vstack([corners, middles]), [("tetra10", [list(range(10))])],
        point_sets={"BASE": np.array([0, 1, 2])},
    )  # fmt: skip
    path = tmp_path / "one.inp"
    meshio.write(path, mesh)
    for chosen in (cg.read_mesh(path, parts="BASE"), cg.read_mesh(path, sets="BASE")):
        assert np.flatnonzero(chosen.active).tolist() == [0, 1, 2, 4, 5, 6]
        assert chosen.area.sum() == pytest.approx(0.5)
        assert (chosen.area[chosen.active] > 0.0).all()
