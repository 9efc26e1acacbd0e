"""Couplings: contiga's contacts inside the steps of other codes.

Question: what do contacts of contiga do to a model that another code moves? Read `mujoco` (the
class, and its step), `scene` and `parts` (what contiga has of the model), `carriers`, `kick` (the
forces in a step), `stability` (its length), `result` and `folder`.
"""

from contiga.couple.mujoco import MujocoCoupling
from contiga.couple.result import MujocoResult

__all__ = ["MujocoCoupling", "MujocoResult"]
