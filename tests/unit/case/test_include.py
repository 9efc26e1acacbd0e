"""Files that a case includes: names, posture, placement, and what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import contiga as cg
from contiga.case.schema import Case, load_case
from contiga.case.toml import resolved_toml
from contiga.case.whole import load_case_to_build
from contiga.errors import CaseError, InputError
from contiga.rigid import pose

LEG = """
[[body]]
name = "pelvis"
geometry = { shape = "ellipsoid", axes = [60, 80, 60] }
mass = { total = 5.0 }
motion = { kind = "free" }

[[body]]
name = "thigh"
geometry = { shape = "ellipsoid", axes = [200, 50, 50], centre = [200, 0, 0] }
mass = { total = 8.0, centre = [190, 0, 5], inertia = [20000, 110000, 120000, 200, 0, 300] }
motion = { kind = "free", velocity = [0, 0, 2] }

[[body]]
name = "shin"
geometry = { shape = "ellipsoid", axes = [200, 40, 40], centre = [600, 0, 0] }
mass = { total = 3.5 }
motion = { kind = "free" }
reference_point = [600, 0, 0]

[[body]]
name = "boot"
geometry = { shape = "sphere", radius = 45, centre = [800, 0, 0] }
mass = { total = 1.0 }
motion = { kind = "attached", body = "shin" }

[[slave]]
name = "sole"
points = { body = "boot", size = 40.0 }

[[joint]]
name = "hip"
kind = "spherical"
between = ["pelvis", "thigh"]
at = [0, 0, 0]
axis = [1, 0, 0]

[[joint]]
name = "left knee"
kind = "revolute"
between = ["thigh", "shin"]
at = [400, 0, 0]
axis = [0, 1, 0]
angle = { stops = [-2.4, 2.0], stop_curve = 5e3, damping = 10.0 }

[[spring]]
between = ["thigh", "shin"]
at = [[300, 0, 50], [500, 0, 50]]
curve = 0.1

[[load]]
body = "shin"
force = [0, 0, 0.1]
at = [600, 0, 0]

[[sensor]]
name = "foot"
body = "shin"
at = [780, 0, 0]
axes = "body"

