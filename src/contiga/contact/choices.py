"""The options of a contact that are one of a few words."""

from __future__ import annotations

from contiga.errors import InputError
from contiga.slaves.sampling import QUADRATURES
from contiga.slaves.shell_offset import SIDES

OPTIONS: dict[str, tuple[str | int, ...]] = {
    "search": ("intersection", "penetration"),
    "contact_type": ("slave", "master", "combined"),
    "on_edge": ("release", "hold"),
    "weights": ("rest", "area"),
    "quadrature": QUADRATURES,
    "through": ("release", "hold"),
    "foot": ("nearest", "tracked"),
    "shell_offset": tuple(SIDES),
}
"""What each may be."""


def check_choices(chosen: dict[str, str | int]) -> None:
    """Refuse words that an option does not know, and options that do not go together."""
    for name, value in chosen.items():
        choice(name, value, OPTIONS[name])
    if chosen["through"] == "hold" and chosen["search"] == "penetration":
        raise InputError(
            "a search by penetration does not know where points enter, and cannot hold them there",
            where="through",
            found=chosen["through"],
            allowed='through="release", or search="intersection"',
        )
    if chosen["shell_offset"] != "none" and chosen["quadrature"] == "nodes":
        raise InputError(
            "points stand off facets, and contact is at the nodes",
            where="shell_offset",
            found=chosen["shell_offset"],
            allowed='"none", or quadrature=3 (or 1, 6, 12)',
        )


def choice(name: str, value: str | int, allowed: tuple[str | int, ...]) -> None:
    """Refuse a value that is not one of `allowed`."""
    if isinstance(value, bool) or value not in allowed:
        raise InputError(
            f"unknown {name}", where=name, found=value, allowed=", ".join(map(repr, allowed))
        )
