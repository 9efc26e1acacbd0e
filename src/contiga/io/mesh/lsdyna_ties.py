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

_FIXED = ("BOUNDARY_SPC_SET", "BOUNDARY_SPC_NODE")
_EXTRA = ("CONSTRAINED_EXTRA_NODES_SET", "CONSTRAINED_EXTRA_NODES_NODE")
# The last three fields fix rotations, which nodes of a case do not have.
_SPC = layout("NID CID DOFX DOFY DOFZ ~DOFRX ~DOFRY ~DOFRZ")
_EXTRA_NODES = layout("PID NID IFLAG")


class NodeTie(NamedTuple):
    """A node or a set of nodes that a card fixes, or attaches to a rigid part."""

    nodes: str
    """Name of their set among the groups of the mesh; single nodes of one effect share one."""
    number: int
    """Number of the node or set."""
    is_single: bool
    """Whether it is about one node."""
    directions: str
    """Fixed directions of "xyz"; empty if the nodes are attached."""
    part: int
    """The rigid part that they are attached to; 0 if they are fixed."""
    block: Block
    line: int
    """Line of its card."""
    problem: str = ""
    """Reason why it is not understood, "" if it is; such a tie has no effect."""

    @property
    def key(self) -> tuple[str, int, int]:
        """Unique key: file, line and number."""
        return str(self.block.path), self.line, self.number

    @property
    def label(self) -> str:
        """The nodes in words."""
        return f"node {self.number}" if self.is_single else set_name(self.number)


def is_tie(block: Block) -> bool:
    """Return whether `read_ties` reads a keyword."""
    return block.keyword.removesuffix("_ID") in _FIXED or block.keyword in _EXTRA


def read_ties(block: Block) -> Iterator[NodeTie]:
    """Yield the ties of a keyword for which `is_tie` holds, also those with a problem.

    Cards without a node are skipped; numbers and titles of an _ID keyword are marked as read.

    Raises
    ------
    MeshError
        A field that should be a number is not one.
    """
    keyword = block.keyword.removesuffix("_ID")
    single = keyword.endswith("_NODE")
    step = 1 + block.keyword.endswith("_ID")
    block.mark_read(*(block.cards[::2] if step == 2 else ()))
    for card in block.cards[step - 1 :: step]:
        part, directions, problem = 0, "", ""
        if keyword in _EXTRA:
            part, number = row_of(card, block, _EXTRA_NODES).wholes("PID NID")
            constraint = f"with part {part}"
        else:
            number, axes, *fixed = row_of(card, block, _SPC).wholes("NID CID DOFX DOFY DOFZ")
            directions = "".join(axis for axis, fix in zip("xyz", fixed, strict=True) if fix)
            problem = "in axes of its own, CID" if axes else "" if directions else "turns alone"
            constraint = f"held in {directions}"
        if number:
            name = f"nodes {constraint}" if single else set_name(number)
            yield NodeTie(name, number, single, directions, part, block, card.line, problem)


def tied_nodes(blocks: Iterable[Block]) -> dict[str, list[int]]:
    """Return the numbers of the single nodes that cards tie, by the name of their set.

    Ties with a problem are left out. A keyword is read up to its first unreadable card, without an
    error: a mesh does not need its constraints.
    """
    nodes: dict[str, list[int]] = {}
    for block in filter(is_tie, blocks):
        with suppress(MeshError):
            for tie in read_ties(block):
                if tie.is_single and not tie.problem:
                    nodes.setdefault(tie.nodes, []).append(tie.number)
    return nodes
