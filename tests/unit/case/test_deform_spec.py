"""`motion = { kind = "deform" }`: what a case makes of it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.case.columns import columns_of_case
from contiga.case.schema import load_case
from contiga.errors import InputError

CASE = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 0.05, step = "auto", largest = 0.0025 }}
[[body]]
name = "ball"
geometry = {{ shape = "sphere", radius = 20.0, centre = [0.5, 0.5, 20.99] }}
[[slave]]
name = "block"
points = {{ file = "block.inp" }}
[slave.motion]
kind = "deform"
density = 1.0e-3
fixed = {fixed}
velocity = [0.0, 0.0, 0.5]
[slave.motion.material]
{material}
[[contact]]
master = "ball"
slave = "block"
search = "penetration"
law = {law}
"""
FOAM = 'kind = "foam"\nloading = [[0, 0], [0.5, 0.3], [0.9, 5.0]]\nhysteresis = 0.2'
RUBBER = 'kind = "neo-hooke"\nyoung = 1.0\npoisson = 0.3'
PLANE = "{ plane = [[0, 0, 0], [0, 0, 1]] }"
PER_AREA = '{ kind = "penalty", stiffness = 1.0, per_area = true }'


def write_case(folder: Path, **changed: str) -> Path:
    """The case, beside a block of two cells as an Abaqus mesh with a set of nodes."""
    slave = block((1, 1, 2), (1.0, 1.0, 1.0), kind="hexahedron")
    lines = ["*NODE"]
    lines += [f"{k + 1}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(slave.points.tolist())]
    lines += ["*ELEMENT, TYPE=C3D8"]
    cells = np.asarray(slave.elements["hexahedron"]) + 1
    lines += [", ".join(map(str, [k + 1, *cell])) for k, cell in enumerate(cells.tolist())]
    low = 1 + np.flatnonzero(slave.points[:, 2] == 0.0)
    lines += ["*ELSET, ELSET=upper", "2"]
    lines += ["*NSET, NSET=low", ", ".join(map(str, low.tolist()))]
    (folder / "block.inp").write_text("\n".join(lines) + "\n")
    path = folder / "case.toml"
    values = {"fixed": PLANE, "material": RUBBER, "law": PER_AREA} | changed
    path.write_text(CASE.format(**values))
    return path


@pytest.mark.parametrize("material", [RUBBER, FOAM, 'kind = "elastic"\nyoung = 2.0'])
def test_a_case_deforms_and_its_columns_are_foretold(tmp_path: Path, material: str) -> None:
    case = load_case(write_case(tmp_path, material=material))
    simulation = cg.build(case)
    state = simulation.run().state
    way = state.slaves["block"].points - simulation.slaves["block"].slave.points
    low = simulation.slaves["block"].slave.points[:, 2] == 0.0
    assert not way[low].any()
    assert np.abs(way[~low]).max() > 1e-3
    assert simulation.contacts[0].contact.quadrature == 3
    result = simulation.run()
    assert {name for name in result.history if name.startswith("energy.")} == {
        name for name in columns_of_case(case) if name.startswith("energy.")
    }


@pytest.mark.parametrize("fixed", ['{ set = "low" }', "[{ box = [[0, 0, 0], [1, 1, 0]] }]"])
def test_sets_and_boxes_hold_the_same_nodes_as_the_plane(tmp_path: Path, fixed: str) -> None:
    nodes = []
    for held in (PLANE, fixed):
        simulation = cg.build(load_case(write_case(tmp_path, fixed=held)))
        nodes.append(simulation.run().state.slaves["block"].points)
    np.testing.assert_array_equal(*nodes)


def test_cloth_on_a_grid_is_a_membrane_of_fabric(tmp_path: Path) -> None:
    material = 'kind = "fabric"\nwarp = 3.0\nweft = 1.0\nshear = 0.2\ndirection = [1, 0, 0]'
    text = write_case(tmp_path, material=material).read_text()
    cloth = '{ grid = { shape = "plane", width = 4, length = 4, nu = 5, nv = 5 } }\nthickness = 0.1'
    (tmp_path / "case.toml").write_text(
        text.replace('{ file = "block.inp" }', cloth)
        .replace("20.99", "19.9")
        .replace(PLANE, "{ box = [[-2, -2, 0], [-2, 2, 0]] }")
    )
    history = cg.build(load_case(tmp_path / "case.toml")).run().history
    assert history["force"].max() > 0.0
    assert history["energy.strain"].max() > 0.0


def test_held_ways_leave_the_others_free(tmp_path: Path) -> None:
    fixed = '{ set = "low", hold = ["x", "y"] }'
    state = cg.build(load_case(write_case(tmp_path, fixed=fixed))).run().state
    assert state.slaves["block"].points[0, 2] > 1e-3
    assert not state.slaves["block"].points[0, :2].any()


def test_masses_stand_on_the_nodes_of_these_numbers(tmp_path: Path) -> None:
    """Numbers of the block are its rows and 1."""
    tables = """[{ nodes = [12, 9], mass = [2.0, 0.5] },
        { plane = [[0, 0, 1], [0, 0, 1]], mass = 0.4 }]"""
    plain = cg.build(load_case(write_case(tmp_path))).mechanism.masses["block"]
    case = load_case(write_case(tmp_path, fixed=f"{PLANE}\nmasses = {tables}"))
    simulation = cg.build(case)
    extra = simulation.mechanism.masses["block"] - plain
    top = simulation.slaves["block"].slave.points[:, 2] == 1.0
    expected = np.where(top, 0.1, 0.0)
    expected[[11, 8]] += [2.0, 0.5]
    np.testing.assert_allclose(extra, expected, rtol=1e-12)
    assert "masses of 2.5 on nodes, masses of 0.4 on nodes" in case.slave[0].motion.describe()


def test_numbers_of_nodes_are_those_of_a_file(tmp_path: Path) -> None:
    path = write_case(tmp_path, fixed="{ nodes = [1] }")
    grid = '{ grid = { shape = "plane", width = 1, length = 1, nu = 3, nv = 3 } }\nthickness = 0.1'
    path.write_text(path.read_text().replace('{ file = "block.inp" }', grid))
    with pytest.raises(InputError, match="nodes: only a mesh from a file has numbers of nodes"):
        cg.build(load_case(path))
    slave = block((1, 1, 2), (1.0, 1.0, 1.0), kind="hexahedron")
    cells = [("hexahedron", np.asarray(slave.elements["hexahedron"]))]
    meshio.Mesh(slave.points, cells).write(tmp_path / "block.vtu")
    path = write_case(tmp_path, fixed="{ nodes = [1] }")
    path.write_text(path.read_text().replace("block.inp", "block.vtu"))
    with pytest.raises(InputError, match="does not number its nodes"):
        cg.build(load_case(path))


NODAL = """
[[slave.motion.driven]]
layer = { direction = [0, 0, 1] }
hold = ["z"]
motion = { kind = "velocity", table = [[0, 0], [0.05, -0.2]], direction = "z" }
[[slave.motion.loads]]
pressure = [[0, 0], [0.05, 0.01]]
side = { direction = [1, 0, 0], angle = 10 }
[[slave.motion.loads]]
force = [0, 0.001, 0]
set = "low"
"""


def test_nodes_are_driven_and_loaded(tmp_path: Path) -> None:
    path = write_case(tmp_path)
    text = path.read_text().replace("velocity = [0.0, 0.0, 0.5]\n", "")
    path.write_text(text.replace("[[contact]]", f"{NODAL}[[contact]]"))
    simulation = cg.build(load_case(path))
    result = simulation.run()
    rest = simulation.slaves["block"].slave.points
    way = result.state.slaves["block"].points - rest
    np.testing.assert_allclose(way[rest[:, 2] == 1.0, 2], -0.005, atol=1e-12)
    side = (rest[:, 0] == 1.0) & (rest[:, 2] > 0.0)
    assert (way[side, 0] < 0.0).all()
    assert result.state.slaves["block"].matter["load"][:, 1].sum() == pytest.approx(1e-3, rel=0.05)


PARTS = """
[[slave.motion.parts]]
set = "{set}"
density = 5.0e-3
material = {{ kind = "neo-hooke", young = 3.0, poisson = 0.2 }}
bulk_viscosity = [0.06, 1.5]
"""


@pytest.mark.parametrize("named", ["upper", "low"])
def test_parts_have_a_material_of_their_own(tmp_path: Path, named: str) -> None:
    path = write_case(tmp_path)
    text = path.read_text().replace("[[contact]]", PARTS.format(set=named) + "[[contact]]")
    path.write_text(text)
    if named == "low":  # no cell has all its nodes in it
        with pytest.raises(InputError, match=r"motion.set: no element of the slave is in this"):
            cg.build(load_case(path))
        return
    simulation = cg.build(load_case(path))
    mass = simulation.mechanism.masses["block"]
    assert mass.sum() == pytest.approx(0.5 * 1e-3 + 0.5 * 5e-3)
    motion = simulation.slaves["block"].motion
    assert isinstance(motion, cg.motion.Deforming)
    assert motion.parts[0].bulk_viscosity == (0.06, 1.5)
    path.write_text(text.replace("density = 1.0e-3\n", "").replace(RUBBER, ""))
    with pytest.raises(InputError, match="material"):
        cg.build(load_case(path))


NET = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 0.1, step = "auto" }}
output = {{ formats = [], report = false }}
[[slave]]
name = "net"
points = {{ file = "net.msh", unit = "mm" }}
area = 1.0
[slave.motion]
kind = "deform"
fixed = {{ layer = {{ direction = [-1, 0, 0] }} }}
velocity = [0.1, 0, 0]
{made}
"""
ROPE = """
[[slave.motion.parts]]
set = "rope"
material = { kind = "belt", loading = [[0, 0], [0.05, 100]] }
density = 2.0e-3
section = 4.0
"""
SHEET = 'material = { kind = "elastic", young = 5.0 }\ndensity = 1.0e-3\nthickness = 0.5'


def _net(folder: Path, *, sheet: bool, made: str) -> cg.Simulation:
    """A square of two triangles with a rope along its edge and a line further, as Gmsh's."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [3, 0, 0]])
    cells = [("line", np.array([[0, 1], [1, 4]]))]
    numbers = [np.array([1, 1])]
    if sheet:
        cells.append(("triangle", np.array([[0, 1, 2], [0, 2, 3]])))
        numbers.append(np.array([2, 2]))
    data = {"gmsh:physical": numbers, "gmsh:geometrical": numbers}
    named = {"rope": np.array([1, 1]), "sheet": np.array([2, 2])}
    mesh = meshio.Mesh(points, cells, cell_data=data, field_data=named)
    mesh.write(folder / "net.msh", file_format="gmsh22")
    (folder / "net.toml").write_text(NET.format(made=made))
    return cg.build(load_case(folder / "net.toml"))


