"""Couple contacts of contiga with the steps of other codes.

Question: how do contacts of contiga act in a model that another code moves? Read `mujoco` (the
class and its step), `scene` and `parts` (contiga's part of the model), `carriers`, `kick` (forces
in a step), `stability` (its length), `result` and `folder`.
"""

from contiga.couple.mujoco import MujocoCoupling
from contiga.couple.result import MujocoResult

__all__ = ["MujocoCoupling", "MujocoResult"]