[[plot]]
x = "left knee.angle"
y = ["left knee.angle_force"]
"""
CASE = """
title = "a leg over a floor"
units = { length = "mm", mass = "kg", time = "ms" }
time = { end = 4.0, step = 0.1 }
[world]
gravity = [0, 0, -9.81e-3]
[[body]]
name = "floor"
geometry = { shape = "plane", width = 3000, length = 3000 }
[[contact]]
master = "floor"
slave = "driver sole"
law = { kind = "penalty", stiffness = 1e-4, per_area = true }
"""
INCLUDE = '[[include]]\nfile = "leg.toml"\nprefix = "driver "\n'
PLACED = """placement = [{ rotate = { axis = "z", degrees = 90 } }, { translate = [10, 20, 700] }]
"""


def written(folder: Path, include: str = "", *, leg: str = LEG, case: str = CASE) -> Path:
    (folder / "leg.toml").write_text(leg)
    (folder / "case.toml").write_text(f"{case}\n{INCLUDE}{include}")
    return folder / "case.toml"


def read(folder: Path, include: str = "", **changed: str) -> Case:
    return load_case(written(folder, include, **changed))


def test_the_tables_of_a_file_have_its_prefix_and_so_have_references(tmp_path: Path) -> None:
    case = read(tmp_path)
    assert [b.name for b in case.body] == [
        *("floor", "driver pelvis", "driver thigh", "driver shin", "driver boot")
    ]
    assert case.body[-1].motion.body == "driver shin"  # type: ignore[union-attr]
    assert [one.instance.name for one in case.joint] == ["driver hip", "driver left knee"]
    assert case.spring[0].name == "driver thigh-shin"
    assert case.plot[0].channels == ["driver left knee.angle_force"]
    assert case.load[0].body == "driver shin"
    assert case.sensor[0].name == "driver foot"


def test_names_of_the_case_are_known_in_a_file(tmp_path: Path) -> None:
    joint = (
        '[[joint]]\nname = "floor pin"\nkind = "spherical"\n'
        'between = ["floor", "pelvis"]\nat = [0, 0, 0]\n'
    )
    case = read(tmp_path, leg=LEG + joint)
    assert case.joint[-1].between == ["floor", "driver pelvis"]


def at(X: Any, point: ArrayLike) -> Any:
    return pose.apply(X, np.array([point], float))[0]


def turned(axis: ArrayLike, angle: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> Any:
    return pose.rotation(axis, angle, centre)


def test_joints_turn_what_hangs_beyond_them_and_the_placement_moves_all(tmp_path: Path) -> None:
    posture = 'joints = { "left knee" = 0.7, hip = { cone = 0.3, about = [0, 1, 0], twist = 0.2 } }'
    case = read(tmp_path, PLACED + posture)
    P = pose.compose(pose.translation([10, 20, 700]), turned("z", 0.5 * math.pi))
    # Twist about the thigh, then the cone, from the hip; then the knee.
    thigh = pose.compose(P, turned("y", 0.3), turned("x", 0.2))
    shin = pose.compose(thigh, turned("y", 0.7, [400.0, 0.0, 0.0]))
    simulation = cg.build(case)
    for name, X, centre in (
        ("pelvis", P, [0, 0, 0]),
        ("thigh", thigh, [190, 0, 5]),
        ("shin", shin, [600, 0, 0]),
    ):
        motion = simulation.bodies[f"driver {name}"].motion
        np.testing.assert_allclose(motion.centre, at(X, centre), atol=1e-9)  # type: ignore[union-attr]
    own = np.array([[20000, 200, 300], [200, 110000, 0], [300, 0, 120000]], float)
    inertia = simulation.bodies["driver thigh"].motion.inertia  # type: ignore[union-attr]
    np.testing.assert_allclose(inertia, thigh[:3, :3] @ own @ thigh[:3, :3].T, rtol=1e-9, atol=1e-6)
    velocity = simulation.bodies["driver thigh"].motion.velocity  # type: ignore[union-attr]
    np.testing.assert_allclose(velocity, [0, 0, 2], atol=1e-12)
    spring, load, sensor = case.spring[0], case.load[0], case.sensor[0]
    for where, X, point in (
        (spring.at[0], thigh, [300, 0, 50]),
        (spring.at[1], shin, [500, 0, 50]),
        (load.at, shin, [600, 0, 0]),
        (sensor.at, shin, [780, 0, 0]),  # type: ignore[union-attr]
        (case.body[3].reference_point, shin, [600, 0, 0]),
    ):
        np.testing.assert_allclose(where, at(X, point), atol=1e-9)
    np.testing.assert_allclose(sensor.axes, shin[:3, :3].T, atol=1e-12)  # type: ignore[union-attr,arg-type]
    boot = simulation.bodies["driver boot"].body.bounds().mean(axis=0)
    np.testing.assert_allclose(boot, at(shin, [800, 0, 0]), atol=1e-6)
    sole = simulation.slaves["driver sole"].slave.points
    np.testing.assert_allclose(np.ptp(sole, axis=0), [90, 90, 90], atol=2.0)
    np.testing.assert_allclose(sole.mean(axis=0), boot, atol=2.0)


def test_steps_that_a_part_of_the_file_has_come_before_its_posture(tmp_path: Path) -> None:
    moved = LEG.replace(
        "centre = [600, 0, 0] }", "centre = [600, 0, 0], then = [{ translate = [0, 30, 0] }] }"
    )
    for placement in ("", PLACED):
        plain, other = (read(tmp_path, placement, leg=leg) for leg in (LEG, moved))
        shins = [cg.build(one).bodies["driver shin"].body.bounds() for one in (plain, other)]
        way = [-30.0, 0.0, 0.0] if placement else [0.0, 30.0, 0.0]
        np.testing.assert_allclose(shins[1] - shins[0], [way, way], atol=1e-9)


def test_one_file_may_be_included_twice_by_two_prefixes(tmp_path: Path) -> None:
    again = f"{INCLUDE.replace('driver', 'rider')}placement = {{ translate = [0, 900, 0] }}\n"
    simulation = cg.build(read(tmp_path, f'joints = {{ "left knee" = 0.3 }}\n{again}'))
    driver, rider = (simulation.bodies[f"{who} thigh"].body.bounds() for who in ("driver", "rider"))
    np.testing.assert_allclose(rider - driver, [[0.0, 900.0, 0.0]] * 2, atol=1e-9)
    assert {"driver left knee", "rider left knee"} <= set(simulation.joints)


def test_the_velocity_is_that_of_what_gives_none(tmp_path: Path) -> None:
    case = read(tmp_path, PLACED + "velocity = [13.9, 0, 0]")
    assert [b.motion.velocity for b in case.body[1:4]] == [  # type: ignore[union-attr]
        *([13.9, 0, 0], [0, 0, 2], [13.9, 0, 0])
    ]


def test_a_run_from_a_posture_is_that_of_the_same_posture_by_hand(tmp_path: Path) -> None:
    leg = LEG.partition("[[spring]]")[0].replace("velocity = [0, 0, 2]", "spin = [0, 0.01, 0]")
    case = CASE.partition("[[contact]]")[0]
    posed = read(tmp_path, 'joints = { "left knee" = 1.2 }', leg=leg, case=case)
    knee = turned("y", 1.2, [400.0, 0.0, 0.0])
    steps = '[{ rotate = { axis = "y", degrees = %r, centre = [400, 0, 0] } }]'
    by_hand = leg
    for shape in ("centre = [600, 0, 0]", "centre = [800, 0, 0]"):
        by_hand = by_hand.replace(
            f"{shape} }}", f"{shape}, transform = {steps % math.degrees(1.2)} }}"
        )
    by_hand = by_hand.replace("damping = 10.0", "damping = 10.0, start = 1.2")
    by_hand = by_hand.replace(
        "reference_point = [600, 0, 0]",
        f"reference_point = {at(knee, [600, 0, 0]).tolist()}",
    )
    written_so = read(tmp_path, leg=by_hand, case=case)
    one, two = (cg.run(each).history for each in (posed, written_so))
    assert one.keys() == two.keys()
    for name in one:
        if "wall_time" not in name:
            size = max(1.0, float(np.abs(two[name]).max()))
            np.testing.assert_allclose(one[name], two[name], atol=1e-12 * size, err_msg=name)
    assert abs(one["driver left knee.angle"] - 1.2).max() > 1e-3  # the leg moves


def test_a_case_with_a_file_is_written_back_as_one_without(tmp_path: Path) -> None:
    case = read(tmp_path, PLACED + 'joints = { "left knee" = 0.7 }')
    text = resolved_toml(case)
    assert "include" not in text
    (tmp_path / "leg.toml").unlink()
    (tmp_path / "flat.toml").write_text(text)
    assert resolved_toml(load_case(tmp_path / "flat.toml")) == text


def test_a_file_may_hang_on_a_body_of_the_case(tmp_path: Path) -> None:
    case = read(tmp_path, 'joints = { post = 0.5 }\nroot = "floor"', leg=LEG + POST)
    thigh = case.body[2].mass.centre  # type: ignore[union-attr]
    np.testing.assert_allclose(thigh, at(turned("z", 0.5), [190, 0, 5]), atol=1e-9)
    assert case.joint[-1].angle is not None
    assert case.joint[-1].angle.start == 0.5


def test_settings_reach_the_table_and_what_the_file_holds(tmp_path: Path) -> None:
    path = written(tmp_path, 'joints = { "left knee" = 0.7 }')
    (tmp_path / "other.toml").write_text(LEG.replace("total = 5.0", "total = 6.0"))
    case = load_case(
        path,
        set={
            "include.driver.file": "other.toml",
            "include.driver.joints.left knee": 1.1,
            "body.driver shin.mass.total": 4.5,
        },
    )
    assert case.joint[1].angle is not None
    assert case.joint[1].angle.start == 1.1
    assert [b.mass.total for b in case.body[1:4]] == [6.0, 8.0, 4.5]  # type: ignore[union-attr]


def test_a_checkpoint_is_not_of_a_case_whose_file_has_changed(tmp_path: Path) -> None:
    case, leg, out = (
        CASE.partition("[[contact]]")[0],
        LEG.partition("[[spring]]")[0],
        tmp_path / "o",
    )
    once = cg.run(read(tmp_path, leg=leg, case=case)).history
    cg.run(read(tmp_path, leg=leg, case=case.replace("end = 4.0", "end = 2.0")), out)
    resumed = cg.run(read(tmp_path, leg=leg, case=case), out, resume=True).history
    np.testing.assert_array_equal(resumed["driver left knee.angle"], once["driver left knee.angle"])
    changed = leg.replace("total = 5.0", "total = 6.0")
    with pytest.raises(InputError, match="another case"):
        cg.run(read(tmp_path, leg=changed, case=case), out, resume=True)


LOOP = """
[[joint]]
name = "rod"
kind = "spherical"
between = ["shin", "pelvis"]
at = [0, 0, 0]
"""


POST = """
[[joint]]
name = "post"
kind = "revolute"
between = ["floor", "pelvis"]
at = [0, 0, 0]
axis = [0, 0, 1]
"""


@pytest.mark.parametrize(
    ("include", "leg", "words"),
    [
        ('joints = { knee = 1 }', LEG, ["joints.knee", "no joint of this name", '"left knee"']),
        ('joints = { "left knee" = 2.1 }', LEG, ["joints.left knee", "beyond a stop", "-2.4 to 2"]),
        ('joints = { "left knee" = { cone = 1 } }', LEG, ["revolute joint does not", "angle"]),
        ("joints = { hip = 0.1 }", LEG, ["has 2 coordinates", "cone = …, twist = …"]),
        ("joints = { hip = { cone = 0.1 } }", LEG, ["opens in no direction", "about = "]),
        ('joints = { "left knee" = 1 }', LEG + LOOP, ["left knee", "in a closed loop"]),
        ('joints = { "left knee" = "x" }', LEG, ["must be a coordinate", "found 'x'"]),
        ('root = "tail"', LEG, ["include[0].root", "no body of this name", '"pelvis"']),
        ('joints = { "left knee" = 1 }\nroot = "floor"', LEG, ["no body of this name"]),
        ('joints = { post = 1 }', LEG + POST, ["include[0].root", "would move 'floor'"]),
        ("placement = { scale = 2.0 }", LEG, ["include[0].placement", "cannot be scaled"]),
        ("speed = [1, 0, 0]", LEG, ["case.toml: include[0].speed: unknown key", "velocity"]),
        ("", 'units = { length = "m", mass = "kg", time = "s" }\n' + LEG,
         ["leg.toml: units", "must be those of the case"]),
        ("", 'title = "x"\n' + LEG, ["leg.toml: title", "is of the case"]),
        ("", "time = { end = 1 }\n" + LEG, ["leg.toml: time", "is of the case"]),
        ("", '[[include]]\nfile = "leg.toml"\n' + LEG, ["leg.toml", "includes no other"]),
        ("", "[[body", ["leg.toml", "not valid TOML"]),
        ("", LEG.replace("axis = [0, 1, 0]", "axis = [0, 0, 0]"),
         ["leg.toml: joint[1].axis", "has no length"]),
        ("", LEG.replace('body = "shin"\nforce', 'body = "chin"\nforce'),
         ["leg.toml: load[0].body", "no body of this name", "driver shin"]),
        ('placement = { rotate = { axis = "z", degrees = 30 } }', LEG.replace(
            'motion = { kind = "free" }', 'motion = { kind = "free", hold = ["x"] }', 1),
         ["leg.toml: body[0].motion.hold", "turns by quarters alone"]),
        ('joints = { "left knee" = inf }', LEG,
         ["include[0].joints.left knee", "must be a coordinate"]),
        ('joints = { "left knee" = { angle = nan } }', LEG,
         ["include[0].joints.left knee.angle", "must be a coordinate"]),
        ("joints = { hip = { cone = 0.2, about = [1, 1e-9, 0] } }", LEG,
         ["include[0].joints.hip.about", "is along the axis of the joint"]),
        ("joints = { hip = { cone = 0.2, about = [0, 0, 0] } }", LEG,
         ["include[0].joints.hip.about", "has no length"]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_message(
    tmp_path: Path, include: str, leg: str, words: list[str]
) -> None:
    path = written(tmp_path, include, leg=leg)
    with pytest.raises(CaseError) as error:
        load_case(path)
    message = str(error.value)
    assert all(word in message for word in words), message
    assert "things are wrong" not in message


def test_what_is_wrong_with_files_of_parts_names_the_file(tmp_path: Path) -> None:
    missing = 'geometry = { mesh = "none.stl" }'
    leg = LEG.replace('geometry = { shape = "ellipsoid", axes = [60, 80, 60] }', missing)
    with pytest.raises(InputError, match=r"leg.toml: body\[0\].geometry.*no such file") as error:
        load_case(written(tmp_path, leg=leg))
    assert str(tmp_path / "none.stl") in str(error.value)
    open_mass = LEG.replace(
        'shape = "ellipsoid", axes = [60, 80, 60]', 'shape = "disc", radius = 10'
    )
    with pytest.raises(InputError, match=r"leg.toml: body\[0\].mass.centre"):
        cg.build(read(tmp_path, leg=open_mass))
    two = CASE.replace("1e-4", "-1e-4")
    with pytest.raises(InputError) as whole:
        load_case_to_build(written(tmp_path, leg=open_mass, case=two))
    assert "leg.toml: body[0].mass.centre" in str(whole.value)
    assert "contact[0].law.stiffness" in str(whole.value)


CHAIN = {
    "spherical": ("axis = [[0, 0, 1], [0, 0.2, 1]]", {"cone": 0.4, "twist": -0.3}),
    "revolute": ("axis = [0, 1, 1]\nangle = { start = 0.2 }", {"angle": 0.9}),
    "universal": ("axis = [[1, 0, 0], [0, 1, 0]]", {"angle_1": 0.5, "angle_2": -0.6}),
    "cylindrical": ("axis = [1, 1, 0]", {"angle": -0.7, "travel": 12.0}),
    "translational": ("axis = [0, 1, 0]\ntravel = { start = 3.0 }", {"travel": -8.0}),
}


def test_joints_of_all_kinds_start_closed_and_at_their_coordinates(tmp_path: Path) -> None:
    bodies = [
        f'[[body]]\nname = "b{k}"\nmass = {{ total = {k + 1.0} }}\nmotion = {{ kind = "free" }}\n'
        f'geometry = {{ shape = "sphere", radius = 20, centre = [{100 * k}, {7 * k}, 0] }}\n'
        for k in range(6)
    ]
    joints = [
        f'[[joint]]\nname = "{kind}"\nkind = "{kind}"\nbetween = ["b{k}", "b{k + 1}"]\n'
        f"at = [{100 * k + 50}, 0, 5]\n{keys}\n"
        for k, (kind, (keys, _)) in enumerate(CHAIN.items())
    ]
    asked = ", ".join(
        f"{kind} = {{ " + ", ".join(f"{key} = {value}" for key, value in values.items()) + " }"
        for kind, (_, values) in CHAIN.items()
    )
    case = read(
        tmp_path,
        f'{PLACED}root = "b3"\njoints = {{ {asked} }}',
        leg="\n".join(bodies + joints),
        case=CASE.partition("[[contact]]")[0].replace("end = 4.0", "end = 0.2"),
    )
    simulation = cg.build(case)
    assert not [one for one in simulation.check() if one.rule == "joint"]
    history = simulation.run().history
    for kind, (_, values) in CHAIN.items():
        for key, value in values.items():
            np.testing.assert_allclose(history[f"driver {kind}.{key}"][0], value, atol=1e-12)


SEAT = """
[[body]]
name = "rail"
geometry = { shape = "sphere", radius = 20, centre = [0, 0, 100] }
motion = { kind = "translate", table = [[0, 0, 0, 0], [4, 5, 0, 0]] }
[[body]]
name = "wheel"
geometry = { shape = "sphere", radius = 20, centre = [0, 0, 300] }
motion = { kind = "rotate", axis = "x", centre = [0, 0, 310], table = [[0, 0], [4, 90]] }
[[body]]
name = "sled"
geometry = { shape = "sphere", radius = 20, centre = [0, 0, 500] }
[body.motion]
kind = "acceleration"
table = [[0, 1], [4, 1]]
direction = "x"
velocity = [2, 0, 0]
[[slave]]
name = "net"
points = { grid = { shape = "plane", width = 40, length = 80, nu = 5, nv = 9 } }
[slave.motion]
kind = "deform"
material = { kind = "elastic", young = 0.1 }
density = 1e-6
thickness = 1.0
fixed = [
  { box = [[-50, -50, -1], [-15, 50, 1]], hold = ["x"] },
  { plane = [[20, 0, 0], [1, 0, 0]] },
  { layer = { direction = [0, 1, 0] } },
]
loads = { force = [1e-3, 0, 0] }
[[spring]]
name = "wire"
between = ["net", "ground"]
at = [[0, 0, 0], [0, 0, 50]]
curve = 0.1
[[sensor]]
name = "corner"
node = "net"
at = [20, 40, 0]
"""


def test_what_is_driven_and_what_deforms_turns_with_its_file(tmp_path: Path) -> None:
    case = read(tmp_path, PLACED, leg=SEAT, case=CASE.partition("[[contact]]")[0])
    rail, wheel, sled = (body.motion for body in case.body[1:])
    np.testing.assert_allclose(rail.table, [[0, 0, 0, 0], [4, 0, 5, 0]], atol=1e-12)  # type: ignore[union-attr]
    np.testing.assert_allclose(wheel.axis, [0, 1, 0], atol=1e-12)  # type: ignore[union-attr]
    np.testing.assert_allclose(wheel.centre, [10, 20, 1010], atol=1e-12)  # type: ignore[union-attr]
    np.testing.assert_allclose(sled.direction, [0, 1, 0], atol=1e-12)  # type: ignore[union-attr]
    np.testing.assert_allclose(sled.velocity, [0, 2, 0], atol=1e-12)  # type: ignore[union-attr]
    deform = case.slave[0].motion
    box, plane, layer = deform.fixed  # type: ignore[union-attr]
    np.testing.assert_allclose(box.box, [[-40, -30, 699], [60, 5, 701]], atol=1e-9)
    assert box.hold == ["y"]
    np.testing.assert_allclose(plane.plane, [[10, 40, 700], [0, 1, 0]], atol=1e-9)
    np.testing.assert_allclose(layer.layer.direction, [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(deform.loads[0].force, [0, 1e-3, 0], atol=1e-15)  # type: ignore[union-attr]
    np.testing.assert_allclose(case.spring[0].at, [[10, 20, 700], [10, 20, 750]], atol=1e-9)
    np.testing.assert_allclose(case.sensor[0].at, [-30, 40, 700], atol=1e-9)
    cg.build(case)
    with pytest.raises(CaseError, match=r"leg.toml: slave\[0\].motion.fixed\[0\].box"):
        read(tmp_path, PLACED.replace("90", "80"), leg=SEAT, case=CASE.partition("[[contact]]")[0])


def test_a_study_may_swap_the_file_and_set_a_joint(tmp_path: Path) -> None:
    leg = LEG.partition("[[spring]]")[0]
    case = CASE.partition("[[contact]]")[0].replace("end = 4.0", "end = 0.2")
    path = written(tmp_path, 'joints = { "left knee" = 0.7 }', leg=leg, case=case)
    (tmp_path / "other.toml").write_text(leg.replace("total = 5.0", "total = 15.0"))
    found = cg.study(
        path,
        {
            "include.driver.file": ["leg.toml", "other.toml"],
            "include.driver.joints.left knee": [0.2, 0.4],
        },
        {"angle": "at(driver left knee.angle, 0)", "energy": "max(energy.kinetic)"},
        set={"output.report": False, "output.formats": ["csv"]},
        workers=0,
    ).to_pandas()
    np.testing.assert_allclose(found["angle"], [0.2, 0.4, 0.2, 0.4], atol=1e-12)
    assert set(found["status"]) == {"done"}
    # The hip holds the thigh back the more, the heavier the pelvis is.
    light, heavy = found["energy"].to_numpy().reshape(2, 2)
    assert (heavy < light).all()
