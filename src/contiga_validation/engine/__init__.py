"""Experiments, what they claim and find, and the tables, pictures and pages made of it."""
