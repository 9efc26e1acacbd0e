"""Kernels, in reading order: filters of signals.

- two_poles_nb: a filter of two poles, forward and backward
"""
