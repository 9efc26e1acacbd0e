"""Seeds that are text: keyword decks, G+Smo files, clouds and case files."""

from __future__ import annotations

import math


def _card(*values: object, widths: tuple[int, ...] = (8,) * 10) -> str:
    return "".join(str(value).rjust(width) for value, width in zip(values, widths, strict=False))


_NODE = (8, 16, 16, 16)
_POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
_POINTS += [(x, y, 1.0) for x, y, _ in _POINTS]


def _deck(*blocks: str, head: str = "*KEYWORD") -> str:
    return "\n".join([head, *blocks, "*END"]) + "\n"


_NODES = "*NODE\n" + "\n".join(_card(k + 1, *xyz, widths=_NODE) for k, xyz in enumerate(_POINTS))
_SHELLS = "*ELEMENT_SHELL\n" + "\n".join([_card(1, 1, 1, 2, 3, 4), _card(2, 2, 5, 6, 7, 7)])
_SOLIDS = "*ELEMENT_SOLID\n" + _card(3, 3, *range(1, 9))
_FIVE = "".join(f"{0.5:10.3f}" for _ in range(4))
_PARTS = f"""*PART
a plate
{_card(1, 1, 1)}
another
{_card(2, 2, 1)}
*SECTION_SHELL
{_card(1, 2, 1.0, 2, widths=(10,) * 4)}
{_FIVE}
*SECTION_SHELL_TITLE
thick
{_card(2, 2, 1.0, 3, "", "", 1, widths=(10,) * 7)}
{_FIVE}
{_FIVE}"""
_THICK = f"""*ELEMENT_SHELL_THICKNESS
{_card(1, 1, 1, 2, 3, 4)}
{_card(0.1, 0.2, 0.3, 0.4, widths=(16,) * 4)}"""
_MASS = "*ELEMENT_MASS\n" + _card(9, 1, 2.5, 0, widths=(8, 8, 16, 8))
_INERTIA = f"""*PART_INERTIA
block
{_card(3, 1, 1, widths=(10,) * 3)}
{_card(0.0, 0.0, 0.0, 0.0, 1, widths=(10,) * 5)}
{_FIVE}
{_FIVE}
{_card(1, widths=(10,))}"""
_LONG = "\n".join(
    [
        "*NODE+",
        *(_card(k + 1, *p, widths=(20,) * 4) for k, p in enumerate(_POINTS)),
        "*ELEMENT_SOLID+",
        _card(1, 1, *range(1, 9), widths=(20,) * 10),
    ]
)
_FREE = "\n".join(
    [
        "*NODE",
        *(f"{k + 1},{x},{y},{z}" for k, (x, y, z) in enumerate(_POINTS)),
        "*ELEMENT_SOLID",
        "1,1",
        "1,2,3,4,5,6,7,8",
    ]
)

DECKS = {
    "shells": _deck(_NODES, _SHELLS),
    "solids": _deck(_NODES, _SOLIDS, _MASS),
    "parts": _deck("$ a comment", _NODES, _SHELLS, _PARTS, _INERTIA),
    "thickness": _deck(_NODES, _THICK, _PARTS),
    "long": _deck(_LONG),
    "long-all": _deck(_LONG.replace("+", ""), head="*KEYWORD LONG=Y"),
    "free": _deck(_FREE),
    "include": _deck("*INCLUDE", "part.k", "*INCLUDE_PATH", ".", _PARTS),
}


def _surface(kind: str, knots: str, degree: int, coefs: list[tuple[float, ...]], extra: str) -> str:
    rows = "\n".join(" ".join(repr(x) for x in point) for point in coefs)
    basis = "".join(
        f'<Basis type="BSplineBasis" index="{k}"><KnotVector degree="{degree}">{knots}'
        "</KnotVector></Basis>"
        for k in range(2)
    )
    return (
        f'<Geometry type="{kind}" id="0">\n<Basis type="TensorBSplineBasis2">{basis}{extra}</Basis>'
        f'\n<coefs geoDim="3">\n{rows}\n</coefs>\n</Geometry>\n'
    )


_GRID = [(float(i), float(j), math.sin(i + 2.0 * j)) for j in range(4) for i in range(4)]
_ARC = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
_SQUARE = _surface(
    "TensorBSpline2", "0 0 1 1", 1, [(x, y, 0.0) for y in (0, 1) for x in (0, 1)], ""
)

GISMO = {
    "patch": f"<xml>\n{_surface('TensorBSpline2', '0 0 0 0.5 1 1 1', 2, _GRID, '')}</xml>\n",
    "pair": "<xml>\n" + _SQUARE + _SQUARE.replace("0.0\n0 1", "0.5\n0 1") + "</xml>\n",
    "rational": "<xml>\n"
    + _surface(
        "TensorNurbs2",
        "0 0 0 1 1 1",
        2,
        [(x, y, float(z)) for z in range(3) for x, y in _ARC],
        "<weights>1 0.7 1 1 0.7 1 1 0.7 1</weights>",
    )
    + "</xml>\n",
}

CLOUDS = {
    "plain": "x,y,z\n" + "\n".join(f"{x},{y},{z}" for x, y, z in _POINTS) + "\n",
    "blanks": "# points\n" + "\n".join(f"{x} {y} {z}" for x, y, z in _POINTS) + "\n",
    "table": "t,x,y,z\n0,0,0,0\n1,0,0,-0.5\n2,0,0,0\n",
}

_HEAD = """title = "A case"

[units]
length = "mm"
mass = "g"
time = "ms"

[time]
end = 2.0
step = 0.5
"""

CASES = {
    "shapes": _HEAD
    + """
[[body]]
name = "balls"
geometry = { patches = [
  { shape = "sphere", radius = 20.0, centre = [-25.0, 0.0, 20.5] },
  { shape = "sphere", radius = 20.0, centre = [25.0, 0.0, 20.5] },
] }
motion = { kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -4.5], [2, 0, 0, 0]] }

[[slave]]
name = "sheet"
points = { file = "pad_0.csv", unit = "mm" }
thickness = 10.0
area = 4.0

[[contact]]
name = "balls on sheet"
master = "balls"
slave = "sheet"

[contact.law]
kind = "stress"
elastic = [[0.0, 0.0], [0.04, 0.10], [0.20, 0.14]]
damping = 0.2

[output]
every = 2
""",
    "files": _HEAD
    + """
[[body]]
name = "patch"
geometry = { file = "ball.xml", unit = "mm" }
motion = { kind = "rotate", axis = "y", centre = [0, 0, 0], table = [[0, 0], [2, 8.0]] }

[[slave]]
name = "pad"
points = { file = "pad_0.csv", unit = "mm" }
motion = { kind = "series", files = "pad_*.csv", step = 1.0 }

[[contact]]
master = "patch"
slave = "pad"
law = { kind = "penalty", stiffness = 10.0 }
""",
}
