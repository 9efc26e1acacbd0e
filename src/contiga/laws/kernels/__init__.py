"""Kernels of laws:

- curve_nb: forces of tables, elastic or between a loading and an unloading curve
"""
