"""Curves: a force over a penetration, a stress over a strain, an area over time.

In reading order:

- tables: checks of a user's rows, whose first column rises
- curve_records: piecewise linear curves for kernels, and the results of kernels
- characteristic: one curve, a table, a number or a callable: value, slope, integral
- hysteresis: a force between a loading and an unloading curve
- kernels: the lookup in piecewise linear curves, and a step between two of them
"""
