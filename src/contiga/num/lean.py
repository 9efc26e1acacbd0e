"""What numba does again and again while it compiles, done once or not at all.

Two thirds of the time of compiling is Python's, in numba. Each of these leaves what is compiled as
it was, to the letter; where a numba to come has things elsewhere, it does them its own way.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from itertools import chain
from typing import Any
from weakref import ref

from llvmlite.binding import ffi
from numba.core import analysis, base, errors, ir, lowering, postproc, transforms, typeinfer
from numba.core.datamodel.manager import DataModelManager
from numba.core.inline_closurecall import InlineWorker
from numba.core.targetconfig import ConfigStack, TargetConfig
from numba.core.types.abstract import Type
from numba.core.types.functions import BaseFunction
from numba.core.typing.context import BaseContext as TypingContext


def _replaced(owner: Any, name: str, new: Callable[..., Any]) -> Any:
    """Put a function in place of numba's, and answer that: nothing is done where there is none."""
    own = vars(owner).get(name)
    if own is not None:
        setattr(owner, name, new)
    return own


def _compare_faster() -> None:
    """Let numba compare its options without writing them all out.

    It asks for every call it has to type whether the options are those of a version it has; that
    was a tenth of all compiling.
    """

    def equal(self: Any, other: Any) -> Any:
        if self is other:
            return True
        # What numba compares, written out; numba does it where one to come has it elsewhere.
        own, others = getattr(self, "_values", None), getattr(other, "_values", None)
        if own is None or others is None or type(self) is not type(other):
            return written_out(self, other)
        if own == others:
            return True
        options = type(self).options
        return all(
            own.get(name, options[name].default) == others.get(name, options[name].default)
            for name in {*own, *others}
        )

    written_out = TargetConfig.__eq__
    TargetConfig.__eq__ = equal
    TargetConfig.__hash__ = lambda self: hash(type(self))  # numba's own: of the options' names


def _type_calls_once() -> None:
    """Let numba remember what type a call has.

    For a sum of two numbers it asks ten templates, one after the other, each time one is written;
    that was an eighth of all compiling.
    """
    known: dict[Any, tuple[Any, Any]] = {}

    def get_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
        args = tuple(args)
        of = None if kws else (context, self, args, ConfigStack.top_or_none())
        if of not in known:
            signature = asked(self, context, args, kws)
            if of is None or signature is None:
                return signature
            flags = of[3] if of[3] is None else of[3].copy()
            known[(*of[:3], flags)] = signature, self.get_impl_key(signature)
            return signature
        signature, key = known[of]
        self._impl_keys[signature.args] = key
        return signature

    asked = _replaced(BaseFunction, "get_call_type", get_call_type)


def _lock_without_telling() -> None:
    """Have LLVM's lock taken and let go without an event of each.

    It is taken for every name that is asked for, and numba tells its listeners, of which there are
    some for each kernel that is being compiled.
    """
    lock = getattr(getattr(ffi, "lib", None), "_lock", None)
    for pair in list(getattr(lock, "_cblist", ())):
        if all(getattr(part, "__module__", "") == "numba.core.base" for part in pair):
            ffi.unregister_lock_callback(*pair)


def _list_variables_faster() -> None:
    """Let numba find the variables of a statement by the kinds of what it holds, as they come.

    It goes through all statements ten times for a kernel, and asked of each part whether it is one
    of six kinds.
    """
    plain = frozenset((str, ir.Loc, int, bool, type(None)))

    def variables(self: Any, held: Any) -> list[Any]:
        found: list[Any] = []
        gather(self, (held,), found)
        return found

    def gather(self: Any, parts: Any, found: list[Any]) -> None:
        for part in parts:
            kind = type(part)
            if kind is ir.Var:
                found.append(part)
            elif kind is dict:
                gather(self, part.values(), found)
            elif kind is tuple or kind is list:
                gather(self, part, found)
            elif kind not in plain:
                found.extend(asked(self, part))

    asked = _replaced(ir.Inst, "_rec_list_vars", variables)


