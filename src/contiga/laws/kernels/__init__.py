"""Kernels of laws:

- friction_nb: the return to Coulomb's cone, and viscous friction
"""
