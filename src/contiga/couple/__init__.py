"""Couplings: contiga's contacts inside the steps of other codes."""

from contiga.couple.mujoco import MujocoCoupling
from contiga.couple.result import MujocoResult

__all__ = ["MujocoCoupling", "MujocoResult"]