def _read_inlined_once() -> None:
    """Let numba remember what it made of the text of a function that is put in place of its calls.

    It reads it anew for each of them; what it is given it copies before it changes anything.
    """
    known: dict[Any, Any] = {}

    def run_untyped_passes(self: Any, func: Any, enable_ssa: bool = False) -> Any:
        self.flags.enable_ssa = enable_ssa  # as numba does, which its caller relies on
        of = func, self.typingctx, self.flags
        if of not in known:
            known[(*of[:2], self.flags.copy())] = asked(self, func, enable_ssa)
        return known[of]

    asked = _replaced(InlineWorker, "run_untyped_passes", run_untyped_passes)


class _Entered(dict[Any, Any]):
    """Variables that are alive where a block begins, worked out where somebody asks for them."""

    def __init__(self, blocks: Any, lifetime: Any) -> None:
        super().__init__()
        self._blocks, self._lifetime = dict(blocks), lifetime

    def __contains__(self, block: Any) -> bool:
        return any(own is block for own in self._blocks.values())

    def __missing__(self, block: Any) -> Any:
        found = self._lifetime
        alive = analysis.compute_live_variables(
            found.cfg, self._blocks, found.usedefs.defmap, found.deadmaps.combined
        )
        self.update((own, alive[at]) for at, own in self._blocks.items())
        return self.get(block, set())


def _live_when_asked() -> None:
    """Let numba work out where variables live when something asks for it.

    It does so after each of its passes that may change that, six times for a kernel; only Python's
    own objects and generators ask.
    """

    def run(self: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
        own = self.func_ir
        if emit_dels or own.is_generator:
            asked(self, emit_dels, extend_lifetimes)
            return
        own.blocks = transforms.canonicalize_cfg(own.blocks)
        own.variable_lifetime = postproc.VariableLifetime(own.blocks)
        own.block_entry_vars = _Entered(own.blocks, own.variable_lifetime)
        own.generator_info = None

    asked = _replaced(postproc.PostProcessor, "run", run)


def _copy_no_lines() -> None:
    """Let numba share the lines of what it copies, which nothing changes: they were half of it."""
    if "__deepcopy__" not in vars(ir.Loc):
        ir.Loc.__deepcopy__ = lambda self, memo: self


def _copy_scopes_as_lists() -> None:
    """Let numba copy the list of a scope's variables and not each of them.

    It copies a function that is put in place of a call block by block, twice, and with every block
    all variables of the function. Of those in the list it reads names and lines, which nothing
    changes.
    """

    def copied(self: Any, memo: dict[int, Any]) -> Any:
        new = ir.Scope(self.parent, self.loc)
        new.localvars._con.update(self.localvars._con)
        new.redefined.update(self.redefined)
        new.var_redefinitions.update((k, set(v)) for k, v in self.var_redefinitions.items())
        memo[id(self)] = new
        return new

    known = {"parent", "localvars", "loc", "redefined", "var_redefinitions"}
    own = vars(ir.Scope(None, ir.Loc("", 0)))
    if set(own) == known and set(vars(own["localvars"])) == {"_con"}:
        ir.Scope.__deepcopy__ = copied


def _look_for_places_faster() -> None:
    """Let numba see by the code of a function whether it takes a place in the source.

    It asks `inspect` for the whole signature, each time that it writes a call.
    """

    def has_loc(function: Any) -> Any:
        code = getattr(function, "__code__", None)
        if code is None or hasattr(function, "__wrapped__") or hasattr(function, "__signature__"):
            return asked(function)
        return "loc" in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]

    asked = _replaced(base, "_has_loc", has_loc)


def _tell_kinds_of_types_faster() -> None:
    """Let numba ask what kind a type is as of any object.

    Its classes of types are abstract ones, and Python looks in a table whether something that is
    none of their kind was declared to be; of these nothing is.
    """
    kinds: Any = type(Type)
    if "__instancecheck__" not in vars(kinds):
        kinds.__instancecheck__ = type.__instancecheck__


