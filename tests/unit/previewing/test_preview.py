"""A preview shows every part where it stands, with gaps, ways and sides that closed forms tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from tests.figures import checked, figures_of

import contiga as cg
from contiga.previewing.page import figure_of, page_of
from contiga.previewing.stage import CONTACT_SIDE, Stage, stage_of
from contiga.previewing.words import gap_text, gap_with_approach_text, legend

ROOT = Path(__file__).resolve().parents[3]
DOWN = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -4.0]])


def scene(scale: float = 1.0, far: float = 0.0, motion: object = DOWN) -> cg.Simulation:
    """A ball 2 above a sheet whose last row is inactive, and a wall `far` away."""
    ball = cg.Body(cg.shapes.sphere(radius=20.0 * scale, centre=[0, 0, 22.0 * scale]), name="ball")
    grid = cg.clouds.sample(cg.shapes.plane(width=60 * scale, length=60 * scale), 5, 5)
    rows = np.arange(16).reshape(4, 4) + np.arange(4)[:, None]
    facets = np.stack([rows, rows + 5, rows + 6, rows + 1], axis=-1).reshape(-1, 4)
    idle = np.arange(25) < 20
    sheet = cg.Slave(grid, facets, active=idle, name="sheet")
    bodies = {"ball": (ball, motion)}
    if far:
        bodies["wall"] = cg.Body(cg.shapes.plane(width=60, length=80, centre=[far, 0, 0], axis="x"))
    return cg.Simulation(
        bodies=bodies,
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=0.1,
        title="Ball & sheet",
        units=("mm", "g", "ms"),
    )


def stage(**options: object) -> Stage:
    return stage_of(scene(**options))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_gap_is_that_of_the_closest_active_node(scale: float) -> None:
    (gap,) = stage(scale=scale).gaps
    assert gap.value == pytest.approx(2.0 * scale, rel=1e-9)
    np.testing.assert_allclose(gap.ends / scale, [[0, 0, 0], [0, 0, 2]], atol=1e-9)


def test_gaps_are_those_of_where_bodies_are_at_the_start() -> None:
    lifted = cg.motion.Translate([[0, 0, 0, 5.0], [1, 0, 0, -4.0]])
    (gap,) = stage(motion=lifted).gaps
    assert gap.value == pytest.approx(7.0)
    assert stage(motion=lifted).part("ball").box[0, 2] == pytest.approx(7.0, abs=0.02)


def test_a_node_that_begins_inside_is_told_so() -> None:
    sunk = stage(motion=cg.motion.Translate([[0, 0, 0, -3.0], [1, 0, 0, -4.0]]))
    assert gap_text(sunk.gaps[0], sunk.units) == "starts inside by 1 mm"


@pytest.mark.parametrize(
    ("nodes", "depth", "text", "warned"),
    [
        ([[0, 0, 0.5], [30, 0, -1], [30, 0, 5]], None, "gap 0.5 mm", "closer to plate than 0.5 mm"),
        ([[0, 0, 0.5], [0, 0, -3]], None, "gap 0.5 mm", "closer to plate than 0.5 mm"),
        ([[8, 0, -4], [0, 0, 7]], None, "gap 5 mm", "closer to plate than 5 mm"),
        ([[0, 0, 0.5], [0, 0, -1], [30, 0, -1]], None, "starts inside by 1 mm", "up to 1 mm"),
        ([[0, 0, 0.5], [0, 0, -3]], 4.0, "starts inside by 3 mm", "up to 3 mm"),
    ],
)
def test_past_the_border_of_a_sheet_and_far_behind_it_nothing_is_inside(
    nodes: list[list[float]], depth: float | None, text: str, warned: str
) -> None:
    plate = cg.Body(cg.shapes.plane(width=10.0, length=10.0), name="plate")
    cloud = cg.Slave(nodes, area=np.ones(len(nodes)), name="cloud")
    simulation = cg.Simulation(
        bodies={"plate": plate},
        slaves={"cloud": cloud},
        contacts=[cg.Contact(plate, cloud, law=cg.PenaltyLaw(1.0), depth=depth)],
        end=1.0,
        step=0.5,
        units=("mm", "g", "ms"),
    )
    shown = stage_of(simulation)
    assert gap_text(shown.gaps[0], shown.units) == text
    assert warned in " ".join(str(finding) for finding in simulation.check())


def test_ways_end_where_motions_do() -> None:
    (way,) = stage().paths
    assert len(way.lines) == 1
    np.testing.assert_allclose(way.lines[0, -1] - way.lines[0, 0], [0, 0, -4], atol=1e-12)
    turn = cg.motion.Rotate([[0, 0], [1, 90]], "y", [0, 0, 22])
    (turned,) = stage(motion=turn).paths
    middle, low, high = turned.lines
    np.testing.assert_allclose(middle, np.broadcast_to(middle[0], middle.shape), atol=0.05)
    x, y, z = (high - low)[0]
    assert max(x, z) > 39.9
    np.testing.assert_allclose((high - low)[-1], [z, y, -x], atol=1e-9)


def test_a_part_that_stays_has_no_way_and_a_free_one_its_velocity() -> None:
    assert stage(motion=cg.motion.Fixed()).paths == ()
    mass = cg.MassProperties(1.0, np.zeros(3), np.eye(3))
    free = stage(motion=cg.motion.Free(mass, velocity=[0, 0, -6.7]))
    assert free.paths == ()
    assert legend(free)[0][0] == "ball, free, starts at 6.7 mm/ms"


def test_the_arrow_of_a_velocity_ends_outside_its_body_and_behind_it() -> None:
    mass = cg.MassProperties(1.0, np.zeros(3), np.eye(3))
    moving = stage(motion=cg.motion.Free(mass, velocity=[3.0, 0.0, -4.0]))
    ((start, tip),) = moving.velocity_ends
    centre, towards = np.array([0.0, 0.0, 22.0]), np.array([0.6, 0.0, -0.8])
    np.testing.assert_allclose(np.cross(tip - start, towards), 0.0, atol=0.1)
    assert (tip - start) @ towards > 10.0
    assert (tip - centre) @ towards < -20.0  # the radius
    (trace,) = (
        t for t in figure_of(moving).data if t["type"] == "scatter3d" and "5 mm" in t["name"]
    )
    np.testing.assert_allclose(
        [trace[axis] for axis in "xyz"], np.stack([start, tip], 1), rtol=1e-5
    )


def test_normals_point_to_the_free_side() -> None:
    for arrow in stage().normals:
        outward = arrow.at - [0.0, 0.0, 22.0]
        assert arrow.vector @ outward / np.linalg.norm(outward) > 0.99


def test_both_sides_of_a_body_are_drawn_apart() -> None:
    shown = stage()
    traces = {trace.name: trace for trace in checked(figure_of(shown)).data}
    free, hidden = traces["ball"], traces["ball: contact side"]
    assert hidden.color == CONTACT_SIDE != free.color

    def radius(trace: object) -> np.ndarray:
        return np.sqrt(trace.x**2 + trace.y**2 + (trace.z - 22.0) ** 2)

    assert radius(hidden).max() < 20.0 < radius(free).min() + 0.02
    assert "sheet: inactive" in traces
    assert len(traces["sheet: inactive"].x) == 5
    assert traces["ball-sheet: gap 2 mm"].mode == "lines+markers+text"


def test_a_page_reads_offline_and_says_the_gap() -> None:
    text = page_of(stage())
    assert "<h1>Ball &amp; sheet</h1>" in text
    assert "<td>gap 2 mm</td>" in text
    assert "25 points, 5 of them inactive" in text
    assert "cdn." not in text.split("<script>")[0]
    assert list(figures_of(text)) == ["scene"]


@pytest.mark.parametrize(
    ("down", "said"), [(-1.5, ", never closer than 0.5 mm (t = 1 ms)"), (-3, "")]
)
def test_sides_that_never_meet_say_how_near_they_come(down: float, said: str) -> None:
    seen = stage(motion=cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, down]]))
    assert gap_with_approach_text(seen.gaps[0], seen.units) == f"gap 2 mm{said}"
    assert f"<td>gap 2 mm{said}</td>" in page_of(seen)


def test_springs_are_lines_in_the_scene_and_the_picture(tmp_path: Path) -> None:
    at = np.array([[0.0, 0.0, 22.0], [-60.0, 0.0, 60.0]])
    ball, sheet = (scene().bodies["ball"].body, scene().slaves["sheet"].slave)
    simulation = cg.Simulation(
        bodies={"ball": (ball, cg.motion.Free(1.0, inertia=np.eye(3)))},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=cg.PenaltyLaw(1.0))],
        springs=[cg.Spring(("ball", "ground"), at=at, curve=1.0, name="belt")],
        end=1.0,
        step=0.1,
    )
    shown = stage_of(simulation)
    assert shown.box[0, 0] == -60.0
    (line,) = (trace for trace in checked(figure_of(shown)).data if trace.name == "spring belt")
    np.testing.assert_allclose(np.array([line.x, line.y, line.z]).T, at)
    cg.preview(simulation).save(tmp_path / "a.png")
    picture = image.imread(tmp_path / "a.png")[..., :3]
    ochre = np.abs(picture - np.array([0xB0, 0x7D, 0x1E]) / 255.0).max(axis=-1) < 0.03
    assert ochre.sum() > 200


def test_a_preview_is_saved_shown_and_named(tmp_path: Path) -> None:
    shown = cg.preview(scene(far=1200.0))
    assert repr(shown) == "Preview('Ball & sheet', parts 3, ball-sheet gap 2 mm)"
    assert shown.gaps == {"ball-sheet": pytest.approx(2.0)}
    picture = image.imread(shown.save(tmp_path / "x.png"))
    assert picture.shape[:2] == (880, 1440)
    assert shown.save(tmp_path / "x.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    assert not hasattr(shown, "_repr_html_")  # a page in a notebook would be megabytes
    assert len(shown._repr_png_()) < 200_000
    assert [*tmp_path.glob("*")] == [*tmp_path.glob("x.*")]


def test_the_smallest_gap_is_seen_from_near_by_however_far_another_part_is(tmp_path: Path) -> None:
    picture = image.imread(cg.preview(scene(far=1200.0)).save(tmp_path / "x.png"))[:, :, :3]
    near = picture[100:700, 950:1400]
    assert (near.min(axis=2) < 0.97).mean() > 0.2
    red = (near[..., 0] > 0.7) & (near[..., 1] < 0.4)
    rows = np.flatnonzero(red.any(axis=1))
    assert len(rows) > 10
    assert 150 < rows.mean() < 450


def test_the_contact_side_has_its_own_colour_in_the_picture(tmp_path: Path) -> None:
    def terracotta(body: cg.Body) -> float:
        pad = cg.Slave([[0.0, 0.0, 3.0]], area=[1.0])
        model = cg.Simulation(
            bodies={"plate": body},
            slaves={"pad": pad},
            contacts=[cg.Contact(body, pad, law=cg.PenaltyLaw(1.0))],
            end=1.0,
            step=1.0,
        )
        picture = image.imread(cg.preview(model).save(tmp_path / "x.png"))[100:700, 50:850]
        return float((picture[..., 0] - picture[..., 2] > 0.15).mean())

    plate = cg.Body(cg.shapes.plane(width=40.0, length=40.0))
    assert terracotta(plate) < 0.02
    assert terracotta(plate.flipped()) > 0.1


@pytest.mark.parametrize("what", [3, None, ["case.toml"]])
def test_what_is_no_simulation_is_refused(what: object) -> None:
    with pytest.raises(cg.errors.InputError, match="nothing to preview"):
        cg.preview(what)


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(cg.errors.FileError, match="a preview is a picture or a page"):
        cg.preview(scene()).save(tmp_path / "x.pdf")


def test_a_plane_problem_is_seen_from_in_front() -> None:
    arc = cg.Body.from_profile(cg.NurbsCurve(1, [0, 0, 1, 1], [[-1, 0, 0], [1, 0, 0]]))
    line = cg.Slave([[-1.0, 1.0, 0.0], [1.0, 1.5, 0.0]], area=[1.0, 1.0])
    model = cg.Simulation(
        bodies={"arc": arc},
        slaves={"line": line},
        contacts=[cg.Contact(arc, line, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=1.0,
    )
    assert stage_of(model).plane
    assert not stage().plane
    assert len(cg.preview(model)._repr_png_()) > 10_000


def test_bodies_without_slaves_are_drawn() -> None:
    ball = cg.Body([cg.shapes.sphere()])
    falls = cg.motion.Free(ball.mass_properties(1.0))
    model = cg.Simulation(
        bodies={"ball": (ball, falls)},
        slaves={},
        contacts=[],
        gravity=[0, 0, -1.0],
        end=1,
        step=0.1,
    )
    assert not stage_of(model).plane
    assert len(cg.preview(model)._repr_png_()) > 10_000


def test_a_slave_that_is_the_skin_of_a_body_is_drawn_as_points() -> None:
    shown = stage_of(cg.build(cg.load_case(ROOT / "examples" / "03_two_parts.toml")))
    assert len(shown.part("ball skin").triangles) == 0
    assert len(shown.part("ball").triangles) > 0
