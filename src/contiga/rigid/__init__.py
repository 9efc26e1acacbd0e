"""Rigid motions: poses, twists, screws, quaternions and inertia; signs as `contiga.conventions`."""
