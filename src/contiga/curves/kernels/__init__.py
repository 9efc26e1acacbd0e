"""Kernels of curves:

- curve_nb: value, slope and integral of piecewise linear curves
- hysteresis_nb: a force between a loading and an unloading curve
"""
