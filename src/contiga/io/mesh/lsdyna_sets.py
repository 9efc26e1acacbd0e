"""``*SET_NODE`` and ``*SET_PART`` of an LS-DYNA deck.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *SET.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from contiga.io.mesh.lsdyna_cards import (
    Block,
    OnSkip,
    layout,
    number_of_first_card,
    row_of,
    skip_unresolved,
)

_OPTIONS = {"LIST", "GENERATE", "TITLE"}
_HEAD = layout("SID DA1 DA2 DA3 DA4 SOLVER=MECH ~ITS")
_MEMBERS = layout("ID1 ID2 ID3 ID4 ID5 ID6 ID7 ID8")


def set_name(number: int) -> str:
    """Return the name of a set of nodes among the parts of a mesh."""
    return f"set of nodes {number}"


def is_set(block: Block, kind: str) -> bool:
    """Return whether a keyword is a set of this kind ("NODE", "PART") that `read_sets` reads.

    That is a list of members or of ranges, with or without a title.
    """
    words = block.keyword.split("_")
    return words[:2] == ["SET", kind] and set(words[2:]) <= _OPTIONS


def is_other_set(block: Block) -> bool:
    """Return whether a keyword is a set of nodes or parts of an unknown type."""
    return block.keyword.startswith(("SET_NODE", "SET_PART")) and not (
        is_set(block, "NODE") or is_set(block, "PART")
    )


def set_of(block: Block) -> tuple[str, int]:
    """Return kind ("NODE", "PART") and number of a set; 0 if it has no readable number."""
    return block.keyword.split("_")[1], number_of_first_card(block, _HEAD, "SID")


def read_sets(
    blocks: Iterable[Block], kind: str, on_skip: OnSkip | None = None
) -> dict[int, list[int]]:
    """Return the members of all sets of a kind, by number of the set, in the order of the deck.

    Members of a set that is given twice add up, and may repeat. Sets with unresolved parameters go
    to `on_skip`, or are an error without it.

    Raises
    ------
    MeshError
        A field that should be a number is not one.
    """
    sets: dict[int, list[int]] = {}
    for block in blocks:
        if not is_set(block, kind):
            continue
        _, cards = block.title_and_cards()
        if not cards:
            continue
        with skip_unresolved(block, on_skip):
            number = row_of(cards[0], block, _HEAD).whole("SID")
            members: list[int] = []
            for card in cards[1:]:
                row = row_of(card, block, _MEMBERS)
                ids = [member for member in map(row.whole, _MEMBERS.places) if member]
                if "GENERATE" in block.keyword:
                    ranges = map(range, ids[::2], [last + 1 for last in ids[1::2]])
                    members.extend(chain.from_iterable(ranges))
                else:
                    members += ids
            sets.setdefault(number, []).extend(members)
    return sets
