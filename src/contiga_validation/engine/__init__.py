"""Experiments with their claims and results, and the tables, pictures and pages of these."""
