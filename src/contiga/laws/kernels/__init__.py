"""Kernels of laws:

- friction_nb: the return to Coulomb's cone, and viscous friction
- curve_nb: forces of tables, elastic or between a loading and an unloading curve
"""
