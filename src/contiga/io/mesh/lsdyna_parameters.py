"""``*PARAMETER`` and ``*PARAMETER_EXPRESSION`` of LS-DYNA decks: values of ``&name``.

Parameters are read from blocks of cards, and fill the fields of others: both stand here.
Card layouts: LS-DYNA Keyword User's Manual, volume I, *PARAMETER. A name counts in small letters
and capitals alike; of two definitions the first stands, as by default there. A parameter that is
local (``_LOCAL``) is known in its file and those it includes.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from contiga.io.mesh.deck_text import fortran_number

_PAIRS = 4
_WIDTH, _LONG_WIDTH = 10, 20
_OPTIONS = {"LOCAL", "EXPRESSION"}
_KINDS = "ric"
_REFERENCE = re.compile(r"(-?)\s*&\s*(\w+)", re.ASCII)
_DOUBLE = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")
_WHOLE = 2.0**53
"""Largest whole number that is exact as a float."""

_OF_MATH = (
    *("sqrt", "exp", "log", "log10", "sin", "cos", "tan"),
    *("asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh"),
)

Value = int | float

_OPERATORS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Pow: lambda a, b: _as_whole(float(a) ** float(b), a, b),
    ast.Div: lambda a, b: _quotient(a, b),
}
_FUNCTIONS: dict[str, Callable[..., Value]] = {
    "abs": abs,
    "aint": lambda a: float(math.trunc(a)),
    "anint": lambda a: math.copysign(math.floor(abs(a) + 0.5), a),
    "int": math.trunc,
    "nint": lambda a: int(math.copysign(math.floor(abs(a) + 0.5), a)),
    "max": max,
    "min": min,
    "mod": lambda a, b: _as_whole(math.fmod(a, b), a, b),
    "sign": lambda a, b: abs(a) if b >= 0 else -abs(a),
    "float": float,
    **{name: getattr(math, name) for name in _OF_MATH},
}


class Card(NamedTuple):
    """One data line."""

    text: str
    line: int


class Unread(NamedTuple):
    """A field of a card that no reader has read."""

    text: str
    default: str
    """Meaning of a blank or 0 in the field; empty if that is 0."""


class Block(NamedTuple):
    """A keyword and its cards, comments left out."""

    keyword: str
    """Upper case, without the star: "ELEMENT_SHELL"."""
    cards: list[Card]
    long: bool
    """Whether it is in the long format, fields 20 wide."""
    path: Path
    line: int
    """Line of the keyword."""
    parameters: Parameters
    """Values of the names after & in its cards."""
    unread: dict[int, dict[str, Unread]]
    """Fields that are not blank and that no reader has read.

    They are by name, for each card that was cut into fields, by its line.
    """

    def title_and_cards(self) -> tuple[str, list[Card]]:
        """Return title and nonblank cards; a keyword in _TITLE has its title on the first card.

        A blank title is a card, too, so that it goes before blank cards do.
        """
        titled = self.keyword.endswith("_TITLE") and len(self.cards) > 0
        title = self.cards[0].text.strip() if titled else ""
        return title, [card for card in self.behind(titled) if card.text.strip()]

    def behind(self, count: int) -> list[Card]:
        """Return the cards after the first few, which are titles and numbers of the keyword."""
        self.mark_read(*self.cards[:count])
        return self.cards[count:]

    def mark_read(self, *cards: Card) -> None:
        """Mark some cards as read: their contents are known, or reported."""
        self.unread.update({card.line: {} for card in cards})

    def where(self, card: Card | None = None) -> str:
        """Return file, line and keyword, for messages."""
        line = f", line {card.line}" if card else ""
        return f"{self.path}{line}: *{self.keyword}"


class Left(NamedTuple):
    """A parameter that is not understood."""

    block: Block
    why: str
    line: int
    """Line of its card in the deck."""


class Parameters:
    """Values of the parameters of a file, and of the files that include it.

    `left` says what is not understood.
    """

    def __init__(self, outer: Parameters | None = None) -> None:
        self._outer = outer
        self._own: dict[str, str] = {}
        self.left: list[Left] = [] if outer is None else outer.left

    def filled(self, field: str) -> str:
        """Return a field with the value of its parameter; unchanged without one."""
        match = _REFERENCE.fullmatch(field)
        value = None if match is None else self._value(match[2].lower())
        if match is None or value is None:
            return field
        if not match[1]:
            return value
        return value[1:] if value.startswith("-") else f"-{value.removeprefix('+')}"

    def _value(self, name: str) -> str | None:
        if name in self._own:
            return self._own[name]
        return None if self._outer is None else self._outer._value(name)

    def read(self, block: Block) -> None:
        """Take the parameters of a block for which `is_parameters` holds."""
        expressions = "EXPRESSION" in block.keyword
        for line, name, text in _expressions(block) if expressions else _pairs(block):
            kind, name = name[:1].lower(), name[1:].strip().lower()
            value = self._value_of(text, kind) if expressions else self.filled(text)
            scope = self if "LOCAL" in block.keyword else self._root()
            if not name or kind not in _KINDS or value is None or "&" in value:
                self.left.append(Left(block, f"&{name} = {text.strip()}", line))
            elif scope._own.setdefault(name, value) != value:
                self.left.append(Left(block, f"&{name} again, the first one stands", line))

    def _root(self) -> Parameters:
        return self if self._outer is None else self._outer._root()

    def _value_of(self, text: str, kind: str) -> str | None:
        """Return the value of an expression; None if it is not understood or no number."""
        try:
            tree = ast.parse(_DOUBLE.sub("e", text.replace("&", " ")).strip().lower(), mode="eval")
            value = self._evaluate(tree.body)
        except (ArithmeticError, ValueError, TypeError, SyntaxError, RecursionError, MemoryError):
            return None
        if kind == "i":
            return f"{value:.0f}" if value == math.trunc(value) else None
        return repr(value) if math.isfinite(value) else None

    def _evaluate(self, node: ast.expr) -> Value:
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value  # type: ignore[return-value]
        if isinstance(node, ast.Name):
            return _number(self._value(node.id))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            value = self._evaluate(node.operand)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
            left, right = self._evaluate(node.left), self._evaluate(node.right)
            return _OPERATORS[type(node.op)](left, right)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            function = _FUNCTIONS.get(node.func.id)
            if function is not None:
                return function(*map(self._evaluate, node.args))
        raise ValueError(ast.dump(node))


def is_parameters(block: Block) -> bool:
    """Return whether a keyword gives parameters in a way that is understood."""
    first, *options = block.keyword.split("_")
    return first == "PARAMETER" and set(options) <= _OPTIONS


def _pairs(block: Block) -> Iterator[tuple[int, str, str]]:
    """Yield line, name, type letter and text of the value: four pairs per card."""
    width = _LONG_WIDTH if block.long else _WIDTH
    for card in block.cards:
        if "," in card.text:
            cells = [cell.strip() for cell in card.text.split(",")]
        else:
            starts = range(0, 2 * _PAIRS * width, width)
            cells = [card.text[start : start + width].strip() for start in starts]
        for name, value in zip(cells[::2], cells[1::2], strict=False):
            if name:
                yield card.line, name, value


def _expressions(block: Block) -> Iterator[tuple[int, str, str]]:
    """Yield line, name, type letter and expression, one per card.

    An empty name continues the expression before.
    """
    width = _LONG_WIDTH if block.long else _WIDTH
    expressions: list[tuple[int, str, list[str]]] = []
    for card in block.cards:
        name, comma, text = card.text.partition(",")
        if not comma or len(name) > width:
            name, text = card.text[:width], card.text[width:]
        if name.strip():
            expressions.append((card.line, name.strip(), [text]))
        elif expressions:
            expressions[-1][2].append(text.strip())
    yield from ((line, name, "".join(texts)) for line, name, texts in expressions)


def _number(text: str | None) -> Value:
    if text is None:
        raise ValueError("no such parameter")
    try:
        return int(text)
    except ValueError:
        return fortran_number(text)


def _as_whole(value: float, a: Value, b: Value) -> Value:
    """Return `value` as a whole number if both operands are."""
    whole = isinstance(a, int) and isinstance(b, int) and value == round(value)
    return int(value) if whole and abs(value) < _WHOLE else value


def _quotient(a: Value, b: Value) -> Value:
    """Return a quotient; refuse whole numbers with a remainder, whose meaning is unclear."""
    if isinstance(a, int) and isinstance(b, int):
        if a % b:
            raise ValueError("whole numbers with a remainder")
        return a // b
    return a / b
