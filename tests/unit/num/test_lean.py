"""What numba does once: what comes out is what it would make of it anyway."""

from __future__ import annotations

import _abc
import copy
import pickle
import weakref
from typing import Any

import numpy as np
import pytest
from numba import njit
from numba.core import errors, ir, lowering, typeinfer, types
from numba.core.compiler import DefaultPassBuilder
from numba.core.errors import LoweringError, NumbaError
from numba.core.registry import cpu_target
from numba.core.typed_passes import NopythonRewrites
from numba.core.typing.context import BaseContext
from numba.core.untyped_passes import InlineClosureLikes
from numba.extending import intrinsic, overload

from contiga.num.compiler import KernelCompiler
from contiga.num.jit import inlined
from contiga.num.lean import _replaced
from contiga.num.libraries import LinkedLibrary

compiled = njit(pipeline_class=KernelCompiler, error_model="numpy")
"""A kernel that is kept nowhere: each test compiles its own."""


class Called:
    """Counts the calls of a method that goes on as before, and whose kernels they were of."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> None:
        own, self.count, self.of = getattr(owner, name), 0, set[str]()

        def counted(*args: Any, **named: Any) -> object:
            self.count += 1
            self.of |= {state.func_id.func_name for state in args if hasattr(state, "func_id")}
            return own(*args, **named)

        static = isinstance(vars(owner)[name], staticmethod)
        monkeypatch.setattr(owner, name, staticmethod(counted) if static else counted)


def test_the_type_of_a_sum_is_asked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    @compiled
    def one(a, b):
        return a + b * a - b

    @compiled
    def other(a, b):
        return (a - b) * (a + b) + a * b - a

    assert one(2.0, 3.0) == 5.0
    asked = Called(monkeypatch, BaseContext, "resolve_overload")
    assert other(2.0, 3.0) == -1.0
    assert asked.count == 0


def test_the_type_depends_on_the_arguments() -> None:
    @compiled
    def halves(a):
        return a[0] + a[1] + a[0] // 2

    assert halves((3, 4)) == 8
    assert halves((3.0, 4.5)) == 8.5
    assert halves((3, 4.5)) == 8.5


@inlined()
def squared(a):
    return a * a


def test_a_function_in_place_of_its_calls_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    @compiled
    def one(a, b):
        return squared(a) + squared(b)

    @compiled
    def other(a, b):
        c = squared(a)
        return squared(c) - squared(b)

    read = Called(monkeypatch, DefaultPassBuilder, "define_untyped_pipeline")
    assert one(2.0, 3.0) == 13.0
    assert read.count == 1 + 1
    assert other(2.0, 3.0) == 7.0
    assert read.count == 2 + 1


def test_the_variables_of_a_statement_are_those_that_numba_finds() -> None:
    here = ir.Loc("file", 1)
    a, b, c = (ir.Var(ir.Scope(None, here), name, here) for name in "abc")
    call = ir.Expr.call(a, [b, c], (("name", b),), here)
    assert [var.name for var in call.list_vars()] == ["a", "b", "c", "b"]
    assert sorted(var.name for var in ir.Assign(call, c, here).list_vars()) == sorted("cabcb")
    assert ir.Jump(3, here).list_vars() == []
    built = ir.Expr.build_map([(a, b)], 1, {}, {}, here)
    assert {var.name for var in built.list_vars()} == {"a", "b"}


def test_functions_in_kernels_and_lists_are_still_put_in_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = Called(monkeypatch, InlineClosureLikes, "run_pass")

    @compiled
    def plain(a):
        return 2.0 * a[0]

    @compiled
    def within(a):
        def twice(x):
            return 2.0 * x

        return twice(a[0]) + twice(a[1])

    @compiled
    def listed(a):
        return np.array([2.0 * x for x in a]).sum()

    a = np.array([1.0, 2.0])
    assert plain(a) == 2.0
    assert looked.count == 0
    assert within(a) == 6.0
    assert looked.count > 0
    assert listed(a) == 6.0


def test_arithmetic_with_whole_arrays_and_fields_by_name_stay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = Called(monkeypatch, NopythonRewrites, "run_pass")
    row = np.dtype([("x", "f8"), ("n", "i8")])

    @compiled
    def plain(a):
        return -a[0] * a[1]

    @compiled
    def whole(a, b, rows):
        c = np.sqrt(a * a + 2.0 * b) - (-a)
        rows[0]["x"] = c[0]
        rows[1]["n"] = rows[0]["n"] + 1
        return c

    a, b, rows = np.array([1.0, 2.0]), np.array([4.0, 0.0]), np.zeros(2, row)
    assert plain(np.array([1.0, 2.0])) == -2.0
    np.testing.assert_array_equal(whole(a, b, rows), [4.0, 4.0])
    assert rows[0]["x"] == 4.0
    assert rows[1]["n"] == 1
    assert "whole" in looked.of
    assert "plain" not in looked.of


def test_errors_of_slices_and_of_numbas_own_kernels_are_raised() -> None:
    @compiled
    def sized(n):
        return np.empty(n).sum() * 0.0

    with pytest.raises(ValueError, match="negative dimensions"):
        sized(-1)


def test_what_numba_has_as_python_is_linked_and_not_run() -> None:
    @compiled
    def zeros(n):
        return np.zeros((n, n, 2, n)).sum()

    assert zeros(3) == 0.0
    (found,) = zeros.overloads.values()
    linked = found.library._linking_libraries
    assert any(isinstance(library, LinkedLibrary) for library in linked)


def test_what_a_numba_to_come_has_elsewhere_is_let_be() -> None:
    class Owner:
        def here(self) -> int:
            return 1

    own = Owner.here
    assert _replaced(Owner, "here", lambda self: 2) is own
    assert Owner().here() == 2
    assert _replaced(Owner, "elsewhere", lambda self: 3) is None
    assert not hasattr(Owner, "elsewhere")


def test_a_function_in_place_of_a_call_leaves_its_own_variables_behind() -> None:
    """Each place has variables of its own, and so has what is put in next time."""

    @inlined
    def swapped(a, b):
        keep = a
        a = b
        b = keep
        return a, b

    @compiled
    def twice(x, y):
        keep = 10.0 * x
        if x > 0.0:
            x, y = swapped(x, y)
        x, y = swapped(x, y + keep)
        return x, y, keep

    @compiled
    def once(x, y):
        return swapped(x, y)

    assert twice(1.0, 2.0) == twice.py_func(1.0, 2.0)
    assert once(1.0, 2.0) == (2.0, 1.0)
    assert twice(-1.0, 2.0) == twice.py_func(-1.0, 2.0)


def test_a_copied_scope_changes_without_the_first() -> None:
    where = ir.Loc("here", 1)
    scope = ir.Scope(None, where)
    for name in "aab":
        scope.redefine(name, where)
    block = ir.Block(scope, where)
    block.body = [ir.Assign(ir.Const(1, where), scope.get_exact("a.1"), where)]
    copied = copy.deepcopy(block)
    (statement,) = copied.body
    assert copied.scope is statement.target.scope is not scope
    assert statement.target is not block.body[0].target
    assert copied.scope.get("a").name == "a.1"
    assert copied.scope.redefine("a", where).name == "a.2"
    copied.scope.redefine("c", where)
    assert list(scope.localvars._con) == ["a", "a.1", "b"]
    assert (scope.redefined["a"], scope.get_versions_of("a")) == (1, {"a.1"})
    assert copied.scope.get_versions_of("a") == {"a.1", "a.2"}


def kinds_of_types(of: Any = types.Type) -> list[Any]:
    return [of, *(kind for below in of.__subclasses__() for kind in kinds_of_types(below))]


def test_nothing_was_declared_to_be_a_kind_of_types_that_is_none() -> None:
    kinds = kinds_of_types()
    assert len(kinds) > 100
    assert all(_abc._get_dump(kind)[0] == set() for kind in kinds)  # type: ignore[attr-defined]


def test_kinds_of_types_are_told_as_ever() -> None:
    assert isinstance(types.float64, types.Number)
    assert not isinstance(types.float64, types.Integer)
    assert not isinstance(1.0, types.Type)
    assert isinstance(types.UniTuple(types.int64, 2), types.BaseTuple)


def test_types_hash_as_ever_and_none_is_kept_for_it() -> None:
    pair = types.UniTuple(types.int64, 2)
    assert hash(pair) == hash(pair.key) == hash(types.UniTuple(types.int64, 2))
    assert pair == types.UniTuple(types.int64, 2) != types.UniTuple(types.int64, 3)
    once = [hash(types.UniTuple(types.int64, n)) for n in range(100, 200)]
    gone = weakref.ref(types.UniTuple(types.int64, 500))
    assert gone() is None
    # Others may stand where those stood, which are gone.
    assert [hash(types.UniTuple(types.int64, n)) for n in range(199, 99, -1)] == once[::-1]


def test_no_hash_goes_into_files() -> None:
    one = types.Array(types.float64, 7, "C")
    before = pickle.dumps(one)
    assert hash(one) == hash(pickle.loads(before))
    assert pickle.dumps(one) == before


def test_models_of_types_are_found_again() -> None:
    models = cpu_target.target_context.data_model_manager
    pair = types.UniTuple(types.int64, 2)
    assert models[pair] is models.lookup(pair) is vars(models)["_models"][id(pair)]
    assert models[pair]._fe_type is pair
    assert models.copy()[pair] is not models[pair]


def test_declarations_are_looked_for_where_there_are_more(monkeypatch: pytest.MonkeyPatch) -> None:
    def doubled(a: float) -> float:
        return 2.0 * a

    @compiled
    def one(a):
        return a + 1.0

    @compiled
    def other(a):
        return a - 1.0

    @compiled
    def calls(a):
        return doubled(a)

    assert one(1.0) == 2.0
    looked = Called(monkeypatch, BaseContext, "install_registry")
    assert other(1.0) == 0.0
    assert looked.count == 0
    overload(doubled)(lambda a: lambda a: 3.0 * a)
    assert calls(1.0) == 3.0
    assert looked.count > 0


def test_what_is_declared_while_it_looks_is_found_later(monkeypatch: pytest.MonkeyPatch) -> None:
    def tripled(a: float) -> float:
        return 3.0 * a

    own, waiting = BaseContext._load_builtins, [lambda: overload(tripled)(lambda a: lambda a: 7.0)]

    def loaded(self: Any) -> None:
        own(self)
        while waiting:  # as another thread may
            waiting.pop()()

    @compiled
    def one(a):
        return a + 2.0

    @compiled
    def calls(a):
        return tripled(a)

    monkeypatch.setattr(BaseContext, "_load_builtins", loaded)
    overload(lambda a: a)(lambda a: None)  # so that it looks
    assert one(1.0) == 3.0
    assert not waiting
    assert calls(1.0) == 7.0


def test_errors_say_where_numba_was(monkeypatch: pytest.MonkeyPatch) -> None:
    def untyped(a):
        return a.nothing + 1

    def unlowered(a):
        return raised(a)

    @intrinsic
    def raised(_context, of):
        def lower(*_: object) -> object:
            raise LoweringError("not to be had")

        return of(of), lower

    def told() -> list[Any]:
        found = []
        for function in (untyped, unlowered, abs):
            if function is abs:
                compiled(lambda a: abs(a))(1.0)
            else:
                with pytest.raises(NumbaError) as caught:
                    compiled(function)(1.0)
                found.append(str(caught.value))
            found.append(str(errors.loc_info["loc"]))
        return found

    ours = told()
    assert "typing of get attribute at" in ours[0]
    assert "lowering" in ours[2]
    (own,) = (
        cell.cell_contents
        for cell in errors.new_error_context.__exit__.__closure__
        if hasattr(cell.cell_contents, "__wrapped__")
    )
    for module in (errors, lowering, typeinfer):
        assert module.new_error_context is not own
        monkeypatch.setattr(module, "new_error_context", own)
    assert told() == ours
