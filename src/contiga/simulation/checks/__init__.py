"""What a model says that its author most likely did not mean, found before a run and after it."""
