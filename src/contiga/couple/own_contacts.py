"""Switch off MuJoCo's own contacts between coupled bodies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from contiga.errors import InputError

Pair = tuple[int, int]


def switch_off(model: Any, pairs: Iterable[Pair]) -> None:
    """Change `model` so that the geoms of each pair of bodies do not touch.

    Pairs that the model excludes, or that cannot touch, stay. Otherwise the geoms of one body of
    the pair are switched off (contype and conaffinity 0): the first, by number, that touches only
    bodies that it is coupled to.

    Raises
    ------
    InputError
        The geoms touch other bodies, or the model has an explicit pair: change the model.
    """
    sorted_pairs = sorted({(min(pair), max(pair)) for pair in pairs})
    for pair in sorted_pairs:
        _check_explicit_pairs(model, pair)
    for pair in sorted_pairs:
        if not _touching(model, pair):
            continue
        for body in pair:
            geoms = _geoms(model, body)
            partners = {p[1 - p.index(body)] for p in sorted_pairs if body in p}
            touched = {other for other in range(model.nbody) if _touching(model, (body, other))}
            if touched <= partners:
                model.geom_contype[geoms] = model.geom_conaffinity[geoms] = 0
                break
        else:
            first, second = (model.body(body).name or f"body {body}" for body in pair)
            raise InputError(
                "MuJoCo's own geoms of two coupled bodies touch each other, and others too",
                where="contacts",
                found=f"{first!r} and {second!r}",
                remedy="Write in the model: "
                f'<contact><exclude body1="{first}" body2="{second}"/></contact>',
            )


def _geoms(model: Any, body: int) -> Any:
    """Return the numbers of the geoms of a body."""
    return np.flatnonzero(model.geom_bodyid == body)


def _touching(model: Any, pair: Pair) -> bool:
    """Return whether geoms of two bodies may touch in MuJoCo, by their bits and kinship."""
    first, second = pair
    excluded = {(first << 16) + second, (second << 16) + first} & set(
        model.exclude_signature.tolist()
    )
    if first == second or excluded or _are_kin(model, pair):
        return False
    a, b = _geoms(model, first), _geoms(model, second)
    bits = model.geom_contype[a][:, None] & model.geom_conaffinity[b]
    back = model.geom_conaffinity[a][:, None] & model.geom_contype[b]
    return bool(((bits | back) != 0).any())


def _are_kin(model: Any, pair: Pair) -> bool:
    """Return whether two bodies are welded, or parent and child, which never touch in MuJoCo.

    Children of the world may touch it, and any parent its children with the flag `filterparent`
    disabled. Explicit pairs of geoms touch all the same.
    """
    import mujoco

    welded = model.body_weldid
    a, b = (int(welded[body]) for body in pair)
    if a == b:
        return True
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT or 0 in (a, b):
        return False
    above_a, above_b = (int(welded[model.body_parentid[body]]) for body in (a, b))
    return above_a == b or above_b == a


def _check_explicit_pairs(model: Any, pair: Pair) -> None:
    """Raise `InputError` for explicit pairs of geoms, which touch whatever their bits."""
    for geoms in zip(model.pair_geom1, model.pair_geom2, strict=True):
        if {int(model.geom_bodyid[geom]) for geom in geoms} == set(pair):
            names = [model.geom(int(geom)).name or f"geom {geom}" for geom in geoms]
            raise InputError(
                "the model asks for a contact between geoms of two coupled bodies",
                where="contacts",
                found=" and ".join(map(repr, names)),
                remedy="Take its <pair> out of the model",
            )
