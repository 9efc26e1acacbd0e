"""Runs: what is simulated, step by step, with what is written and resumed."""
