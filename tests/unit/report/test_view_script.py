"""The script of the page, run by node with a page and a plotly that only take notes."""

from __future__ import annotations

import json
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.io.out.vtkhdf import FieldSeries, FieldsWriter, read_fields
from contiga.io.out.vtkhdf_layout import Part
from contiga.rendering.shading import sharp_mesh
from contiga.report.frames import frames_of
from contiga.report.peak import at_frame, stacked
from contiga.report.places import Tie, ties_at
from contiga.report.run_folder import Units
from contiga.report.space import view_of

from .conftest import ball, mises_of, sheet, write_fields

NODE = shutil.which("node")
UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")
STAGE = """
const input = JSON.parse(require("fs").readFileSync(0, "utf8")), calls = [], wait = [];
function part(more) {
  const heard = {};
  return Object.assign({ heard, dataset: {}, setAttribute() {}, querySelectorAll: () => [],
    addEventListener(name, act) { heard[name] = act; } }, more);
}
const parts = { view: part({ data: input.traces.map(() => ({})) }), step: part(), play: part(),
  "step-time": part(), "view-data": part({ textContent: JSON.stringify(input.data) }) };
const group = part({ dataset: { what: "field" } });
const button = part({ dataset: { field: input.field }, parentElement: group });
const kind = part({ dataset: { what: "frame" } });
const frame = part({ dataset: { frame: "near" }, parentElement: kind });
const plot = { layout: { shapes: [{ name: "else" }, { name: "shown" }] } };
globalThis.document = { getElementById: (name) => parts[name],
  querySelectorAll: (what) => what.startsWith(".choice") ? [button, frame] : [plot] };
const laid = [], marked = [];
globalThis.Plotly = { restyle: (view, change) => calls.push(change),
  relayout: (view, change) => (view === plot ? marked : laid).push(change) };
globalThis.setTimeout = (act, after) => wait.push([act, after]);
globalThis.clearTimeout = () => {};
eval(input.script);
button.heard.click();
if (input.data.spans) frame.heard.click();
for (const step of input.steps) { parts.step.value = step; parts.step.heard.input(); }
const labels = [parts["step-time"].textContent], begun = calls.length;
parts.play.heard.click();
const shown = [parts.play.textContent];
let spent = 0;
while (wait.length) { const [act, after] = wait.shift(); spent += after; act(); }
labels.push(parts["step-time"].textContent); shown.push(parts.play.textContent);
const plain = (key, value) => ArrayBuffer.isView(value) ? Array.from(value) : value;
console.log(JSON.stringify({ calls, laid, marked, begun, labels, shown, spent }, plain));
"""


