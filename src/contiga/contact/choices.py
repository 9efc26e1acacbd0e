"""The options of a contact that are one of a few words."""

from __future__ import annotations

from contiga.errors import InputError
from contiga.slaves.sampling import QUADRATURES

OPTIONS: dict[str, tuple[str | int, ...]] = {
    "search": ("intersection", "penetration"),
    "contact_type": ("slave", "master", "combined"),
    "on_edge": ("release", "hold"),
    "weights": ("rest", "area"),
    "quadrature": QUADRATURES,
    "through": ("release", "hold"),
    "foot": ("nearest", "tracked"),
}
"""What each may be."""


def check_choices(chosen: dict[str, str | int], thick: bool) -> None:
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
    if thick and (chosen["foot"] == "tracked" or chosen["through"] == "hold"):
        raise InputError(
            "a shell with a thickness is pushed by the nearest wall",
            where="shell_thickness",
            found='foot="tracked"' if chosen["foot"] == "tracked" else 'through="hold"',
            allowed='no shell_thickness, or foot="nearest" and through="release"',
        )


def choice(name: str, value: str | int, allowed: tuple[str | int, ...]) -> None:
    """Refuse a value that is not one of `allowed`."""
    if isinstance(value, bool) or value not in allowed:
        raise InputError(
            f"unknown {name}", where=name, found=value, allowed=", ".join(map(repr, allowed))
        )
