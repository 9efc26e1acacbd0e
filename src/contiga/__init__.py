"""contiga: contact between exact CAD surfaces and deformable meshes.

Names are loaded when first used, so that ``import contiga`` stays as cheap as numba's own import.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from contiga.version import __version__

_HOME = {
    "NurbsCurve": "contiga.geometry.curve",
    "NurbsSurface": "contiga.geometry.surface",
    "TriMesh": "contiga.triangles.trimesh",
    "Body": "contiga.masters.body",
    "Master": "contiga.masters.protocol",
    "read_cad": "contiga.io.cad.read_cad",
    "cad_parts": "contiga.io.cad.cad_parts",
    "CadPart": "contiga.io.cad.cad_parts",
    "unite": "contiga.io.cad.unite_body",
    "read_mesh": "contiga.io.mesh.read_mesh",
    "read_master": "contiga.io.mesh.read_master",
    "write_mesh": "contiga.io.out.write_mesh",
    "Slave": "contiga.slaves.slave",
    "ForceLaw": "contiga.laws.force",
    "FaceLaws": "contiga.laws.by_face",
    "StressLaw": "contiga.laws.stress",
    "PenaltyLaw": "contiga.laws.normal",
    "AdaptiveLaw": "contiga.laws.normal",
    "Coulomb": "contiga.laws.friction",
    "ViscousFriction": "contiga.laws.friction",
    "FrictionInput": "contiga.laws.friction",
    "FrictionOutput": "contiga.laws.friction",
    "Characteristic": "contiga.laws.characteristic",
    "NodalArea": "contiga.area.nodal",
    "FacetArea": "contiga.area.facet",
    "HullArea": "contiga.area.hull",
    "CloudArea": "contiga.area.cloud",
    "AreaMethod": "contiga.area.method",
    "AreaInput": "contiga.area.method",
    "Areas": "contiga.area.method",
    "clusters_of": "contiga.area.cluster",
    "Contact": "contiga.contact.contact",
    "State": "contiga.contact.state",
    "Load": "contiga.dynamics.loads",
    "Spring": "contiga.dynamics.springs",
    "Simulation": "contiga.simulation.simulation",
    "Sensor": "contiga.simulation.sensor",
    "RelativeSensor": "contiga.simulation.sensor",
    "NodeSensor": "contiga.simulation.slave_sensor",
    "SectionSensor": "contiga.simulation.slave_sensor",
    "Finding": "contiga.simulation.checks.finding",
    "SystemState": "contiga.simulation.system_state",
    "OutputOptions": "contiga.simulation.model",
    "Settle": "contiga.simulation.settle",
    "Result": "contiga.simulation.result",
    "StoredResult": "contiga.simulation.stored_result",
    "open_result": "contiga.simulation.stored_result",
    "Case": "contiga.case.schema",
    "Clock": "contiga.simulation.clock",
    "load_case": "contiga.case.schema",
    "build": "contiga.case.build",
    "place": "contiga.placement.place",
    "align": "contiga.placement.align",
    "run": "contiga.running.run_case",
    "compare": "contiga.report.comparison",
    "Comparison": "contiga.report.comparison",
    "study": "contiga.studies.study",
    "Study": "contiga.studies.study",
    "View": "contiga.report.view",
    "Preview": "contiga.previewing.preview",
    "preview": "contiga.previewing.preview",
    "Feature": "contiga.statuses",
    "Status": "contiga.statuses",
    "ContactStatus": "contiga.records",
    "LawInput": "contiga.records",
    "LawOutput": "contiga.records",
    "MassProperties": "contiga.records",
    "Projection": "contiga.records",
    "Hit": "contiga.records",
    "RayHit": "contiga.records",
    "thread_count": "contiga.arrays.threads",
}
_ROOMS = {
    "shapes": "contiga.geometry.shapes",
    "clouds": "contiga.geometry.clouds",
    "knots": "contiga.geometry.knots",
    "errors": "contiga.errors",
    "extras": "contiga.extras",
    "materials": "contiga.materials",
    "matter": "contiga.matter",
    "motion": "contiga.motion",
    "criteria": "contiga.criteria",
    "files": "contiga.io.out.files",
    "style": "contiga.report.style",
}

__all__ = ["__version__", *_HOME, *_ROOMS]

if TYPE_CHECKING:
    from contiga import criteria as criteria
    from contiga import errors as errors
    from contiga import extras as extras
    from contiga import materials as materials
    from contiga import matter as matter
    from contiga import motion as motion
    from contiga.area.cloud import CloudArea as CloudArea
    from contiga.area.cluster import clusters_of as clusters_of
    from contiga.area.facet import FacetArea as FacetArea
    from contiga.area.hull import HullArea as HullArea
    from contiga.area.method import AreaInput as AreaInput
    from contiga.area.method import AreaMethod as AreaMethod
    from contiga.area.method import Areas as Areas
    from contiga.area.nodal import NodalArea as NodalArea
    from contiga.arrays.threads import thread_count as thread_count
    from contiga.case.build import build as build
    from contiga.case.schema import Case as Case
    from contiga.case.schema import load_case as load_case
    from contiga.contact.contact import Contact as Contact
    from contiga.contact.state import State as State
    from contiga.dynamics.loads import Load as Load
    from contiga.dynamics.springs import Spring as Spring
    from contiga.geometry import clouds as clouds
    from contiga.geometry import knots as knots
    from contiga.geometry import shapes as shapes
    from contiga.geometry.curve import NurbsCurve as NurbsCurve
    from contiga.geometry.surface import NurbsSurface as NurbsSurface
    from contiga.io.cad.cad_parts import CadPart as CadPart
    from contiga.io.cad.cad_parts import cad_parts as cad_parts
    from contiga.io.cad.read_cad import read_cad as read_cad
    from contiga.io.cad.unite_body import unite as unite
    from contiga.io.mesh.read_master import read_master as read_master
    from contiga.io.mesh.read_mesh import read_mesh as read_mesh
    from contiga.io.out import files as files
    from contiga.io.out.write_mesh import write_mesh as write_mesh
    from contiga.laws.by_face import FaceLaws as FaceLaws
    from contiga.laws.characteristic import Characteristic as Characteristic
    from contiga.laws.force import ForceLaw as ForceLaw
    from contiga.laws.friction import Coulomb as Coulomb
    from contiga.laws.friction import FrictionInput as FrictionInput
    from contiga.laws.friction import FrictionOutput as FrictionOutput
    from contiga.laws.friction import ViscousFriction as ViscousFriction
    from contiga.laws.normal import AdaptiveLaw as AdaptiveLaw
    from contiga.laws.normal import PenaltyLaw as PenaltyLaw
    from contiga.laws.stress import StressLaw as StressLaw
    from contiga.masters.body import Body as Body
    from contiga.masters.protocol import Master as Master
    from contiga.placement.align import align as align
    from contiga.placement.place import place as place
    from contiga.previewing.preview import Preview as Preview
    from contiga.previewing.preview import preview as preview
    from contiga.records import ContactStatus as ContactStatus
    from contiga.records import Hit as Hit
    from contiga.records import LawInput as LawInput
    from contiga.records import LawOutput as LawOutput
    from contiga.records import MassProperties as MassProperties
    from contiga.records import Projection as Projection
    from contiga.records import RayHit as RayHit
    from contiga.report import style as style
    from contiga.report.comparison import Comparison as Comparison
    from contiga.report.comparison import compare as compare
    from contiga.report.view import View as View
    from contiga.running.run_case import run as run
    from contiga.simulation.checks.finding import Finding as Finding
    from contiga.simulation.clock import Clock as Clock
    from contiga.simulation.model import OutputOptions as OutputOptions
    from contiga.simulation.result import Result as Result
    from contiga.simulation.sensor import RelativeSensor as RelativeSensor
    from contiga.simulation.sensor import Sensor as Sensor
    from contiga.simulation.settle import Settle as Settle
    from contiga.simulation.simulation import Simulation as Simulation
    from contiga.simulation.slave_sensor import NodeSensor as NodeSensor
    from contiga.simulation.slave_sensor import SectionSensor as SectionSensor
    from contiga.simulation.stored_result import StoredResult as StoredResult
    from contiga.simulation.stored_result import open_result as open_result
    from contiga.simulation.system_state import SystemState as SystemState
    from contiga.slaves.slave import Slave as Slave
    from contiga.statuses import Feature as Feature
    from contiga.statuses import Status as Status
    from contiga.studies.study import Study as Study
    from contiga.studies.study import study as study
    from contiga.triangles.trimesh import TriMesh as TriMesh


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
    elif name in _ROOMS:
        value = import_module(_ROOMS[name])
    else:
        raise AttributeError(f"module 'contiga' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
