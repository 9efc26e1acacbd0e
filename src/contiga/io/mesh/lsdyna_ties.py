"""Nodes of an LS-DYNA deck that are fixed or attached to a rigid part.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *BOUNDARY_SPC and *CONSTRAINED_EXTRA_NODES.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import NamedTuple

from contiga.errors import MeshError
from contiga.io.mesh.lsdyna_cards import Block, layout, row_of
from contiga.io.mesh.lsdyna_sets import set_name

_HELD = ("BOUNDARY_SPC_SET", "BOUNDARY_SPC_NODE")
_EXTRA = ("CONSTRAINED_EXTRA_NODES_SET", "CONSTRAINED_EXTRA_NODES_NODE")
# Nodes of a case have no turns, which the last three fields hold.
_SPC = layout("NID CID DOFX DOFY DOFZ ~DOFRX ~DOFRY ~DOFRZ")
_EXTRA_NODES = layout("PID NID IFLAG")


class NodeTie(NamedTuple):
    """A card about some nodes."""

    nodes: str
    """Name of their set among the groups of the mesh."""
    number: int
    """Number of the node or set."""
    one: bool
    """Whether it is about one node."""
    ways: str
    """Fixed directions of "xyz"; empty if the nodes are attached."""
    part: int
    """The rigid part that they are attached to; 0 if they are fixed."""
    block: Block
    line: int
    problem: str = ""
    """The part of it that is not understood; such a tie has no effect."""

    @property
    def key(self) -> tuple[str, int, int]:
        """The key that distinguishes it from others."""
        return str(self.block.path), self.line, self.number

    @property
    def what(self) -> str:
        """The nodes in words."""
        return f"node {self.number}" if self.one else set_name(self.number)


def is_tie(block: Block) -> bool:
    """Return whether `read_ties` reads a keyword."""
    return block.keyword.removesuffix("_ID") in _HELD or block.keyword in _EXTRA


def read_ties(block: Block) -> Iterator[NodeTie]:
    """Yield all ties of a keyword.

    Raises
    ------
    MeshError
        A field that should be a number is none.
    """
    word, one = block.keyword.removesuffix("_ID"), block.keyword.endswith(("_NODE", "_NODE_ID"))
    step = 1 + block.keyword.endswith("_ID")
    block.mark_read(*(block.cards[::2] if step == 2 else ()))
    for card in block.cards[step - 1 :: step]:
        if word in _EXTRA:
            row = row_of(card, block, _EXTRA_NODES)
            part, number = row.wholes("PID NID")
            tie = NodeTie(_name(one, number, f"with part {part}"), number, one, "", part, block, 0)
        else:
            row = row_of(card, block, _SPC)
            number, axes, *holds = row.wholes("NID CID DOFX DOFY DOFZ")
            ways = "".join(axis for axis, hold in zip("xyz", holds, strict=True) if hold)
            problem = "in axes of its own, CID" if axes else "" if ways else "turns alone"
            name = _name(one, number, f"held in {ways}")
            tie = NodeTie(name, number, one, ways, 0, block, 0, problem)
        if number:
            yield tie._replace(line=card.line)


def tied_nodes(blocks: Iterable[Block]) -> dict[str, list[int]]:
    """Return the single nodes that cards name, by the name of their set.

    Cards that cannot be read say nothing: a mesh does without what holds it.
    """
    nodes: dict[str, list[int]] = {}
    for block in filter(is_tie, blocks):
        with suppress(MeshError):
            for tie in read_ties(block):
                if tie.one and not tie.problem:
                    nodes.setdefault(tie.nodes, []).append(tie.number)
    return nodes


def _name(one: bool, number: int, does: str) -> str:
    return f"nodes {does}" if one else set_name(number)
