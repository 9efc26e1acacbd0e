"""``*PARAMETER`` and ``*PARAMETER_EXPRESSION`` of LS-DYNA decks: values of ``&name``.

Parameters are read from blocks of cards and fill the fields of other cards, so blocks are defined
here, too. Card layouts: LS-DYNA Keyword User's Manual, volume I, *PARAMETER. Names ignore case; of
two definitions the first one counts, as by default there. A parameter that is local (``_LOCAL``)
exists in its file and the files that this one includes.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections import ChainMap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from contiga.io.mesh.deck_text import fortran_number

_PAIRS_PER_CARD = 4
WIDTH, LONG_WIDTH = 10, 20
"""Columns of a field in the standard and in the long format."""
_OPTIONS = {"LOCAL", "EXPRESSION"}
_TYPE_LETTERS = "ric"
_REFERENCE = re.compile(r"(-?)\s*&\s*(\w+)", re.ASCII)
_DOUBLE = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")
_MAX_EXACT_WHOLE = 2.0**53
"""Largest whole number that is exact as a float."""

_MATH_NAMES = (
    *("sqrt", "exp", "log", "log10", "sin", "cos", "tan"),
    *("asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh"),
)

Value = int | float


def _as_whole(value: float, a: Value, b: Value) -> Value:
    """Return `value` as an int if it and both operands are whole and it is exact as a float."""
    is_whole = isinstance(a, int) and isinstance(b, int) and value == round(value)
    return int(value) if is_whole and abs(value) < _MAX_EXACT_WHOLE else value


def _quotient(a: Value, b: Value) -> Value:
    """Return a quotient; refuse whole numbers with a remainder, whose meaning is unclear."""
    if isinstance(a, int) and isinstance(b, int):
        if a % b:
            raise ValueError("whole numbers with a remainder")
        return a // b
    return a / b


_OPERATORS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Pow: lambda a, b: _as_whole(float(a) ** float(b), a, b),
    ast.Div: _quotient,
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
    **{name: getattr(math, name) for name in _MATH_NAMES},
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
    """A keyword and its cards, without comments."""

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
    """Nonblank fields that no reader has read, by name, for the line of each card that was cut.

    Readers remove the fields they read.
    """

    def title_and_cards(self) -> tuple[str, list[Card]]:
        """Return title and nonblank cards; a keyword in _TITLE has its title on the first card.

        Without a title it is "". A blank title is a card, too, so the title is removed before the
        blank cards are. The title is marked as read.
        """
        titled = self.keyword.endswith("_TITLE") and len(self.cards) > 0
        title = self.cards[0].text.strip() if titled else ""
        return title, [card for card in self.behind(titled) if card.text.strip()]

    def behind(self, count: int) -> list[Card]:
        """Return the cards after the first `count`, which are titles and count as read."""
        self.mark_read(*self.cards[:count])
        return self.cards[count:]

    def mark_read(self, *cards: Card) -> None:
        """Mark some cards as read: their contents are used, or reported."""
        self.unread.update({card.line: {} for card in cards})

    def where(self, card: Card | None = None) -> str:
        """Return file, line of the card and keyword for messages; without a card no line."""
        line = f", line {card.line}" if card else ""
        return f"{self.path}{line}: *{self.keyword}"


class UnresolvedParameter(NamedTuple):
    """A parameter that is not understood."""

    block: Block
    reason: str
    line: int
    """Line of its card in the deck."""


class Parameters:
    """Values of the parameters of a file, and of the files that include it.

    `unresolved` lists the parameters that are not understood, in all files of the deck.
    """

    def __init__(self, outer: Parameters | None = None) -> None:
        self._values: ChainMap[str, str] = (
            ChainMap() if outer is None else outer._values.new_child()
        )
        self.unresolved: list[UnresolvedParameter] = [] if outer is None else outer.unresolved

    def filled(self, field: str) -> str:
        """Return the value of the parameter that a field refers to; −&name reverses its sign.

        Other fields, and those of an unknown parameter, are returned unchanged.
        """
        match = _REFERENCE.fullmatch(field)
        value = None if match is None else self._values.get(match[2].lower())
        if match is None or value is None:
            return field
        if not match[1]:
            return value
        return value[1:] if value.startswith("-") else f"-{value.removeprefix('+')}"

    def read(self, block: Block) -> None:
        """Define the parameters of a block for which `is_parameters` holds.

        Those that are not understood, or have another value already, which stands, are added to
        `unresolved`. Parameters that are not _LOCAL are defined for the whole deck.
        """
        has_expressions = "EXPRESSION" in block.keyword
        scope = self._values.maps[0 if "LOCAL" in block.keyword else -1]
        for line, name, text in _definitions(block, has_expressions):
            kind, name = name[:1].lower(), name[1:].strip().lower()
            value = self._evaluated(text, kind) if has_expressions else self.filled(text)
            if not name or kind not in _TYPE_LETTERS or value is None or "&" in value:
                reason = f"&{name} = {text.strip()}"
            elif scope.setdefault(name, value) != value:
                reason = f"&{name} again, the first one stands"
            else:
                continue
            self.unresolved.append(UnresolvedParameter(block, reason, line))

    def _evaluated(self, text: str, kind: str) -> str | None:
        """Return the value of an expression as text; None if it is not understood.

        A value of kind "i" that is not whole, or one that is not finite, is None too.
        """
        try:
            tree = ast.parse(_DOUBLE.sub("e", text.replace("&", " ")).strip().lower(), mode="eval")
            value = self._evaluate(tree.body)
            if kind == "i":
                return f"{value:.0f}" if value == math.trunc(value) else None
            return repr(value) if math.isfinite(value) else None
        except (ArithmeticError, ValueError, TypeError, SyntaxError, RecursionError, MemoryError):
            return None

    def _evaluate(self, node: ast.expr) -> Value:
        """Return the value of numbers, parameters, + − * / **, and functions of `_FUNCTIONS`.

        Any other syntax, and an unknown name, is a ValueError; arithmetic errors pass through.
        """
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value  # type: ignore[return-value]
        if isinstance(node, ast.Name) and node.id in self._values:
            text = self._values[node.id]
            try:
                return int(text)
            except ValueError:
                return fortran_number(text)
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
    """Return whether a keyword defines parameters in a form that is understood."""
    first, *options = block.keyword.split("_")
    return first == "PARAMETER" and set(options) <= _OPTIONS


def _definitions(block: Block, has_expressions: bool) -> Iterator[tuple[int, str, str]]:
    """Yield line, type letter with name, and text of each value or expression.

    A card has four values, with commas also more; those without a name are skipped. If
    `has_expressions`, it has one expression instead, whose name a comma may end; without a name it
    continues the expression before.
    """
    width = LONG_WIDTH if block.long else WIDTH
    if has_expressions:
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
        return
    for card in block.cards:
        if "," in card.text:
            cells = [cell.strip() for cell in card.text.split(",")]
        else:
            starts = range(0, 2 * _PAIRS_PER_CARD * width, width)
            cells = [card.text[start : start + width].strip() for start in starts]
        for name, value in zip(cells[::2], cells[1::2], strict=False):
            if name:
                yield card.line, name, value
