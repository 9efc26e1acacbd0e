"""Shortest paths that stay outside exact bodies: how belts and strings run.

`route` is the public question, `Path` the answer. `start` finds a first polyline outside, `taut`
pulls it tight, `obstacles` asks the bodies.
"""
