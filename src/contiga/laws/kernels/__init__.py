"""Kernels of laws:

- friction_nb: the return mapping to Coulomb's cone, and viscous friction
"""
