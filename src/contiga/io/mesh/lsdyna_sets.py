"""``*SET_NODE`` and ``*SET_PART`` of an LS-DYNA deck: numbers under a number.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *SET.
"""

from __future__ import annotations

from collections.abc import Iterable

from contiga.io.mesh.lsdyna_cards import Block, fields, whole

_TEN = (10,) * 8
_OPTIONS = {"LIST", "GENERATE", "TITLE"}


def set_name(number: int) -> str:
    """What a set of nodes is called among the parts of a mesh."""
    return f"set of nodes {number}"


def is_set(block: Block, kind: str) -> bool:
    """Whether a keyword is a set of this kind ("NODE", "PART") that `read_sets` knows."""
    words = block.keyword.split("_")
    return words[:2] == ["SET", kind] and set(words[2:]) <= _OPTIONS


def read_sets(blocks: Iterable[Block], kind: str) -> dict[int, list[int]]:
    """Members of all sets of a kind, by number; a set that is given twice has both.

    Raises
    ------
    MeshError
        A field that should be a number is none.
    """
    sets: dict[int, list[int]] = {}
    for block in blocks:
        cards = [card for card in block.cards if card.text.strip()]
        if not is_set(block, kind) or not cards:
            continue
        if block.keyword.endswith("_TITLE"):
            cards.pop(0)
        if not cards:
            continue
        number = whole(fields(cards[0], block, _TEN)[0], block, cards[0])
        members = sets.setdefault(number, [])
        for card in cards[1:]:
            found = [n for text in fields(card, block, _TEN) if (n := whole(text, block, card))]
            if "GENERATE" in block.keyword:
                for first, last in zip(found[::2], found[1::2], strict=False):
                    members += range(first, last + 1)
            else:
                members += found
    return sets