def _hash_types_once() -> None:
    """Let numba remember the hashes of types, and see that a type is equal to itself.

    It looks types up all the time, and a tuple of tables hashes all their arrays each time. Hashes
    are not kept in the types: they are written to files, and another process has other hashes.
    """
    known: dict[int, int] = {}
    alive: dict[int, Any] = {}

    def hashed(self: Any) -> int:
        at = id(self)
        found = known.get(at)
        if found is None:

            def forget(_: Any) -> None:
                del known[at], alive[at]

            found = known[at] = asked(self)
            alive[at] = ref(self, forget)
        return found

    def equal(self: Any, other: Any) -> Any:
        return self is other or compared(self, other)

    asked = _replaced(Type, "__hash__", hashed)
    compared = _replaced(Type, "__eq__", equal)


def _find_models_faster() -> None:
    """Let numba find the model of a type by the object, which the model keeps alive."""

    def lookup(self: Any, of: Any) -> Any:
        known = self.__dict__.setdefault("_models", {})
        found = known.get(id(of))
        if found is None:
            found = asked(self, of)
            if getattr(found, "_fe_type", None) is of:
                known[id(of)] = found
        return found

    asked = _replaced(DataModelManager, "lookup", lookup)


def _refresh_when_there_is_more() -> None:
    """Let numba look for declarations of functions where there are more than there were.

    It goes through all its lists of them, twice for a kernel, also one that is only read.
    """

    def told(context: Any) -> tuple[int, int] | None:
        """How many modules there are, which numba may ask for their lists, and how long the lists
        are that it knows; none where a numba to come keeps them elsewhere."""
        typing = getattr(context, "typing_context", context)
        try:
            lists = chain(context._registries.items(), typing._registries.items())
            counts = [len(getattr(of, n)) for of, how in lists for n in how.registry_items]
        except AttributeError:
            return None
        return len(sys.modules), sum(counts)

    def refreshes(kind: Any) -> None:
        def refresh(self: Any) -> None:
            now = told(self)
            if now is None or vars(self).get("_told") != now:
                asked(self)
                self._told = now  # what is declared meanwhile has yet to be looked for

        asked = _replaced(kind, "refresh", refresh)

    refreshes(TypingContext)
    refreshes(base.BaseContext)


def _word_errors_when_there_are_any() -> None:
    """Let numba say where it was, for messages, when something is raised and not before.

    It does for every instruction and every constraint, by a generator.
    """
    place: Any = getattr(errors, "loc_info", None)
    home: Any = getattr(errors, "_numba_path", None)
    if place is None or home is None:
        return

    class Context:
        def __init__(self, *told: Any, **named: Any) -> None:
            self._told = told, named

        def __enter__(self) -> None:
            named = self._told[1]
            loc = named.get("loc")
            if loc is not None and not loc.filename.startswith(home):
                place.update(named)  # as numba does: messages in kernels name the last one

        def __exit__(self, _: Any, error: BaseException | None, __: Any) -> None:
            if error is None:
                return
            told, named = self._told
            kept = dict(place)
            try:
                with asked(*told, **named):
                    raise error
            finally:
                place.clear()
                place.update(kept)

    asked: Any = _replaced(errors, "new_error_context", Context)
    for module in (lowering, typeinfer):
        if vars(module).get("new_error_context") is asked:
            _replaced(module, "new_error_context", Context)


_compare_faster()
_type_calls_once()
_read_inlined_once()
_list_variables_faster()
_lock_without_telling()
_live_when_asked()
_copy_no_lines()
_copy_scopes_as_lists()
_look_for_places_faster()
_tell_kinds_of_types_faster()
_hash_types_once()
_find_models_faster()
_refresh_when_there_is_more()
_word_errors_when_there_are_any()
