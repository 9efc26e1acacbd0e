"""Element types of Abaqus and CalculiX with their cells, and keywords that leave the mesh alone.

The number of nodes is part of a type's name. All types that are known here have their nodes in
VTK's order (Abaqus Analysis User's Guide, "Element library").
"""

from __future__ import annotations

import re
from collections.abc import Mapping

_SHELL_NODES = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
_SOLID_NODES = {
    4: "tetra",
    5: "pyramid",
    6: "wedge",
    8: "hexahedron",
    10: "tetra10",
    15: "wedge15",
    20: "hexahedron20",
}
_SHELLS = re.compile(
    r"(?:S|DS|M3D|SFM3D|R3D|CPS|CPE|CPEG|CAX|CGAX|DC2D|AC2D|F3D)([34689])(?!\d)[A-Z0-9]*"
)
_SPECIAL_NAMES = {"STRI3": "triangle", "STRI65": "triangle6"}
_SOLIDS = re.compile(r"(?:C3D|DC3D|AC3D|DCC3D|SC|COH3D|CSS|EC3D|PC3D|GK3D)(\d+)[A-Z]*")
_LINES = re.compile(
    r"(?:B[23]\d|PIPE[23]\d|ELBOW\d|FRAME[23]D|T[23]D[23]|R2D2|RB[23]D2|SPRING[A12]|DASHPOT[A12]|MASS"
    r"|ROTARYI|HEATCAP|CONN[23]D2|JOINTC|GAP(?:UNI|CYL|SPHER)|DGAP|ITT\d+|DCOUP[23]D|DC1D[23]|DCC1D2"
    r"|AC1D[23]|ACIN2D[23]|GK3D2|PSI\d+|DRAG[23]D|FLINK|FC3D2)[A-Z]*"
)


def cell_of(name: str) -> str | None:
    """Return the cell of an element type, "" for points and lines, None for an unknown type.

    >>> cell_of("S4R"), cell_of("C3D10M"), cell_of("B31"), cell_of("U1")
    ('quad', 'tetra10', '', None)
    """
    name = name.upper()
    if name in _SPECIAL_NAMES:
        return _SPECIAL_NAMES[name]
    shell = _SHELLS.fullmatch(name)
    if shell is not None:
        return _SHELL_NODES[int(shell[1])]
    solid = _SOLIDS.fullmatch(name)
    if solid is not None and int(solid[1]) in _SOLID_NODES:
        return _SOLID_NODES[int(solid[1])]
    return "" if _LINES.fullmatch(name) else None


