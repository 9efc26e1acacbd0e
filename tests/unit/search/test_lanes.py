"""The fast lane of tracking gives what the careful walk gives."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numba import config, njit

import contiga as cg
from contiga.num.compiler import CalledCompiler
from contiga.records import empty_projection
from contiga.search.kernels import lanes_nb, project_nb
from contiga.search.kernels.bins_nb import BY_ROW, GO_ON
from contiga.search.tables import tables_of

PATCHES = {
    "polynomial": cg.shapes.bumpy_plate(),
    "rational": cg.shapes.torus(),
    "with poles": cg.shapes.sphere(),
}


def in_lanes(tables, points, start, results, before=None, wanted=0):
    path = np.empty((0, 3)) if before is None else before, points
    starts = start.patch, start.uv
    project_nb.track_lanes(tables, path, starts, wanted, results, 0)


def lanes_only(body, points, start):
    out, back = empty_projection(len(points)), np.zeros(len(points), np.uint8)
    in_lanes(tables_of(body), points, start, (out, back))
    return out, back == 0


def walk_only(body, points, start):
    tables, out = tables_of(body), empty_projection(len(points))
    rows = np.arange(len(points), dtype=np.int32)
    project_nb.project_tracked(tables, points, (start.patch, start.uv), rows, out, 0)
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
    """A second time through the lanes finds what the walk finds; few are left to it."""
    body, start, q = moved(kind, 0.02)
    tables = tables_of(body)
    out, back = empty_projection(len(q)), np.zeros(len(q), np.uint8)
    in_lanes(tables, q, start, (out, back))
    gone_on = np.flatnonzero(back == GO_ON)
    assert len(gone_on) > 30
    others = [np.delete(array, gone_on, axis=0) for array in out]
    in_lanes(tables, q, start, (out, back), wanted=GO_ON)
    assert not (back == GO_ON).any()
    for array, before in zip(out, others, strict=True):
        np.testing.assert_array_equal(np.delete(array, gone_on, axis=0), before)
    done = gone_on[back[gone_on] == 0]
    assert len(done) > 0.7 * len(gone_on)
    slow = walk_only(body, q, start)
    for a, b in ((out.point, slow.point), (out.gap, slow.gap), (out.normal, slow.normal)):
        np.testing.assert_allclose(a[done], b[done], rtol=0, atol=1e-11 * body.size)


def test_a_foot_that_leaves_over_a_seam_is_left_to_the_walk():
    """Beyond it the parameters do not go on: none is flagged to be gone on with."""
    patch = PATCHES["rational"]
    body = cg.Body([patch])
    (u0, u1), _ = patch.domain
    uv = np.column_stack([np.full(50, u1 - 1e-4 * (u1 - u0)), np.linspace(0.1, 0.9, 50)])
    uv[:, 1] = patch.domain[1][0] + uv[:, 1] * np.diff(patch.domain[1])
    beyond = np.column_stack([np.full(50, u0 + 0.02 * (u1 - u0)), uv[:, 1]])
    start = body.project(patch.evaluate(uv))
    tables, q = tables_of(body), patch.evaluate(beyond)
    out, back = empty_projection(50), np.zeros(50, np.uint8)
    in_lanes(tables, q, start, (out, back))
    assert (back == BY_ROW).all()
    feet = body.project(q, start=start, mode="track")
    np.testing.assert_allclose(feet.gap, 0.0, rtol=0, atol=1e-12 * body.size)


def test_binned_in_chunks_or_as_a_whole_the_feet_are_the_same(monkeypatch):
    body, start, q = moved("polynomial", 0.01)
    whole = body.project(q, start=start, mode="track")
    monkeypatch.setattr("contiga.search.project._chunk", lambda n, elements: 700)
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
    lanes = np.zeros(lanes_nb.ROWS * lanes_nb.LANES)
    code = vector_code(getattr(lanes_nb, name), lanes, np.ones(64), 1e-20)
    assert len(re.findall(r"call <\d+ x double> @llvm\.fma", code)) > 50


def test_points_on_the_surface_are_done_in_the_fast_lane():
    body = cg.Body([PATCHES["rational"]])
    uv = np.random.default_rng(1).random((2000, 2))
    p = PATCHES["rational"].evaluate(uv)
    start = body.project(p)
    _, done = lanes_only(body, p, start)
    assert done.mean() > 0.95
