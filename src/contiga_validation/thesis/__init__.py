"""The suite of the thesis: its chapters, run anew and set beside its own numbers."""