def played(
    series: FieldSeries, steps: list[int], field: str = "penetration", ties: tuple[Tie, ...] = ()
) -> dict:
    """What the script does when steps are chosen one after the other, and then all are played."""
    peak = at_frame(series, 2, None, ties)
    cluster = np.where(peak.in_contact, 0, -1)
    frames = frames_of(series, None, 2, peak._replace(cluster=cluster), UNITS, ties)
    two = tuple(
        f._replace(values=f.values | {"cluster": (f.rows % 2).astype(np.float32)})
        for f in frames.frames
    )
    view = view_of(peak._replace(cluster=cluster), frames._replace(frames=two), UNITS, ties)
    script = files("contiga.report").joinpath("view.js").read_text(encoding="utf-8")
    given = {"data": view.data, "script": script, "steps": steps, "field": field}
    given["traces"] = [trace["name"] for trace in view.figure.data]
    assert NODE is not None
    run = subprocess.run(
        [NODE, "-e", STAGE],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    data: dict = json.loads(run.stdout)
    return data


def write_turning(path: Path) -> None:
    """Two bodies that turn, each its own way, over a sheet that bends; nothing touches."""
    body, faces = ball(6)
    points, facets = sheet(5)
    parts = [
        Part("one", "body", len(body), faces),
        Part("other", "body", len(body), faces),
        Part("sheet", "slave", len(points), facets),
    ]
    n = 2 * len(body) + len(points)
    with FieldsWriter(path, parts) as writer:
        for step in range(4):
            one, other = Rotation.from_rotvec([[0.3, 0.1, 0.7], [-0.5, 0.9, 0.2]])
            up, bent = np.array([0.0, 0.0, 40.0]), 0.1 * step * points[:, :1] ** 2
            writer.append(
                float(step),
                np.vstack([
                    body @ (one**step).as_matrix().T + (1.0 + step) * up,
                    body @ (other**step).as_matrix().T - 3.0 * up,
                    points - bent * [0.0, 0.0, 1.0],
                ]),
                {
                    "contact_status": np.zeros(n, np.int32),
                    "penetration": np.zeros(n),
                    "normal": np.zeros((n, 3)),
                },
            )  # fmt: skip


def points_of(change: dict, trace: int) -> np.ndarray:
    return np.array([change[axis][trace] for axis in "xyz"]).T


def drawn_rows(series: FieldSeries, kind: str) -> np.ndarray:
    """The points that the vertices of a mesh stand at, several where it has a crease."""
    peak = at_frame(series, 2)
    if kind == "body":
        return sharp_mesh(peak.body_points, peak.body_triangles).rows
    return sharp_mesh(peak.slave_points, peak.slave_triangles).rows


pytestmark = pytest.mark.skipif(NODE is None, reason="node is not installed")


def test_what_is_inside_is_shown_of_all_points(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf", deforms=True)
    series = read_fields(tmp_path / "fields.vtkhdf")
    _, change, *_ = played(series, [3], "von_mises")["calls"]
    stress = mises_of(sheet()[0], 3)
    rows = drawn_rows(series, "slave")
    np.testing.assert_allclose(change["intensity"][1], stress[rows], rtol=1e-6)
    touching = at_frame(series, 3).in_contact
    np.testing.assert_allclose(change["marker.color"][2], stress[touching], rtol=1e-6)
    assert change["cmax"][1] == pytest.approx(mises_of(sheet()[0], 4).max())


@pytest.mark.parametrize("cloud", [False, True])
def test_a_step_that_is_chosen_is_shown(tmp_path: Path, cloud: bool) -> None:
    write_fields(tmp_path / "fields.vtkhdf", cloud=cloud)
    series = read_fields(tmp_path / "fields.vtkhdf")
    _, *calls = played(series, [0, 3, 1])["calls"]
    rows = drawn_rows(series, "slave")
    for step, change in zip((0, 3, 1), calls[:3], strict=True):
        scene = at_frame(series, step)
        body, slave = (stacked(series, step, kind)[0] for kind in ("body", "slave"))
        np.testing.assert_allclose(
            points_of(change, 0), body[drawn_rows(series, "body")], atol=1e-5
        )
        np.testing.assert_allclose(
            points_of(change, 1), slave[~scene.in_contact] if cloud else slave[rows], atol=1e-5
        )
        dots = points_of(change, 2).reshape(-1, 3)
        np.testing.assert_allclose(dots, slave[scene.in_contact], atol=1e-5)
        inside = scene.penetration[scene.in_contact]
        np.testing.assert_allclose(change["marker.color"][2], inside, rtol=1e-6)
        if not cloud:
            np.testing.assert_allclose(change["intensity"][1], scene.penetration[rows], rtol=1e-6)
        assert ("intensity" in change) is not cloud


def test_turning_bodies_and_bending_slaves_are_put_where_they_are(tmp_path: Path) -> None:
    write_turning(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    _, *calls = played(series, [0, 1, 3])["calls"]
    for step, change in zip((0, 1, 3), calls[:3], strict=True):
        for trace, kind in enumerate(("body", "slave")):
            there = stacked(series, step, kind)[0][drawn_rows(series, kind)]
            np.testing.assert_allclose(points_of(change, trace), there, atol=2e-5)


def test_a_button_brings_the_scene_to_what_touches(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    far = Tie("far", ("ground", "ball"), np.array([[900.0, 0.0, 0.0], [0.0, 0.0, 11.0]]))
    (change,) = played(read_fields(tmp_path / "fields.vtkhdf"), [0], ties=(far,))["laid"]
    assert sorted(change) == ["scene.xaxis.range", "scene.yaxis.range", "scene.zaxis.range"]
    assert change["scene.xaxis.range"][1] < 20.0


def test_springs_follow_their_bodies(tmp_path: Path) -> None:
    write_turning(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    on_body = np.asarray(series.points(0)[series.rows(series.parts[0].name)][0], float)
    belt = Tie("belt", (series.parts[0].name, "ground"), np.array([on_body, [50.0, 0.0, 0.0]]))
    change = played(series, [1], ties=(belt,))["calls"][1]
    first, second = points_of(change, -1)[:2].astype(float)
    moved = series.points(1)[series.rows(series.parts[0].name)][0]
    np.testing.assert_allclose(first, moved, atol=1e-4)
    np.testing.assert_allclose(second, [50.0, 0.0, 0.0])


def test_springs_follow_the_nodes_of_slaves(tmp_path: Path) -> None:
    write_turning(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    slave = series.parts[1]
    was, now = (np.asarray(series.points(k)[series.rows(slave.name)], float) for k in (0, 3))
    assert np.abs(now - was).max() > 0.1
    row = [0, int(np.argsort(np.linalg.norm(was - was[0], axis=1))[1])]
    at = np.array([was[5], was[row].mean(axis=0)])
    ends = ties_at(series, 3, [Tie("lead", (slave.name, slave.name), at)])[0]
    np.testing.assert_allclose(ends[0], now[5], atol=1e-4)
    np.testing.assert_allclose(ends[1], now[row].mean(axis=0), atol=1e-4)


def test_regions_are_coloured_a_facet_at_a_time(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    _, change, *_ = played(series, [3], "cluster")["calls"]
    scene = at_frame(series, 3)
    number = np.where(scene.in_contact, np.arange(len(scene.in_contact)) % 2, -1)
    facets = number[scene.slave_triangles].min(axis=1)
    assert set(facets) == {-1, 0}
    np.testing.assert_array_equal(change["intensity"][1], facets)
    assert change["intensitymode"][1] == "cell"
    assert change["cmax"][1] == 1.5


def test_playing_goes_on_to_the_end_in_six_seconds(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    told = played(series, [2, 0])
    assert told["shown"] == ["Pause", "Play"]
    assert told["labels"] == ["t = 0 ms", "t = 4 ms"]
    # The line of figures over time goes with the scene, the last step last.
    assert [list(one) for one in told["marked"]] == [["shapes[1].x1", "shapes[1].x0"]] * len(
        told["marked"]
    )
    assert told["marked"][-1]["shapes[1].x0"] == 4.0
    assert told["spent"] == 6000
    assert len(told["calls"]) == told["begun"] + 4
    at_the_peak = played(series, [2])
    assert at_the_peak["labels"][0] == "t = 2 ms, the peak"
    assert at_the_peak["spent"] == 3000
    # From the end it begins anew.
    assert len(played(series, [4])["calls"]) == 1 + 1 + 1 + 4