def test_lines_of_a_mesh_file_are_bars(tmp_path: Path) -> None:
    made = 'material = { kind = "elastic", young = 5.0 }\ndensity = 2.0e-3\nsection = 4.0'
    simulation = _net(tmp_path, sheet=False, made=made)
    assert simulation.mechanism.masses["net"].sum() == pytest.approx(3 * 4.0 * 2e-3 + 2 * 8e-3)
    state = simulation.run().state
    assert state.energy.strain > 0.0


def test_a_named_rope_is_sewn_to_the_edge_of_a_sheet(tmp_path: Path) -> None:
    simulation = _net(tmp_path, sheet=True, made=SHEET + ROPE)
    motion = simulation.slaves["net"].motion
    assert isinstance(motion, cg.motion.Deforming)
    assert motion.parts[0].elements.tolist() == [[0, 1], [1, 4]]
    mass = 0.5 * 1e-3 + 3 * 4.0 * 2e-3
    assert simulation.mechanism.masses["net"].sum() == pytest.approx(mass)


def test_lines_that_are_made_of_nothing_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="bar2 needs a section"):
        _net(tmp_path, sheet=True, made=SHEET)


BELT = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.2, step = "auto" }
world = { gravity = [0, 0, -0.01] }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 20.0 }
[[slave]]
name = "belt"
points = { coordinates = [[-40, 0, 0], [-10, 0, 25], [10, 0, 25], [40, 0, 0]], segments = 12 }
area = 20.0
[slave.motion]
kind = "deform"
density = 1.0e-3
section = 50.0
material = { kind = "belt", loading = [[0, 0], [0.05, 1000], [0.1, 4000]] }
fixed = [{ layer = { direction = [1, 0, 0] } }, { layer = { direction = [-1, 0, 0] } }]
[[contact]]
master = "ball"
slave = "belt"
law = { kind = "penalty", stiffness = 50.0 }
"""


def test_a_belt_is_a_row_of_bars(tmp_path: Path) -> None:
    (tmp_path / "belt.toml").write_text(BELT)
    simulation = cg.build(load_case(tmp_path / "belt.toml"))
    slave = simulation.slaves["belt"].slave
    assert slave.elements["line"].shape == (12, 2)
    corners = [[-40, 0, 0], [-10, 0, 25], [10, 0, 25], [40, 0, 0]]
    assert all((slave.points == corner).all(axis=1).sum() == 1 for corner in corners)
    length = 20.0 + 2.0 * np.hypot(30.0, 25.0)
    mass = simulation.mechanism.masses["belt"]
    assert mass.sum() == pytest.approx(1e-3 * 50.0 * length)
    by_area = BELT.replace("stiffness = 50.0", "stiffness = 50.0, per_area = true")
    (tmp_path / "area.toml").write_text(by_area)
    # Bars have no facets to put points on: without a word it touches by its nodes.
    contact = cg.build(load_case(tmp_path / "area.toml")).contacts[0].contact
    assert (contact.quadrature, contact.law.per_area) == ("nodes", True)
    state = simulation.step(simulation.step(simulation.start()))
    assert (state.slaves["belt"].velocities[1:-1, 2] < 0.0).all()
    (tmp_path / "belt.toml").write_text(BELT.replace("[10, 0, 25]", "[-10, 0, 25]"))
    with pytest.raises(InputError, match=r"points.coordinates: bars need two points"):
        load_case(tmp_path / "belt.toml")


def test_a_stiffness_a_point_stays_with_the_nodes(tmp_path: Path) -> None:
    law = '{ kind = "penalty", stiffness = 1.0 }'
    simulation = cg.build(load_case(write_case(tmp_path, law=law)))
    assert simulation.contacts[0].contact.quadrature == "nodes"


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"material": RUBBER.replace("young", "yuong")}, "yuong.*Did you mean 'young'"),
        ({"material": 'kind = "neo-hook"'}, "Did you mean 'neo-hooke'"),
        ({"material": RUBBER.replace("0.3", "0.5")}, "Poisson's ratio"),
        ({"material": FOAM.replace("0.3]", "-0.3]")}, "material"),
        ({"fixed": "{ plain = [[0, 0, 0], [0, 0, 1]] }"}, "Did you mean 'plane'"),
        ({"fixed": '{ set = "up" }'}, "no part, set or group.*'up'"),
        ({"fixed": '{ set = "low", hold = ["rx"] }'}, "hold"),
        ({"fixed": "{ box = [[5, 5, 5], [6, 6, 6]] }"}, "no node of the slave is there"),
        ({"fixed": "{ }"}, "one of the keys box, plane, set, side, layer, curve, edge, nodes"),
        ({"fixed": "{ nodes = [99] }"}, "block.inp: no node has this number.*99"),
        ({"fixed": "{ nodes = [] }"}, r"fixed\[0\].nodes"),
        ({"fixed": f"{PLANE}\nmasses = {{ mass = -1 }}"}, r"masses\[0\].mass: must be a number"),
        ({"fixed": f"{PLANE}\nmasses = {{ mass = inf }}"}, r"masses\[0\].mass: must be a number"),
        (
            {"fixed": f"{PLANE}\nmasses = {{ mass = [1, 2] }}"},
            "one mass for each of nodes.*2",
        ),
        (
            {"fixed": f"{PLANE}\nmasses = {{ nodes = [1, 2], mass = [1.0] }}"},
            "one mass for each of nodes.*1 for 2",
        ),
        ({"fixed": '{ set = "low", plane = [[0, 0, 0], [0, 0, 1]] }'}, "says twice which nodes"),
        ({"fixed": f"{PLANE}\nloads = {{ }}"}, "loads.*one of the keys pressure or force"),
        ({"fixed": f"{PLANE}\nloads = {{ pressure = [1, 2] }}"}, "a number, or rows over time"),
        ({"fixed": f"{PLANE}\nloads = {{ pressure = [[0, 1]] }}"}, "at least 2 rows"),
        (
            {"fixed": f"{PLANE}\ndriven = {{ set = 'low', motion = {{ kind = 'fixed' }} }}"},
            "driven: node 0 is held along x already",
        ),
    ],
)
def test_wrong_keys_and_values_are_told(tmp_path: Path, changed: dict, text: str) -> None:
    path = write_case(tmp_path, **changed)
    with pytest.raises(InputError, match=rf"slave\[0\]\.motion.*{text}"):
        cg.build(load_case(path))


@pytest.mark.parametrize(("flat", "text"), [(False, "is inside out"), (True, "has no volume")])
def test_elements_inside_out_or_flat_are_told(tmp_path: Path, flat: bool, text: str) -> None:
    path, mesh = write_case(tmp_path), tmp_path / "block.inp"
    cell = next(line for line in mesh.read_text().splitlines() if line.count(",") == 8)
    number, *nodes = cell.split(", ")
    other = nodes[:4] + nodes[:4] if flat else nodes[4:] + nodes[:4]
    mesh.write_text(mesh.read_text().replace(cell, ", ".join([number, *other])))
    with pytest.raises(InputError, match=rf"slave\[0\]\.motion.*element 0 .*{text}"):
        cg.build(load_case(path))


def test_nodes_are_attached_to_a_body_of_the_case(tmp_path: Path) -> None:
    path = write_case(
        tmp_path,
        fixed=f'{PLANE}\nattached = {{ layer = {{ direction = [0, 0, 1] }}, body = "ball" }}',
    )
    simulation = cg.build(load_case(path))
    (joint,) = simulation.mechanism.nodes["block"].joints
    slave = simulation.slaves["block"].slave
    assert joint.rows.tolist() == np.flatnonzero(slave.points[:, 2] == 1.0).tolist()
    text = path.read_text()
    for wrong, message in (('"bowl"', "no body of this name"), ("3", "must be text")):
        path.write_text(text.replace('body = "ball" }', f"body = {wrong} }}"))
        with pytest.raises(InputError, match=message):
            cg.build(load_case(path))


def test_a_penalty_takes_its_stiffness_from_the_elements(tmp_path: Path) -> None:
    simulation = cg.build(load_case(write_case(tmp_path, law='{ kind = "penalty", scale = 0.5 }')))
    contact, (slave, motion) = simulation.contacts[0].contact, simulation.slaves["block"]
    assert contact.quadrature == 3
    assert contact.law.per_area
    assert contact.law.stiffness == pytest.approx(0.5 * motion.contact_stiffness(slave))
    modulus = 1.0 * 0.7 / (1.3 * 0.4)  # (1 − ν) E / ((1 + ν)(1 − 2 ν)), over cells of 0.5
    assert 2.0 < motion.contact_stiffness(slave) / (modulus / 0.5) < 6.0


@pytest.mark.parametrize("quadrature", ["", "quadrature = 'nodes'"])
def test_a_damping_ratio_is_of_the_masses_of_elements(tmp_path: Path, quadrature: str) -> None:
    law = f'{{ kind = "penalty", scale = 0.5, damping_ratio = 0.4 }}\n{quadrature}'
    simulation = cg.build(load_case(write_case(tmp_path, law=law)))
    contact, (slave, motion) = simulation.contacts[0].contact, simulation.slaves["block"]
    assert contact.law.damping_ratio == 0.4
    assert slave.mass is None
    np.testing.assert_array_equal(contact.slave.mass, motion.with_masses(slave).mass)
    history = simulation.run().history
    assert history["energy_damping"].max() > 0.0


def test_the_stiffness_of_a_skin_goes_with_the_modulus_and_against_the_mesh() -> None:
    def stiffness(cells: int, young: float) -> float:
        slave = block((cells,) * 3, (6.0,) * 3, kind="hexahedron")
        rubber = cg.materials.NeoHooke(young=young, poisson=0.3)
        return cg.motion.Deforming(material=rubber, density=1e-3).contact_stiffness(slave)

    assert stiffness(4, 3.0) == pytest.approx(3.0 * stiffness(4, 1.0))
    assert stiffness(8, 1.0) == pytest.approx(2.0 * stiffness(4, 1.0), rel=0.2)
    cloud = cg.Slave([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    motion = cg.motion.Deforming(
        material=cg.materials.NeoHooke(young=1.0, poisson=0.3), density=1e-3
    )
    with pytest.raises(InputError, match="has no facets"):
        motion.contact_stiffness(cloud)


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"law": '{ kind = "penalty" }'}, "exactly one of the keys stiffness or scale"),
        ({"law": '{ kind = "penalty", scale = 1, stiffness = 1 }'}, "exactly one of the keys"),
        ({"law": '{ kind = "penalty", scale = 0 }'}, "law.*scale"),
    ],
)
def test_a_scale_that_is_none_is_told(tmp_path: Path, changed: dict, text: str) -> None:
    with pytest.raises(InputError, match=text):
        cg.build(load_case(write_case(tmp_path, **changed)))


def test_a_scale_needs_a_slave_of_elements(tmp_path: Path) -> None:
    text = write_case(tmp_path, law='{ kind = "penalty", scale = 1.0 }').read_text()
    start, end = text.index("[slave.motion]"), text.index("[[contact]]")
    (tmp_path / "still.toml").write_text(text[:start] + text[end:])
    with pytest.raises(InputError, match=r"contact\[0\].*law.scale: .*the slave has none"):
        cg.build(load_case(tmp_path / "still.toml"))
    layered = text.replace("[[slave]]", 'layer = { kind = "penalty", scale = 1.0 }\n[[slave]]')
    (tmp_path / "layer.toml").write_text(layered)
    with pytest.raises(InputError, match=r"layer.scale: .*a layer has none"):
        cg.build(load_case(tmp_path / "layer.toml"))
