"""Curves: a force over a penetration, a stress over a strain, an area over time.

In reading order:

- tables: checks of rows that a user hands over, whose first column rises
- curve_records: piecewise linear curves as kernels take them, and the answers of kernels
- characteristic: one curve, a table, a number or a callable: value, slope, integral
- hysteresis: a force that unloads by another curve than it loads
- kernels: the lookup in piecewise linear curves, and a step between two of them
"""
