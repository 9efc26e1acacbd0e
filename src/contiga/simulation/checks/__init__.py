"""Find what the author of a model most likely did not mean, before a run and after it."""