_IGNORED_FIRST_WORDS = re.compile(
    r"C|D|ACOUSTIC|AMPLITUDE|ANISOTROPIC|ANNEAL|AQUA|BASE|BEAM|BIAXIAL|BOND|BOUNDARY"
    r"|BRITTLE|DEFORMATION|HYSTERESIS|MAGNETIC|ELECTROMAGNETIC|PERMITTIVITY"
    r"|BUCKLE|BULK|CAP|CAPACITY|CAST|CAVITY|CENTROID|CFILM|CFLOW|CFLUX|CHANGE|CHARACTERISTIC"
    r"|CLAY|CLEARANCE|CLOAD|COHESIVE|COMBINED|COMPLEX|CONCRETE|CONDUCTIVITY|CONNECTOR"
    r"|CONSTITUTIVE|CONTACT|CONTOUR|CONTROLS|CORRELATION|COUPLED|COUPLING|CRADIATE|CREEP"
    r"|CRUSHABLE|CYCLED|DAMAGE|DAMPING|DASHPOT|DENSITY|DEPVAR|DESIGN|DETONATION|DFLOW|DFLUX"
    r"|DIELECTRIC|DIFFUSIVITY|DIRECT|DISPLAY|DISTRIBUTING|DISTRIBUTION|DLOAD|DRAG|DRUCKER"
    r"|DSECHARGE|DSFLOW|DSFLUX|DSLOAD|DYNAMIC|ELASTIC|ELECTRICAL|ENERGY|ENRICHMENT|EOS|EPJOINT"
    r"|EQUATION|EULERIAN|EXPANSION|EXTREME|FABRIC|FAIL|FASTENER|FIELD|FILE|FILM|FILTER"
    r"|FLEXIBLE|FLOW|FLUID|FOUNDATION|FRACTURE|FRAME|FREQUENCY|FRICTION|GAP|GAS|GASKET|GEL"
    r"|GENERAL|GEOSTATIC|HEADING|HEAT|HEATCAP|HOURGLASS|HYPERELASTIC|HYPERFOAM|HYPOELASTIC"
    r"|IMPEDANCE|INCIDENT|INELASTIC|INERTIA|INITIAL|INTEGRATED|INTERFACE|ITS|JOINT|JOINTED"
    r"|JOULE|KAPPA|KINEMATIC|LATENT|LOAD|LOADING|LOW|MASS|MATERIAL|MATRIX|MEMBRANE|MOHR"
    r"|MOISTURE|MOLECULAR|MONITOR|MOTION|MPC|MULLINS|NO|NODAL|NONSTRUCTURAL|NORMAL|ORIENTATION"
    r"|ORNL|OUTPUT|PERMEABILITY|PHYSICAL|PIEZOELECTRIC|PIPE|PLANAR|PLASTIC|POROUS|POST"
    r"|POTENTIAL|PRE-TENSION|PREPRINT|PRESSURE|PRINT|PSD|RADIATE|RADIATION|RANDOM|RATE|RATIOS"
    r"|REACTION|REBAR|RELEASE|RESPONSE|RESTART|RETAINED|RIGID|ROTARY|SECTION|SECONDARY|SELECT"
    r"|SFILM|SFLOW|SHEAR|SHELL|SIMPEDANCE|SIMPLE|SLIDE|SLOAD|SOILS|SOLID|SOLUBILITY|SOLUTION"
    r"|SOLVER|SORPTION|SPECIFIC|SPECTRUM|SPRING|SRADIATE|STATIC|STEADY|SUPERELASTIC|SURFACE"
    r"|SWELLING|TEMPERATURE|TENSILE|TENSION|TEST|THERMAL|TIE|TIME|TORQUE|TRACER|TRANSFORM"
    r"|TRANSPORT|TRANSVERSE|TRIAXIAL|TRS|UEL|UNDEX|UNIAXIAL|UNITS|VALUES|VARIABLE|VIEWFACTOR"
    r"|VISCO|VISCOELASTIC|VISCOUS|VOID|VOLUMETRIC|WAVE|WIND"
)
"""First words of keywords that neither make nor move nodes and elements."""
_IGNORED_KEYWORDS = frozenset(
    [
        *("EL FILE", "EL PRINT", "ELEMENT OUTPUT", "ELEMENT PRINT", "ELEMENT RESPONSE"),
        *("NODE FILE", "NODE OUTPUT", "NODE PRINT", "NODE RESPONSE", "USER MATERIAL"),
        *("USER DEFINED FIELD", "USER OUTPUT VARIABLES", "USER SUBROUTINES", "MODAL DAMPING"),
        *("MODAL DYNAMIC", "MODAL FILE", "MODAL OUTPUT", "MODAL PRINT", "EMBEDDED ELEMENT"),
        *("MODEL DATA", "IMPORT CONTROLS"),
    ]
)
"""Full names of other such keywords."""


def moves_to_contact(name: str, options: Mapping[str, str]) -> bool:
    """Return whether a keyword lets a solver move nodes onto the surface they face.

    That is *CONTACT PAIR with ADJUST, and *TIE or *CONTACT CLEARANCE without ADJUST = NO.
    """
    if name == "CONTACT PAIR":
        return "ADJUST" in options
    return name in ("TIE", "CONTACT CLEARANCE") and options.get("ADJUST", "").upper() != "NO"


def touches_no_mesh(name: str) -> bool:
    """Return whether a keyword is known to neither make nor move nodes and elements.

    Most are known by their first word, some by their full name; `name` is in upper case.
    """
    return name in _IGNORED_KEYWORDS or _IGNORED_FIRST_WORDS.fullmatch(name.split()[0]) is not None
