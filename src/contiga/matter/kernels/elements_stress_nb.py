"""Dispatch from the number of a material to its stage."""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.membrane_elastic_nb import membrane_elastic, membrane_slack
from contiga.matter.kernels.membrane_fabric_nb import membrane_fabric
from contiga.matter.kernels.membrane_neo_hooke_nb import membrane_neo_hooke
from contiga.matter.kernels.solid_elastic_nb import solid_elastic
from contiga.matter.kernels.solid_foam_nb import solid_foam
from contiga.matter.kernels.solid_neo_hooke_nb import solid_neo_hooke

ELASTIC, NEO_HOOKE, SLACK, FOAM, FABRIC, BAR = 0, 1, 2, 3, 4, 5


@inner(linked=False)
def solid_stress(bank, tables, step, old, new):
    """Write P and W of solids into the bank; foam also writes its losses and the `new` memory."""
    if tables.material == ELASTIC:
        solid_elastic(bank, tables.numbers)
    elif tables.material == FOAM:
        solid_foam(bank, tables, step, old, new)
    else:
        solid_neo_hooke(bank, tables.numbers)


@inner(linked=False)
def membrane_stress(bank, material, numbers, curves, old, new):
    """Write S and W of membranes from E; fabric also writes its losses and the `new` memory."""
    if material == ELASTIC:
        membrane_elastic(bank, numbers)
    elif material == SLACK:
        membrane_slack(bank, numbers)
    elif material == FABRIC:
        membrane_fabric(bank, numbers, curves, old, new)
    else:
        membrane_neo_hooke(bank, numbers)
