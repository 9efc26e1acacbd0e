"""Contact, stepping, runs, checkpoints."""
