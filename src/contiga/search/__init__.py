"""Feet and first hits of points on exact geometry."""
