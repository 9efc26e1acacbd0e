"""What a good case file says is what the case holds."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from contiga.case.describe import describe, description
from contiga.case.schema import Case, TimeSpec, load_case, parse_case
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError
from contiga.laws.force import ForceLaw
from contiga.laws.friction import Coulomb, Friction, ViscousFriction
from contiga.laws.normal import AdaptiveLaw, PenaltyLaw
from contiga.laws.stress import StressLaw

HEAD = """\
[units]
length = "mm"
mass = "kg"
time = "ms"
[time]
end = 10
step = 2
"""
BODY = '[[body]]\nname = "plate"\ngeometry = { shape = "plane" }\n'
SLAVE = '[[slave]]\nname = "pad"\npoints = { coordinates = [[0, 0, 1]] }\n'
CONTACT = '[[contact]]\nmaster = "plate"\nslave = "pad"\nlaw = { kind = "force", curve = 2 }\n'


def case_with(
    body: str = BODY, slave: str = SLAVE, contact: str = CONTACT, folder: Path = Path()
) -> Case:
    return parse_case(HEAD + body + slave + contact, folder / "case.toml")


def test_what_is_left_out_has_a_stated_value() -> None:
    case = case_with()
    assert case.title == "contiga"
    assert case.time.start == 0.0
    assert case.output.every == 1
    assert case.output.formats == ["vtkhdf", "csv"]
    assert case.output.report
    contact = case.contact[0]
    assert case.sides(contact).type == "slave"
    assert (contact.search, contact.on_edge) == ("intersection", "release")
    assert contact.through == "release"
    assert contact.title == "plate-pad"
    np.testing.assert_array_equal(case.body[0].motion.instance.pose(3.0), np.eye(4))


@pytest.mark.parametrize(
    ("start", "end", "step", "count", "last_but_one"),
    [
        (0.0, 1.0, 0.1, 11, 0.9),
        (0.0, 0.3, 0.1, 4, 0.2),
        (0.0, 13.0, 1.0, 14, 12.0),
        (0.1, 0.7, 0.2, 4, 0.5),
        (0.0, 1.0, 0.3, 5, 0.9),
        (-1.0, 1.0, 2.0, 2, -1.0),
        (0.0, 1e-4, 1e-7, 1001, 9.99e-5),
        (0.0, 1e5, 0.1, 1_000_001, 1e5 - 0.1),
    ],
)
def test_the_number_of_steps_survives_rounding(start, end, step, count, last_but_one) -> None:
    times = TimeSpec(start=start, end=end, step=step).stepping().planned()
    assert len(times) == count
    assert times[0] == start
    assert times[-1] == end
    assert math.isclose(times[-2], last_but_one, rel_tol=1e-12)
    assert (np.diff(times) > 0.0).all()


def test_files_are_found_beside_the_case_and_kept_absolute(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "plate.step").write_text("x")
    body = '[[body]]\nname = "plate"\ngeometry = { file = "in/plate.step", unit = "m" }\n'
    (tmp_path / "case.toml").write_text(HEAD + body + SLAVE + CONTACT)
    case = load_case(tmp_path / "case.toml")
    assert Path(case.body[0].geometry.file) == (tmp_path / "in" / "plate.step").resolve()
    again = parse_case(resolved_toml(case), "/elsewhere/case.toml")
    assert again.body[0].geometry.file == case.body[0].geometry.file


@pytest.mark.parametrize(
    ("text", "kind", "field", "value"),
    [
        ('{ kind = "force", curve = 2 }', ForceLaw, "needs_mass", False),
        ('{ kind = "stress", elastic = 2, thickness = 3 }', StressLaw, "thickness", 3.0),
        ('{ kind = "stress", elastic = 2 }', StressLaw, "needs_thickness", True),
        ('{ kind = "penalty", stiffness = 4, per_area = true }', PenaltyLaw, "per_area", True),
        ('{ kind = "adaptive" }', AdaptiveLaw, "scale", 0.1),
        ('{ kind = "force", curve = 2, share = "deepest" }', ForceLaw, "share", "deepest"),
        (
            '{ kind = "force", curve = 2, unloading = 1, hysteresis_slope = 5 }',
            ForceLaw,
            "n_memory",
            2,
        ),
        (
            '{ kind = "stress", elastic = 2, unloading = 1, hysteresis_slope = 5 }',
            StressLaw,
            "n_memory",
            2,
        ),
        ('{ kind = "stress", elastic = 2, damping_ratio = 0.3 }', StressLaw, "damping_ratio", 0.3),
        (
            '{ kind = "penalty", stiffness = 4, damping_ratio = 0.3 }',
            PenaltyLaw,
            "needs_mass",
            True,
        ),
    ],
)
def test_every_law_comes_with_its_options(text: str, kind: type, field: str, value) -> None:
    contact = CONTACT.replace('{ kind = "force", curve = 2 }', text)
    law = case_with(contact=contact).contact[0].law.instance
    assert type(law) is kind
    assert getattr(law, field) == value


def test_a_curve_may_be_a_number_a_table_or_say_how_it_goes_on() -> None:
    for text, at_two in (
        ("3", 6.0),
        ("[[0, 0], [1, 3]]", 6.0),
        ('{ points = [[0, 0], [1, 3]], extrapolation = "constant" }', 3.0),
    ):
        law = (
            case_with(contact=CONTACT.replace("curve = 2", f"curve = {text}"))
            .contact[0]
            .law.instance
        )
        assert isinstance(law, ForceLaw)
        assert law.curve(2.0) == at_two


def test_a_combined_contact_takes_both_laws() -> None:
    contact = CONTACT.replace(
        'law = { kind = "force", curve = 2 }',
        'type = "combined"\nlaw = { kind = "stress", elastic = 2 }\n'
        'master_law = { kind = "stress", elastic = 5, thickness = 1 }',
    )
    assert case_with(contact=contact).contact[0].master_law is not None


@pytest.mark.parametrize(
    ("text", "friction", "description"),
    [
        ('{ kind = "coulomb", static = 0.4 }', Coulomb(0.4), "coulomb: static"),
        (
            '{ kind = "coulomb", static = 0.4, dynamic = 0.3, decay = 2, stiffness = 5, '
            "per_area = true }",
            Coulomb(0.4, 0.3, decay=2.0, stiffness=5.0, per_area=True),
            "coulomb: static",
        ),
        (
            '{ kind = "viscous-regularised", coefficient = 0.4, speed = 2 }',
            ViscousFriction(0.4, 2.0),
            "viscous-regularised: coeff",
        ),
    ],
)
def test_every_friction_comes_with_its_options(
    text: str, friction: Friction, description: str
) -> None:
    case = case_with(contact=f"{CONTACT}friction = {text}\n")
    for read in (case, parse_case(resolved_toml(case))):
        assert read.contact[0].friction is not None
        assert read.contact[0].friction.instance == friction
    assert dict(describe(case))["  friction"].startswith(description)


def test_several_contacts_of_one_pair_need_names() -> None:
    with pytest.raises(CaseError, match=r"contact\[1\].name: the name is used 2 times"):
        case_with(contact=CONTACT + CONTACT)
    case_with(contact=CONTACT + CONTACT + 'name = "second"\n')


def test_shapes_take_their_keywords_and_curves_as_tables() -> None:
    body = (
        '[[body]]\nname = "plate"\n'
        'geometry = { shape = "extruded", direction = [0, 0, 2],'
        ' curve = { shape = "arc", radius = 3 }, flip = true,'
        ' transform = [{ rotate = { axis = "x", degrees = 90 } }, { translate = [1, 0, 0] }] }\n'
    )
    made = case_with(body=body).body[0].geometry.body("plate", "mm")
    plain = body.replace("flip = true", "flip = false")
    other = case_with(body=plain).body[0].geometry.body("plate", "mm")
    uv = np.array([[0.25, 0.5]])
    (u0, u1), _ = made.patches[0].domain
    mirrored = np.array([[u0 + u1 - 0.25, 0.5]])
    np.testing.assert_allclose(
        made.patches[0].normal(mirrored), -other.patches[0].normal(uv), atol=1e-12
    )
    low, high = made.bounds()
    np.testing.assert_allclose(low[1], -2.0, atol=1e-12)
    np.testing.assert_allclose(high[0], 4.0, atol=1e-12)


def test_a_profile_gets_its_depth() -> None:
    body = BODY.replace(
        '{ shape = "plane" }',
        "{ profile = { nurbs = { degree = 1, knots = [0, 0, 1, 1],"
        " control_points = [[0, 0], [2, 0]] } }, depth = 3 }",
    )
    made = case_with(body=body).body[0].geometry.body("plate", "mm")
    np.testing.assert_allclose(made.bounds(), [[0, 0, -1.5], [2, 0, 1.5]])


def test_several_patches_make_one_body() -> None:
    body = BODY.replace(
        '{ shape = "plane" }',
        '{ patches = [{ shape = "plane" }, { shape = "sphere", radius = 2 }] }',
    )
    made = case_with(body=body).body[0].geometry.body("plate", "mm")
    assert made.name == "plate"
    assert len(made.patches) == 2


@pytest.mark.parametrize(
    ("text", "count", "facets"),
    [
        ('{ sample = { shape = "plane", nu = 4, nv = 5 } }', 20, None),
        ('{ grid = { shape = "plane", nu = 4, nv = 5 } }', 20, 24),
        ('{ random = { shape = "plane", n = 7, seed = 3 } }', 7, None),
        ("{ random = { box = [[0, 0, 0], [1, 2, 3]], n = 9 } }", 9, None),
        ("{ coordinates = [[0, 0, 0], [1, 1, 1]] }", 2, None),
    ],
)
def test_points_are_made_in_every_way(text: str, count: int, facets: int | None) -> None:
    spec = case_with(slave=SLAVE.replace("{ coordinates = [[0, 0, 1]] }", text)).slave[0].points
    slave = spec.slave("pad", "mm")
    assert len(slave) == count
    assert (None if slave.facets is None else len(slave.facets)) == facets
    assert spec.describe()


def test_a_grid_covers_its_shape_and_looks_the_same_way() -> None:
    text = '{ grid = { shape = "sphere", radius = 2, nu = 60, nv = 60 } }'
    spec = case_with(slave=SLAVE.replace("{ coordinates = [[0, 0, 1]] }", text)).slave[0].points
    slave = spec.slave("ball", "mm")
    assert slave.facets is not None
    corners = slave.points[slave.facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0.0).all()
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert math.isclose(area, 16 * math.pi, rel_tol=5e-3)
    # Poles give no facets without area.
    assert np.linalg.norm(normals, axis=1).min() > 1e-6


def test_points_are_placed_by_their_transform() -> None:
    text = "{ coordinates = [[1, 0, 0]], transform = [{ scale = 2.0 }, { translate = [0, 1, 0] }] }"
    spec = case_with(slave=SLAVE.replace("{ coordinates = [[0, 0, 1]] }", text)).slave[0].points
    np.testing.assert_array_equal(spec.slave("pad", "mm").points, [[2.0, 1.0, 0.0]])


def test_the_description_says_what_a_run_would_do() -> None:
    case = case_with()
    text = description(case)
    assert "0 to 10 ms in 5 steps of 2" in text
    assert "force kN, stress GPa" in text
    assert "pad against plate" in text
    rows = dict(describe(case))
    assert rows["body plate"] == "plane()"
    assert rows["  law"] == "force: curve 2 points from x = 0 to (1, 2), goes on straight beyond"
    assert rows["slave pad"] == "1 given points"
    bare = case_with(contact=CONTACT.replace('"force", curve = 2', '"adaptive"'))
    assert dict(describe(bare))["  law"] == "adaptive"


def test_reading_a_case_imports_no_cad_and_no_plots() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from contiga.case.schema import parse_case; "
        f"parse_case({HEAD + BODY + SLAVE + CONTACT!r}); "
        "heavy = {'OCP', 'rhino3dm', 'meshio', 'h5py', 'sklearn', 'plotly', 'matplotlib'}; "
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_free_points_that_nothing_touches_are_told(tmp_path: Path) -> None:
    text = """
units = { length = "m", mass = "kg", time = "s" }
time = { end = 0.1, step = 0.01 }
[[body]]
name = "ball"
geometry = { shape = "sphere" }
[[slave]]
name = "dust"
points = { grid = { shape = "plane", nu = 3, nv = 3 } }
mass = 0.1
motion = { kind = "free" }
"""
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(CaseError, match="contact: nothing can happen"):
        load_case(tmp_path / "case.toml")
