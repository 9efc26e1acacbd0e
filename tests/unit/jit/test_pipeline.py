"""Kernels are compiled by fewer of numba's passes, and become what all of them make."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import config, njit
from numba.core.errors import NumbaError
from numba.core.typed_passes import NopythonRewrites

from contiga.jit import pipeline
from contiga.jit.pipeline import FuseArrayExpressions, KernelCompiler

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")

TABLE = np.arange(12.0).reshape(4, 3)


def counted(table, x):
    """Loops, branches, tuples and calls of mathematics."""
    least, at = math.inf, (0, 0)
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            r = math.hypot(table[i, j] - x, 0.5 * x)
            if r < least:
                least, at = r, (i, j)
    return least, at


def whole(table, x):
    """Arithmetic with whole arrays."""
    return (table * x + table[:, ::-1]) / (1.0 + x * x)


def in_place(table, x):
    """An array that is changed as a whole."""
    own = table.copy()
    own[1] += x
    return -own


def code(function: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, shortened: bool) -> str:
    """The instructions that a function becomes, less what is named after a place in memory or
    numbered. Its data has the texts of errors, which name lines of source."""
    with monkeypatch.context() as patched:
        if not shortened:
            patched.setattr(pipeline, "UNUSED", ())
            patched.setattr(pipeline, "FuseArrayExpressions", NopythonRewrites)
        anew = njit(pipeline_class=KernelCompiler)(function)
        anew(TABLE, 2.5)
    (text,) = anew.inspect_asm().values()
    text = "\n".join(line for line in text.splitlines() if not line.startswith("\t."))
    return re.sub(r'"?\.bytes\.-?\d+"?|B\d+v\d+|\d{6,}|0x[0-9a-f]+|\.const\.[\w.$<>]+', "", text)


@pytest.mark.parametrize("function", [counted, whole, in_place])
def test_passes_that_are_left_out_change_no_code(
    function: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert code(function, monkeypatch, True) == code(function, monkeypatch, False)


def test_numbas_own_inlining_of_a_kernel_goes_on() -> None:
    callee = njit(inline="always")(lambda x: 2.0 * x)
    caller = njit(pipeline_class=KernelCompiler)(lambda x: callee(x) + 1.0)
    assert caller(3.0) == 7.0
    assert not callee.signatures  # its text was put there, and is no function


def test_a_kernel_with_a_function_in_it_does_not_compile() -> None:
    def closed(x):
        def add(y):
            return x + y

        return add(1.0)

    assert njit(closed)(2.0) == 3.0
    with pytest.raises(NumbaError):
        njit(pipeline_class=KernelCompiler)(closed)(2.0)


@pytest.mark.parametrize(
    ("function", "rewritten"), [(counted, False), (whole, True), (in_place, True)]
)
def test_arithmetic_is_looked_for_where_there_are_arrays(
    function: Callable[..., Any], rewritten: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[bool] = []
    run = NopythonRewrites.run_pass
    monkeypatch.setattr(
        NopythonRewrites, "run_pass", lambda self, state: (told.append(True), run(self, state))[1]
    )
    assert issubclass(FuseArrayExpressions, NopythonRewrites)
    anew = njit(pipeline_class=KernelCompiler)(function)
    np.testing.assert_equal(anew(TABLE, 2.5), function(TABLE, 2.5))
    assert bool(told) == rewritten
