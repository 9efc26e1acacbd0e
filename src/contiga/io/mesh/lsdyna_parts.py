"""*PART and *SECTION_SHELL of an LS-DYNA deck: what a part is called and how thick its shells are.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *PART and *SECTION_SHELL.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.io.mesh.lsdyna_cards import Block, Card, Leave, leaving_parameters, row_of
from contiga.records import FloatArray

# Cards that follow the one with the part's number, by option of the keyword.
_PART_OPTIONS = {"INERTIA": 3, "REPOSITION": 1, "CONTACT": 1, "PRINT": 1, "FIELD": 1}
_ANGLES_A_CARD = 8


class Inertia(NamedTuple):
    """What *PART_INERTIA says of a rigid part."""

    mass: float
    centre: tuple[float, float, float]
    node: int
    """Whose place is the centre; 0 where it is given."""
    tensor: tuple[float, float, float, float, float, float]
    """Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the centre."""
    velocity: tuple[float, float, float]
    spin: tuple[float, float, float]
    local: bool
    """Whether the tensor is in axes of its own."""


class Parts(NamedTuple):
    """Titles of parts, the thicknesses of their shells, and what rigid ones weigh."""

    titles: dict[int, str]
    sections: dict[int, int]
    """Section of each part."""
    thickness: dict[int, tuple[float, float, float, float]]
    """Of each shell section, at the four corners."""
    materials: dict[int, int]
    """Material of each part."""
    inertia: dict[int, Inertia]
    """Of the parts that say it."""

    def shell_thickness(self, part: NDArray[np.int64]) -> FloatArray:
        """(m, 4) thickness at the corners of shells of these parts; 0 where the deck says none."""
        numbers, inverse = np.unique(part, return_inverse=True)
        none = (0.0, 0.0, 0.0, 0.0)
        rows = [self.thickness.get(self.sections.get(int(n), -1), none) for n in numbers]
        return np.array(rows, dtype=np.float64).reshape(-1, 4)[inverse.ravel()]


def is_part(block: Block) -> bool:
    """Whether a keyword is a *PART all of whose cards `read_parts` knows."""
    first, *options = block.keyword.split("_")
    return first == "PART" and set(options) <= _PART_OPTIONS.keys()


def read_parts(blocks: Iterable[Block], leave: Leave | None = None) -> Parts:
    """Parts and shell sections of a deck; those with parameters without a value go to `leave`.

    Raises
    ------
    MeshError
        A field that should be a number is none.
    """
    parts = Parts({}, {}, {}, {}, {})
    for block in blocks:
        if block.keyword == "PART" or block.keyword.startswith("PART_"):
            with leaving_parameters(block, leave):
                _read_part(block, parts)
        elif block.keyword.startswith("SECTION_SHELL"):
            with leaving_parameters(block, leave):
                _read_section(block, parts)
    return parts


def _read_part(block: Block, parts: Parts) -> None:
    options = block.keyword.split("_")[1:]
    cards = iter(block.cards)
    for heading in cards:
        card = next(cards, None)
        if card is None:
            return
        number, section, material = row_of(card, block).wholes(0, 3)
        # What can fail comes first: a part is known with all its cards, or not at all.
        for option in options if is_part(block) else ():
            extra = [next(cards, None) for _ in range(_PART_OPTIONS[option])]
            if option == "INERTIA" and extra[0] is not None:
                if _has_local_axes(extra[0], block):
                    next(cards, None)
                given = [card for card in extra if card is not None]
                if len(given) == _PART_OPTIONS["INERTIA"]:
                    parts.inertia[number] = _inertia(given, block)
        parts.materials[number] = material
        parts.titles[number] = heading.text.strip()
        parts.sections[number] = section
        if not is_part(block):
            # Unknown cards follow: what comes next cannot be told to be a part.
            return


def _inertia(cards: list[Card], block: Block) -> Inertia:
    first, tensor, rates = (row_of(card, block) for card in cards)
    x, y, z, mass = first.reals(0, 4)
    xx, xy, xz, yy, yz, zz = tensor.reals(0, 6)
    vx, vy, vz, wx, wy, wz = rates.reals(0, 6)
    return Inertia(
        mass,
        (x, y, z),
        first.whole(5),
        (xx, xy, xz, yy, yz, zz),
        (vx, vy, vz),
        (wx, wy, wz),
        _has_local_axes(cards[0], block),
    )


def _has_local_axes(card: Card, block: Block) -> bool:
    """IRCS = 1 on the first inertia card: one more card with the axes follows."""
    return row_of(card, block).whole(4) == 1


def _read_section(block: Block, parts: Parts) -> None:
    """Two cards a section (number, …; four thicknesses), after a title if the keyword says so.

    Layered sections (ICOMP = 1) add their angles, eight a card. T2 to T4 are T1 where left out.
    """
    options = block.keyword.split("_")[2:]
    titled = "TITLE" in options
    single = any(option != "TITLE" for option in options)
    cards = iter(block.cards)
    while True:
        if titled:
            next(cards, None)
        first, second = next(cards, None), next(cards, None)
        if first is None or second is None:
            return
        head = row_of(first, block)
        number, layers = head.whole(0), head.whole(3)
        values = row_of(second, block).reals(0, 4)
        t1, t2, t3, t4 = (value if value > 0.0 else values[0] for value in values)
        parts.thickness[number] = (t1, t2, t3, t4)
        if single:
            # Options bring cards of their own, so that only the first section is certain.
            return
        if head.whole(6) == 1:
            # No more cards than there are, however many layers the card claims.
            deque(islice(cards, -(-max(layers, 2) // _ANGLES_A_CARD)), maxlen=0)
