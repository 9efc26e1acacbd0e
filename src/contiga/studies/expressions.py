"""Arithmetic with the variables of a study: ``-speed * sin(radians(angle))``."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from contiga.errors import CaseError
from contiga.io.naming import closest

_BINARY: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_UNARY: dict[type[ast.AST], Callable[[Any], Any]] = {
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{
        name: getattr(math, name)
        for name in (
            *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot"),
            *("sqrt", "exp", "log", "log10", "radians", "degrees", "floor", "ceil"),
        )
    },
    "abs": abs,
    "min": min,
    "max": max,
    "round": round,
    "int": int,
}
_CONSTANTS = {"pi": math.pi, "true": True, "false": False}
_NODES = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Call, ast.Name)
_ALLOWED = "numbers, names of variables, + - * / % **, comparisons, and, or, not, and functions: "
_ALLOWED += ", ".join(_FUNCTIONS)
_MAX_CHARACTERS = 500
"""Largest number of characters of a rule."""
_MAX_POWER = 64
"""Largest exponent: whole numbers are exact, and a larger power would take for ever."""


class Expression:
    """An expression of numbers and names, checked when it is made and evaluated later.

    Parameters
    ----------
    text : as it stands in the file
    where : the key it stands under, for messages

    Raises
    ------
    CaseError
        It is no arithmetic, is longer than 500 characters, or calls an unknown function.

    >>> Expression("2 * thickness + min(3, 4)", "rule").value({"thickness": 5.0})
    13.0
    """

    def __init__(self, text: str, where: str) -> None:
        self.text, self.where = text, where
        try:
            tree = ast.parse(text if len(text) <= _MAX_CHARACTERS else "?", mode="eval")
        except (SyntaxError, ValueError, RecursionError) as error:
            raise self._error("is not an expression") from error
        self._tree = tree.body
        self.names = tuple(dict.fromkeys(self._check(tree.body)))
        """Names of variables in it."""

    def check_names(self, names: list[str]) -> None:
        """Raise a CaseError at the first name that no variable has."""
        for name in self.names:
            if name not in names:
                raise CaseError(
                    f"no variable is called {name!r}",
                    where=self.where,
                    found=self.text,
                    allowed=", ".join(names) or "none: no variable has a name",
                    remedy=closest(name, names),
                )

    def value(self, names: Mapping[str, Any]) -> Any:
        """Return the value of the expression for values of the variables by name.

        A power with an exponent beyond ±64 is one of floating-point numbers.

        Raises
        ------
        CaseError
            It cannot be worked out: a division by zero, text where a number is wanted.
        """
        try:
            return self._value(self._tree, names)
        except (ArithmeticError, ValueError, TypeError) as error:
            values = ", ".join(f"{name} = {names[name]!r}" for name in self.names)
            text = f"{self.text} with {values}" if values else self.text
            raise CaseError(
                f"cannot be worked out ({error})", where=self.where, found=text
            ) from error

    def _error(self, rule: str) -> CaseError:
        return CaseError(rule, where=self.where, found=self.text, allowed=_ALLOWED)

    def _check(self, node: ast.AST) -> list[str]:
        """Return the names of variables in a part of the tree, repeated as they appear.

        Nodes of other kinds, unknown functions and arguments by keyword raise a CaseError.
        """
        if isinstance(node, ast.Constant):
            if not isinstance(node.value, int | float | str):
                raise self._error("is not an expression")
            return []
        if isinstance(node, ast.Name):
            return [] if node.id in _CONSTANTS else [node.id]
        if not isinstance(node, _NODES):
            raise self._error("is not an expression")
        if isinstance(node, ast.Call):
            named = isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS
            if not named or node.keywords:
                raise self._error("calls an unknown function")
            parts: list[ast.expr] = node.args
        elif isinstance(node, ast.Compare):
            self._check_operators(node.ops, _BINARY)
            parts = [node.left, *node.comparators]
        elif isinstance(node, ast.BoolOp):
            parts = node.values
        elif isinstance(node, ast.BinOp):
            self._check_operators([node.op], _BINARY)
            parts = [node.left, node.right]
        else:
            assert isinstance(node, ast.UnaryOp)
            self._check_operators([node.op], _UNARY)
            parts = [node.operand]
        return [name for part in parts for name in self._check(part)]

    def _check_operators(self, operators: list[Any], allowed: Mapping[type[ast.AST], Any]) -> None:
        if any(type(symbol) not in allowed for symbol in operators):
            raise self._error("is not an expression")

    def _value(self, node: ast.AST, names: Mapping[str, Any]) -> Any:
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name):
            return _CONSTANTS[node.id] if node.id in _CONSTANTS else names[node.id]
        if isinstance(node, ast.Call):
            assert isinstance(node.func, ast.Name)
            return _FUNCTIONS[node.func.id](*(self._value(part, names) for part in node.args))
        if isinstance(node, ast.BoolOp):
            truths = (bool(self._value(part, names)) for part in node.values)
            return all(truths) if isinstance(node.op, ast.And) else any(truths)
        if isinstance(node, ast.UnaryOp):
            return _UNARY[type(node.op)](self._value(node.operand, names))
        if isinstance(node, ast.BinOp):
            left, right = self._value(node.left, names), self._value(node.right, names)
            if isinstance(node.op, ast.Pow) and abs(right) > _MAX_POWER:
                left = float(left)
            return _BINARY[type(node.op)](left, right)
        assert isinstance(node, ast.Compare)
        values = [self._value(part, names) for part in (node.left, *node.comparators)]
        pairs = zip(node.ops, values[:-1], values[1:], strict=True)
        return all(_BINARY[type(op)](a, b) for op, a, b in pairs)
