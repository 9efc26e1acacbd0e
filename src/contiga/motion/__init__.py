"""Prescribed motion of bodies and slaves."""
