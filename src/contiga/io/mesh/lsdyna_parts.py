"""*PART and *SECTION of an LS-DYNA deck: titles and inertia of parts, thicknesses of shells.

Card layouts: LS-DYNA Keyword User's Manual, volume I, *PART and *SECTION_SHELL.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.io.mesh.lsdyna_cards import (
    Block,
    Card,
    Definitions,
    OnSkip,
    Row,
    define_once,
    layout,
    row_of,
    skip_unresolved,
)
from contiga.records import FloatArray

_PART = layout("PID SECID MID EOSID HGID GRAV ADPOPT TMID")
_INERTIA = (
    layout("XC YC ZC TM IRCS NODEID"),
    layout("IXX IXY IXZ IYY IYZ IZZ"),
    layout("VTX VTY VTZ VRX VRY VRZ"),
)
_AXES = layout("XL YL ZL XLIP YLIP ZLIP CID")
# Cards that follow the one with the part's number, by option of the keyword.
_PART_OPTIONS = {
    "INERTIA": _INERTIA,
    "REPOSITION": (layout("CMSN MDEP MOVOPT"),),
    "CONTACT": (layout("FS FD DC VC OPTT SFT=1 SSF=1 CPARM8"),),
    "PRINT": (layout("~PRBF"),),
    "FIELD": (layout("FIDBO"),),
}
_SHELL = layout("SECID ELFORM=2 SHRF=1 NIP=2 PROPT=1 QR/IRID ICOMP SETYP=1")
_THICKNESS = layout("T1 T2 T3 T4 NLOC MAREA IDOF EDGSET")
_ANGLES = layout("B1 B2 B3 B4 B5 B6 B7 B8")
_MISC = layout("THKSCL=1")
_SOLID = layout("~SECID ELFORM=1 AET P4 P5 P6 COHOFF GASKETT")
_THICK_SHELL = layout("~SECID ELFORM=1 SHRF=1 NIP=2 PROPT=1 QR/IRID ICOMP TSHEAR")
_SOLID_SECTIONS = ("SECTION_SOLID", "SECTION_TSHELL")


class Inertia(NamedTuple):
    """The *PART_INERTIA of a rigid part."""

    mass: float
    centre: tuple[float, ...]
    """x, y, z."""
    node: int
    """Node at the centre; 0 if the centre is given."""
    tensor: tuple[float, ...]
    """Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the centre."""
    velocity: tuple[float, ...]
    """Initial velocity of the centre."""
    spin: tuple[float, ...]
    """Initial angular velocity."""
    axes: Row | None
    """The card with the axes of the tensor; None for world axes."""
    block: Block


class Parts(NamedTuple):
    """Titles of parts, thicknesses of their shells, and inertia of rigid ones."""

    titles: dict[int, str]
    sections: dict[int, int]
    """Section of each part."""
    thickness: dict[int, tuple[float, float, float, float]]
    """Thicknesses of each shell section at the four corners."""
    added: dict[int, float]
    """Additional mass over area of each shell section, MAREA."""
    materials: dict[int, int]
    """Material of each part."""
    inertia: dict[int, Inertia]
    """Inertia of the parts that define it."""
    definitions: Definitions
    """Cards of each part and shell section."""

    def shell_thickness(self, part: NDArray[np.int64]) -> FloatArray:
        """Return the thickness (m, 4) at the corners of shells of these parts; 0 if not given."""
        numbers, inverse = np.unique(part, return_inverse=True)
        none = (0.0, 0.0, 0.0, 0.0)
        rows = [self.thickness.get(self.sections.get(int(n), -1), none) for n in numbers]
        return np.array(rows, dtype=np.float64).reshape(-1, 4)[inverse.ravel()]


def is_part(block: Block) -> bool:
    """Return whether a keyword is a *PART that `read_parts` reads completely.

    That is *PART alone, or with the options of `_PART_OPTIONS` in any order.
    """
    first, *options = block.keyword.split("_")
    return first == "PART" and set(options) <= _PART_OPTIONS.keys()


def read_parts(blocks: Iterable[Block], on_skip: OnSkip | None = None) -> Parts:
    """Return parts and sections of a deck; blocks with unresolved parameters go to `on_skip`.

    Without `on_skip` an unresolved parameter is an error. Parts of a block before the one with
    the parameter are read. Of a *PART with unknown options only the first part is, without them.

    Raises
    ------
    MeshError
        A field that should be a number is not one; a part or section is given twice, not alike.
    """
    parts = Parts({}, {}, {}, {}, {}, {}, {})
    for block in blocks:
        if block.keyword == "PART" or block.keyword.startswith("PART_"):
            reader = _read_part
        elif block.keyword.startswith("SECTION_SHELL"):
            reader = _read_shell_section
        elif block.keyword.startswith(_SOLID_SECTIONS):
            reader = _read_solid_section
        else:
            continue
        with skip_unresolved(block, on_skip):
            reader(block, parts)
    return parts


def is_section(block: Block) -> bool:
    """Return whether a keyword is a *SECTION that `read_parts` reads."""
    return block.keyword.startswith(("SECTION_SHELL", *_SOLID_SECTIONS))


def _read_part(block: Block, parts: Parts) -> None:
    """Read the parts of a *PART into `parts`: heading, numbers, and cards of known options.

    If there are unknown options only the first part is read, without cards of options.
    """
    is_known = is_part(block)
    options = block.keyword.split("_")[1:] if is_known else []
    cards = iter(block.cards)
    for heading in cards:
        card = next(cards, None)
        if card is None:
            return
        block.mark_read(heading)
        number, section, material = row_of(card, block, _PART).wholes("PID SECID MID")
        # Everything that can fail comes first: a part is read with all its cards, or not at all.
        part_cards = [heading, card]
        for option in options:
            layouts = _PART_OPTIONS[option]
            extra = list(islice(cards, len(layouts)))
            part_cards += extra
            rows = [
                row_of(extra_card, block, fields)
                for extra_card, fields in zip(extra, layouts, strict=False)
            ]
            if option != "INERTIA" or not rows:
                continue
            # A tensor in local axes is followed by a card with these axes.
            axes_card = next(cards, Card("", 0)) if rows[0].whole("IRCS") else None
            if len(rows) == len(layouts):
                parts.inertia[number] = Inertia(
                    centre=rows[0].reals("XC YC ZC"),
                    mass=rows[0].real("TM"),
                    tensor=rows[1].reals("IXX IXY IXZ IYY IYZ IZZ"),
                    velocity=rows[2].reals("VTX VTY VTZ"),
                    spin=rows[2].reals("VRX VRY VRZ"),
                    node=rows[0].whole("NODEID"),
                    axes=row_of(axes_card, block, _AXES) if axes_card else None,
                    block=block,
                )
        define_once(parts.definitions, "part", number, block, part_cards)
        parts.materials[number] = material
        parts.titles[number] = heading.text.strip()
        parts.sections[number] = section
        if not is_known:
            # Unknown cards follow, so that the next part cannot be located.
            return


def axes_of(x_vector: Sequence[float], plane_vector: Sequence[float]) -> FloatArray | None:
    """Return columns (3, 3): the local x axis, y in the plane of x and a second vector, and z.

    None if the vectors are parallel or zero.
    """
    x, plane = np.array(x_vector), np.array(plane_vector)
    z = np.cross(x, plane)
    if not z.any():
        return None
    y = np.cross(z, x)
    return np.stack([axis / np.linalg.norm(axis) for axis in (x, y, z)], axis=1)


def _read_shell_section(block: Block, parts: Parts) -> None:
    """Read the sections of a *SECTION_SHELL into `parts`: thicknesses and added mass, by number.

    Cards of angles (ICOMP = 1) are cut, but not read. T2 to T4 are T1 unless above 0. With options
    besides TITLE only the first section is read.
    """
    options = block.keyword.split("_")[2:]
    has_title = "TITLE" in options
    cards = iter(block.cards)
    while True:
        block.mark_read(*islice(cards, int(has_title)))
        first, second = next(cards, None), next(cards, None)
        if first is None or second is None:
            return
        head, values = row_of(first, block, _SHELL), row_of(second, block, _THICKNESS)
        number = head.whole("SECID")
        define_once(parts.definitions, "section", number, block, [first, second])
        thickness = values.reals("T1 T2 T3 T4")
        t1, t2, t3, t4 = (value if value > 0.0 else thickness[0] for value in thickness)
        parts.thickness[number] = (t1, t2, t3, t4)
        parts.added[number] = values.real("MAREA")
        if head.peek("ICOMP") == 1:
            # At most all existing cards, whatever number of layers is claimed.
            n_layers = max(head.peek("NIP"), 2)
            for card in islice(cards, -(-n_layers // len(_ANGLES.fields))):
                row_of(card, block, _ANGLES)
        if any(option != "TITLE" for option in options):
            # Options bring cards of their own, so that only the first section is certain.
            for card in islice(cards, int("MISC" in options)):
                row_of(card, block, _MISC)
            return


def _read_solid_section(block: Block, parts: Parts) -> None:
    """Cut the cards of a section of solids, whose fields stay unread: `parts` is not changed.

    Titles count as read. With options besides TITLE only the first card is cut.
    """
    options = block.keyword.split("_")[2:]
    has_title = "TITLE" in options
    cards = iter(block.cards)
    block.mark_read(*islice(cards, int(has_title)))
    for card in cards:
        row_of(card, block, _THICK_SHELL if "TSHELL" in block.keyword else _SOLID)
        if any(option != "TITLE" for option in options):
            return
        block.mark_read(*islice(cards, int(has_title)))
