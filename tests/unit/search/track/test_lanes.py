"""The fast lane of tracking gives what the careful walk gives."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numba import config, njit
from tests.stress.tracking import slivers
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.arrays.codes import TO_WALK
from contiga.jit.pipeline import CalledCompiler
from contiga.records import SurfacePlaces, empty_projection
from contiga.search.track.kernels import lanes_nb, track_nb
from contiga.search.track.kernels.lanes_nb import RECORD_SIZE
from contiga.search.track.track_records import Chunk, Path, PendingRows, empty_pending

PATCHES = {
    "polynomial": cg.shapes.bumpy_plate(),
    "rational": cg.shapes.torus(),
    "with poles": cg.shapes.sphere(),
}


def in_lanes(tables, points, start, out, before=None):
    """Feet of the rows that lanes can do into `out`; the flag of each row."""
    path = Path(np.empty((0, 3)) if before is None else before, points, empty_projection(0))
    records, flags = np.empty((len(points), RECORD_SIZE)), np.zeros(len(points), np.uint8)
    starts, chunk = SurfacePlaces(start.patch, start.uv), Chunk(0, len(points))
    left = empty_pending(len(points))
    m = track_nb.track_lanes(tables, path, starts, chunk, records, left, 0, out)
    flags[left.rows[:m]] = left.flags[:m]
    return flags


def lanes_only(body, points, start):
    out = empty_projection(len(points))
    return out, in_lanes(tracking_tables_of(body), points, start, out) == 0


def walk_only(body, points, start):
    tables, out = tracking_tables_of(body), empty_projection(len(points))
    n = len(points)
    rows, flags = np.arange(n, dtype=np.int32), np.full(n, TO_WALK, np.uint8)
    left = PendingRows(rows, flags, np.empty((n, 3)), start.patch, start.uv)
    track_nb.continue_pending(tables, points, left, n, out)
    return out


@pytest.mark.parametrize("kind", PATCHES)
def test_lanes_and_walk_agree(kind):
    body = cg.Body([PATCHES[kind]])
    rng = np.random.default_rng(0)
    uv = rng.random((3000, 2))
    p = PATCHES[kind].evaluate(uv) + rng.uniform(-0.02, 0.02, (3000, 1)) * PATCHES[kind].normal(uv)
    start = body.project(p)
    q = p + 0.002 * rng.normal(size=p.shape)
    fast, done = lanes_only(body, q, start)
    slow = walk_only(body, q, start)
    assert done.mean() > 0.6
    for a, b in ((fast.point, slow.point), (fast.gap, slow.gap), (fast.normal, slow.normal)):
        np.testing.assert_allclose(a[done], b[done], atol=1e-11)
    np.testing.assert_array_equal(fast.feature[done], slow.feature[done])


def moved(kind, way):
    """Points near a patch, their feet, and the points after a step."""
    patch = PATCHES[kind]
    body = cg.Body([patch])
    rng = np.random.default_rng(4)
    uv = rng.random((3000, 2))
    p = patch.evaluate(uv) + rng.uniform(-0.02, 0.02, (3000, 1)) * patch.normal(uv)
    return body, body.project(p), p + way * rng.normal(size=p.shape)


@pytest.mark.parametrize("kind", PATCHES)
def test_feet_that_leave_their_element_go_on_in_the_next(kind):
    """They are those that the walk finds; few are left to it."""
    body, start, q = moved(kind, 0.02)
    tables = tracking_tables_of(body)
    fast, done = lanes_only(body, q, start)
    box = tables.elements.table["box"]

    def elements(uv):
        inside = (box[:, ::2] <= uv[:, None]) & (uv[:, None] <= box[:, 1::2])
        return np.argmax(inside.all(axis=2), axis=1)

    slow = walk_only(body, q, start)
    left = elements(start.uv) != elements(slow.uv)
    assert left.sum() > 30
    assert done[left].mean() > 0.7
    gone = left & done
    for a, b in ((fast.point, slow.point), (fast.gap, slow.gap), (fast.normal, slow.normal)):
        np.testing.assert_allclose(a[gone], b[gone], rtol=0, atol=1e-11 * body.size)


def test_feet_that_leave_their_patch_go_on_in_the_next_however_that_is_turned():
    body = cg.Body(slivers(PATCHES["rational"]))
    rng = np.random.default_rng(3)
    at = body.project(rng.normal(size=(4000, 3)) * [1.0, 1.0, 0.3])
    p = at.point + rng.uniform(-0.02, 0.02, (4000, 1)) * at.normal
    q = p + 0.02 * rng.normal(size=p.shape)
    start = body.project(p)
    fast, done = lanes_only(body, q, start)
    slow = walk_only(body, q, start)
    left = slow.patch != start.patch
    assert left.mean() > 0.05
    assert done[left].mean() > 0.8
    np.testing.assert_allclose(fast.point[done], slow.point[done], rtol=0, atol=1e-11 * body.size)
    assert (fast.patch[done & left] != start.patch[done & left]).mean() > 0.99


@pytest.mark.parametrize("count", range(1, 17))
def test_so_many_rows_of_an_element_find_what_all_do(count):
    """Whatever stands in the lanes that are not used."""
    body, start, q = moved("rational", 1e-3)
    whole, done = lanes_only(body, q, start)
    few = type(start)(*(x[:count] for x in start))
    out, back = lanes_only(body, q[:count], few)
    np.testing.assert_array_equal(back, done[:count])
    for a, b in zip(out, whole, strict=True):
        np.testing.assert_array_equal(a[back], b[:count][back])


def test_binned_in_chunks_or_as_a_whole_the_feet_are_the_same(monkeypatch):
    body, start, q = moved("polynomial", 0.01)
    whole = body.project(q, start=start, mode="track")
    monkeypatch.setattr("contiga.search.track.project.rows_per_chunk", lambda *_: 700)
    chunks = body.project(q, start=start, mode="track")
    for a, b in zip(chunks, whole, strict=True):
        np.testing.assert_array_equal(a, b)


def vector_code(kernel, *arguments):
    """LLVM's code of a kernel of lanes, which is compiled by itself."""
    if config.DISABLE_JIT:
        pytest.skip("nothing is compiled")
    compiled = njit(error_model="numpy", pipeline_class=CalledCompiler)(kernel.py_func)
    compiled(*arguments)
    assert kernel._compiler.pipeline_class is CalledCompiler
    (code,) = compiled.inspect_llvm().values()
    return code


@pytest.mark.parametrize("name", ["newton_rational", "newton_polynomial"])
def test_the_loop_over_the_lanes_is_vector_code(name):
    """As it is not where the kernel is compiled within its callers: half the speed of tracking."""
    lanes = np.zeros((lanes_nb.BANKS, lanes_nb.ROWS * lanes_nb.BANK_WIDTH))
    code = vector_code(
        getattr(lanes_nb, name), lanes, lanes_nb.BANKS, np.ones(lanes_nb.ELEMENT_SIZE)
    )
    fused = re.findall(r"call <(\d+) x double> @llvm\.fma", code)
    assert len(fused) > 50
    assert set(fused) == {str(lanes_nb.BANK_WIDTH)}
    assert "double @llvm.fma.f64" not in code.replace("declare double @llvm.fma.f64", "")


def test_points_on_the_surface_are_done_in_the_fast_lane():
    body = cg.Body([PATCHES["rational"]])
    uv = np.random.default_rng(1).random((2000, 2))
    p = PATCHES["rational"].evaluate(uv)
    start = body.project(p)
    _, done = lanes_only(body, p, start)
    assert done.mean() > 0.95
