"""Contact of a slave with a master: detect, measure, respond, state."""
