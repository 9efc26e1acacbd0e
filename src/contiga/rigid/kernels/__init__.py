"""Kernels, in reading order: rigid motion. Each stands on those before it.

- rigid_nb: rigid motion of many points: the same bits whatever the number of threads or rows
"""
